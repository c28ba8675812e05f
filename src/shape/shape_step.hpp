// One step as the shapes at its two ends dictate it: with the total momentum they fix how the root moves meanwhile, and with it
// the momenta of the joints at both ends (chapter 9, equations 9.1 to 9.9 and 9.34 to 9.36).
#pragma once

#include <Eigen/LU>
#include <cmath>

#include "maneuver/shape_coordinates.hpp"
#include "mechanics/step_hessian.hpp"

namespace lamprey::shape {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::Matrix6d;
using maneuver::Vector6d;

/// What round-off leaves of a step's total momentum.
struct MomentumNoise {
  static constexpr double of_sums = 1e-14;  // of the largest momentum: as near to zero as sums of it come
  explicit MomentumNoise(const model::System& system);
  /// What that of rotations makes of it.
  double of_rotations(double time_step) const { return 1e-14 * inertia / std::abs(time_step); }
  double length;         // m, by which linear momenta count beside angular ones
  double inertia = 0.0;  // kg m², the largest about the root
};

/// A step between two shapes. The root's motion over it is seen from the root at its beginning.
struct ShapeStep {
  Matrix3d root_turn = Matrix3d::Identity();     // F_0
  Vector3d root_shift = Vector3d::Zero();        // m, displacement of its mass centre
  Matrix6d momentum_inverse = Matrix6d::Zero();  // of ∂(momentum)/∂(root's turn, shift), old or new; zero: not known
  mechanics::Interval interval;          // updated, world; of four steps at once, the root's turns and shift alone
  VectorXd minus;                        // [f] E⁻ along the coordinates at its beginning without controls
  VectorXd plus;                         // [f] E⁺ at its end
  Vector6d momentum = Vector6d::Zero();  // total, about the root's mass centre, seen from the root at its beginning
  Vector6d carried = Vector6d::Zero();   // what it was to be: the rest is round-off
  double largest_momentum = 0.0;         // |E⁻| of any body
  explicit ShapeStep(const model::System& system) : interval(system.body_count()) {}
  /// Keeps of its interval the root's rotations and displacement alone.
  static ShapeStep of_root();

 private:
  explicit ShapeStep(mechanics::Interval kept) : interval(std::move(kept)) {}
};

/// Whether swimmers may carry momentum. Seen from its root one that carries none moves alike wherever the root is; of one that
/// does the root's pose says what is carried. Where time is free it is the impulses of a step that matter: what is carried over a
/// longer step is more of it.
enum class TotalMomentum { zero, any, any_in_free_time };

/// First derivatives of a step by the shapes (left, right) at its ends and, where momentum is carried, by the root's world turn
/// and position at its beginning, and where time is free by the logarithm of what is carried, time step and controls at its
/// ends held: d = 2 f, 2 f + 6 or 2 f + 7.
struct ShapeTangent {
  MatrixXd pose;   // [6][d] what the step adds to the root's turn and position, world
  MatrixXd minus;  // [f][d]
  MatrixXd plus;   // [f][d]
};

/// Multipliers of a step's relations: what its curvature is contracted with.
struct ShapeMultipliers {
  const VectorXd& minus;  // [f] of E⁻ along the coordinates
  const VectorXd& plus;   // [f] of −E⁺ along them
  Vector3d turn;          // of the root's world orientation at the end
  Vector3d shift;         // of the root's world position at the end
};

/// Evaluates steps; one for each thread.
class ShapeKernel {
 public:
  ShapeKernel(const model::System& system, mechanics::DiscreteLagrangian lagrangian, const MatrixXd& coordinates,
              TotalMomentum carries = TotalMomentum::zero);

  /// Finds the root's motion from the one that the step holds as a guess, from rotations `left` (world) to `next_shape`;
  /// then E⁻ and E⁺. Returns false where none is found. `total`: momentum that the swimmer carries, as ShapeStep has it.
  bool solve(double time_step, const mechanics::Rotations& left, const mechanics::Rotations& next_shape,
             ShapeStep& step, const Vector6d& total = Vector6d::Zero());

  /// Tangent of a solved step under the moments at its ends; renews its momentum_inverse.
  void tangent(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
               ShapeStep& step, ShapeTangent& tangent);

  /// After `tangent` of the same step: Hessian of minus·E⁻ − plus·E⁺ + turn·(root's world turn) + shift·(its world
  /// position) by (left shape, right shape, world turn ρ of the whole swimmer at the beginning), shapes moving along
  /// exponentials, momentum zero throughout: [2 f + 3] squared. Where momentum is carried, total momentum held: by the root's
  /// position at the beginning as well, and as tangents are by the logarithm of what is carried, d squared.
  void curvature(double time_step, const mechanics::Moments& control, const mechanics::Moments& control_next,
                 const ShapeStep& step, const ShapeMultipliers& multipliers, MatrixXd& hessian);

 private:
  void find_levers(const mechanics::Rotations& left);
  Vector6d momentum(const mechanics::Interval& interval, double& scale) const;
  void learn_inverse(const Vector6d& moved, const Vector6d& change, Matrix6d& inverse) const;
  void read_balance(const mechanics::ForcedStep& forced, ShapeStep& step);
  void measure_rates(const mechanics::ForcedStep& forced, const ShapeStep& step);
  bool find_momentum_inverse(ShapeStep& step) const;
  void lay_multiplier(const ShapeStep& step, const Vector6d& pi, const ShapeMultipliers& multipliers);
  void add_changes_of_coefficients(const ShapeStep& step, const Vector3d& spin);
  void read_second_rates(const ShapeStep& step);
  void assemble_hessian(MatrixXd& hessian);
  void find_carried(const ShapeStep& step);
  void add_changes_of_carried(const ShapeStep& step, const Vector6d& pi, const Vector3d& turn, const Vector3d& shift,
                              MatrixXd& hessian) const;
  void pack(const mechanics::Rows3& rows, int coordinate, Eigen::Ref<VectorXd> column) const;
  void project_rows(const mechanics::FreedomRows& rows, MatrixXd& result);
  void project(const mechanics::Freedoms& freedoms, VectorXd& coordinates);
  void spread(const VectorXd& coordinates, mechanics::Freedoms& freedoms);
  bool free(int body) const { return system_.body(body).freedoms == 3; }
  bool all_coordinates() const { return shape_ == along_.size(); }

  const model::System& system_;
  mechanics::DiscreteLagrangian lagrangian_;
  MatrixXd coordinates_;  // [shape_size][f]
  MomentumNoise noise_;
  int shape_;               // f
  Eigen::Index by_;         // d: shapes and, where momentum is carried, the root's pose; in free time its logarithm
  int directions_;          // left shape, right shape, root's turn, root's shift
  Eigen::Index left_rows_;  // of the left shape, padded; those of the others follow
  Eigen::Index rows_;       // of all directions
  mechanics::Moments no_moments_;
  mechanics::StepBalance balance_;
  std::vector<mechanics::BodyBlock> block_;      // [bodies]
  std::vector<mechanics::BodyRates> body_rate_;  // [bodies]
  mechanics::StepDirections direction_;
  mechanics::StepJacobian rate_;
  mechanics::StepHessian second_;
  mechanics::Rows3 angular_, linear_;          // [rows] of the whole swimmer
  MatrixXd minus_, plus_;                      // [directions][f]
  MatrixXd momentum_;                          // [directions][6]
  MatrixXd root_;                              // [d][6] how the root's motion answers
  MatrixXd pose_;                              // [d][6] the same in the world
  MatrixXd ends_;                              // [d][f]
  Vector3d angular_carried_, linear_carried_;  // world, about the root at the beginning
  mechanics::StepVariation multiplier_;
  mechanics::StepRate multiplier_rate_;
  mechanics::Rotations next_;         // [bodies] world
  mechanics::Vectors lever_;          // [bodies] m, from the parent's mass centre to the body's, world
  VectorXd along_;                    // [shape_size]
  MatrixXd along_rows_;               // [directions][shape_size]
  MatrixXd by_left_, by_right_;       // [directions][f] how the gradient by the shapes changes along the directions
  MatrixXd by_root_;                  // [directions][6] the same by the root's motion
  MatrixXd left_left_, left_half_;    // [shape_size] squared, [shape_size][f]
  MatrixXd turn_right_, turn_shape_;  // [shape_size][3], [f][3]
  MatrixXd ends_root_;                // [d][6]
};

/// Where the root's motion over a solved step takes all bodies from rotations `rotation`; the step's interval learns the
/// root's rotations and displacement.
void follow_root(const mechanics::Rotations& rotation, const mechanics::Rotations& next_shape, ShapeStep& step,
                 mechanics::Rotations& next_rotation);

/// Whether a body turns by more than a quarter turn in a step, or numbers are none: beyond it steps do not show motions.
bool turns_too_far(const mechanics::Rotations& from, const mechanics::Rotations& to);

/// Largest difference of a motion's solved steps from the total momentum that it has to carry, angular about where it begins or linear
/// times the swimmer's length unit, against the largest momentum of any body and against it; rotations and positions at the steps' beginnings.
double momentum_left(const model::System& system, const std::vector<ShapeStep>& steps,
                     const std::vector<mechanics::Rotations>& rotation, const mechanics::Vectors& position,
                     const mechanics::SpatialMomentum& total = {});

}  // namespace lamprey::shape
