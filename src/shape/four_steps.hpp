// Steps between given shapes, four at once: a lane of the processor's vectors each. For ball joints without springs and
// dampers and for all others, by the trapezoid or the midpoint (chapter 9, equations 9.14 to 9.26). What any other swimmer or
// scheme asks is ShapeKernel's.
//
// At zero momentum the root's motion z = (turn φ, shift d) makes a step's discrete Lagrangian L stationary, so that the
// step is one function of its two shapes, V(θ, θ') = stat L(θ, θ', z): momenta are its gradient, tangents its second
// derivatives, curvature its third ones along the multipliers.
#pragma once

#include <array>

#include "optimizer/stage_program.hpp"
#include "shape/half_way.hpp"
#include "shape/led_turns.hpp"
#include "shape/shape_step.hpp"

namespace lamprey::shape {

/// One for each of four steps.
template <typename T>
using ForFour = std::array<T, 4>;

/// A node as effort sees it: moments along the joints' actuation, all of them and at no limit.
struct NodeEffort {
  double impulse_time;               // s, for which moments act
  double weight;                     // of ½|u|²
  const VectorXd& moment;            // [f] N m
  const MatrixXd& control_by_shape;  // [f][f] second derivative of the Lagrangian by moments and shape
};

class FourSteps {
 public:
  FourSteps(const model::System& system, mechanics::DiscreteLagrangian lagrangian, const MatrixXd& coordinates);

  /// Whether these are steps that it computes.
  static bool serves(const model::System& system, mechanics::DiscreteLagrangian lagrangian);

  /// Shapes at both ends: rotations seen from the root.
  void take_shapes(double time_step, const ForFour<const mechanics::Rotations*>& left,
                   const ForFour<const mechanics::Rotations*>& right);

  /// Finds the root's motion from the ones that the steps hold as guesses; then E⁻, E⁺ and total momentum. The steps'
  /// intervals are left as they are. Returns false where none is found.
  bool solve(const ForFour<ShapeStep*>& step);

  /// Tangents of solved steps under the moments at their ends.
  void tangent(const ForFour<const ShapeStep*>& step, const ForFour<const mechanics::Moments*>& control,
               const ForFour<const mechanics::Moments*>& control_next, const ForFour<ShapeTangent*>& tangent);

  /// Whether it takes the effort of moments, too: of swimmers whose joints are all moved along three axes, in all coordinates.
  bool takes_effort() const { return takes_effort_; }

  /// After `tangent` of the same steps, which go on from those before unless they are the first: how moments at the nodes
  /// where they begin answer the shapes before, at and after (equation 9.20).
  void find_moments(const ForFour<const NodeEffort*>& node, bool first);

  /// And what they cost: sets S, R, r and what is measured of the first `count` stages, adds to Q and q.
  void add_effort(const ForFour<const NodeEffort*>& node, int count, const ForFour<optimizer::Stage*>& stage);
  /// Of that the gradient alone: sets r and the first of q.
  void add_effort(const ForFour<const NodeEffort*>& node, int count,
                  const ForFour<optimizer::StageSlopes::Slope*>& stage);

  /// After `tangent` of the same steps: their Hessians as ShapeKernel::curvature gives them, but by the root's turn at the
  /// steps' ends (turn_at_end); into the first rows and columns of matrices that may be larger.
  void curvature(const ForFour<const ShapeStep*>& step, const ForFour<const mechanics::Moments*>& control,
                 const ForFour<const mechanics::Moments*>& control_next,
                 const ForFour<const ShapeMultipliers*>& multipliers, const ForFour<MatrixXd*>& hessian);

 private:
  using Four = mechanics::Four;
  using Four3 = mechanics::Four3;
  using Four33 = mechanics::Four33;
  // A body in four steps, seen from the root at their beginnings.
  template <typename S>
  struct Body {
    mechanics::ThreeByThree<S> left, right, shape;     // R, R', and Q' = F_0ᵀ R'
    mechanics::Three<S> shift;                         // m, Δx
    mechanics::Three<S> force;                         // N s, ∂L/∂Δx of its subtree
    mechanics::ThreeByThree<S> force_by_shift;         // of its own
    mechanics::ThreeByThree<S> subtree_by_shift;       // of its subtree
    mechanics::ThreeByThree<S> left_pull, right_pull;  // Rᵀ ∂²l/∂Δx∂η of its own, R'ᵀ ∂²l/∂Δx∂η'
    mechanics::ThreeByThree<S> by_left, by_right, by_both;  // ∂²l by η, η' twice, and by both (rows η, columns η')
  };
  template <typename S>
  struct Hessian {
    std::vector<Body<S>> body;                      // [bodies]
    std::vector<mechanics::ThreeByThree<S>> block;  // [blocks] squared, rows differentiated first
  };
  // What solving takes of a body.
  struct Momenta {
    Four33 right;            // R'
    Four3 shift, arm;        // m, Δx, and from the root's centre at the end
    Four3 right_seen;        // m, R'ᵀ Δx, by the trapezoid
    HalfWay<Four> half_way;  // by the midpoint
    Four3 own, force;        // N s, ∂l/∂Δx of its own, of its subtree
    Four3 left_turn;         // N m s, what Δx gives ∂l/∂η
    Four3 turn;              // N m s, ∂L/∂η'
  };
  // Second derivatives of a body's own Lagrangian by its turn at the right end and by Δx, seen from the world.
  struct RightEnd {
    Four33 by_shift, shift_by_turn, by_turn;
  };
  // An angle with a spring or a damper.
  struct CompliantAngle {
    int joint, freedom;
    int place;                  // among the coordinates
    double stiffness, damping;  // N m/rad, N m s/rad
    Four left, right, turn;     // rad, at both ends and between
  };
  // The root's part of the Hessian, inverted by halves.
  struct RootInverse {
    Four33 shift_by_turn;  // lower left block of the Hessian
    Four33 turn_inverse, shift_inverse;
    void apply(Four3& turn, Four3& shift) const;
  };

  int shapes() const { return system_.body_count() - 1; }
  int blocks() const { return 2 * shapes() + 2; }
  int at_left(int body) const { return body - 1; }
  int at_right(int body) const { return body == 0 ? 2 * shapes() : shapes() + body - 1; }
  int at_shift() const { return 2 * shapes() + 1; }
  std::size_t place(int row, int column) const { return model::at(row * blocks() + column); }

  void take_compliant_angles(const ForFour<const mechanics::Rotations*>& left,
                             const ForFour<const mechanics::Rotations*>& right);
  void add_compliant_momenta(Four* along) const;
  void add_compliant_rates(Four* form) const;
  void take_root(const ForFour<const ShapeStep*>& step);
  void find_momenta(Four& scale);
  RightEnd right_end(int i) const;
  void find_root_inverse();
  Four3 momentum_at_left(int body) const;
  void read_momenta(const ForFour<ShapeStep*>& step);
  template <typename S>
  void lay_shifts(const mechanics::Three<S>& of_root, Hessian<S>& hessian) const;
  template <typename S>
  void differentiate(Hessian<S>& hessian) const;
  template <typename S>
  void differentiate_body(int i, Body<S>& body) const;
  template <typename S>
  void translate_at_ends(int i, Body<S>& body) const;
  template <typename S>
  void translate_half_way(int i, Body<S>& body) const;
  template <typename S>
  void add_up_tree(int j, Hessian<S>& hessian) const;
  template <typename S>
  void turn_all_with_root(Hessian<S>& hessian) const;
  void eliminate_root();
  template <typename Add>
  void for_moments_of_ball_joints(const ForFour<const mechanics::Moments*>& control, bool right, const Add& add) const;
  void add_moments(const ForFour<const mechanics::Moments*>& control, bool right);
  void add_moment_curvature(const ForFour<const mechanics::Moments*>& control, bool right);
  void find_gradient();
  void find_gradient_change(const Four3& of_turn, const Four3& of_shift);
  void spread_multipliers(const ForFour<const ShapeMultipliers*>& multipliers);
  void lay(const std::vector<Four33>& form, std::vector<Four>& to) const;
  void project_ends(int rows, const std::vector<Four>& by_bodies, std::vector<Four>& by_coordinates) const;
  void project_form(const std::vector<Four>& by_bodies, std::vector<Four>& by_coordinates);
  void bend_tangent(const ForFour<const mechanics::Moments*>& control,
                    const ForFour<const mechanics::Moments*>& control_next);
  void bend_curvature(const ForFour<const mechanics::Moments*>& control,
                      const ForFour<const mechanics::Moments*>& control_next);
  void let_fields_turn(bool right);
  template <typename Add>
  void for_moments_on_turning_parents(const ForFour<const mechanics::Moments*>& control, const Add& add) const;
  LedTurns& led(bool right) { return right ? led_right_ : led_left_; }
  Four* bend_of(bool right) { return bend_.data() + (right ? led_left_.size() * (2 * led_left_.size() + 1) : 0); }
  void flatten_form();
  void flatten_answers(const std::vector<Four33>& turn, const std::vector<Four33>& shift);
  void add_pose(const ForFour<const ShapeStep*>& step, const ForFour<const ShapeMultipliers*>& multipliers,
                const ForFour<MatrixXd*>& hessian);
  void write(Eigen::Index all_rows, Eigen::Index first, Eigen::Index rows, double factor, const ForFour<double*>& to,
             Eigen::Index stride) const;
  void weigh_moments(const ForFour<const NodeEffort*>& node);
  template <typename Slopes>
  void write_gradient(const ForFour<const NodeEffort*>& node, int count, const ForFour<Slopes*>& stage);
  void write_blocks(const std::vector<Four33>& blocks, int width, int row, int rows, int column, int columns, int count,
                    const ForFour<MatrixXd*>& to, bool add) const;
  void write_tangents(const ForFour<const ShapeStep*>& step, const ForFour<ShapeTangent*>& tangent);

  const model::System& system_;
  bool at_half_way_;      // the midpoint, else the trapezoid
  MatrixXd coordinates_;  // [shape_size][f]
  bool all_coordinates_;
  MomentumNoise noise_;
  double time_step_ = 0.0;
  std::vector<Four33> left_, right_;  // [bodies] shapes
  Four33 turn_;                       // F_0
  Four3 shift_;                       // d
  std::vector<Momenta> momenta_;      // [bodies]
  RootInverse root_;
  Hessian<Four> second_;
  Hessian<algebra::DualFour> third_;
  std::vector<Four33> answer_turn_, answer_shift_;  // [2 (bodies − 1)] Z: how the root's motion answers shapes
  std::vector<Four33> form_;                        // [2 (bodies − 1)] squared: second derivatives of V, moments held
  std::vector<Four33> symmetric_;                   // likewise: of V without moments, symmetric
  std::vector<Four33> pose_turn_, pose_shift_;      // [2 (bodies − 1)] Z seen from the world
  std::vector<Four33> half_turn_, half_shift_;      // [2 (bodies − 1)]
  std::vector<Four33> by_turn_;                     // [2 (bodies − 1)] rows of shapes, columns of the root's turn
  std::vector<Four3> shape_vector_;                 // [2 (bodies − 1)] momenta or multipliers along both shapes
  bool takes_effort_;
  std::vector<Four33> plus_;  // [bodies − 1][2 (bodies − 1)] of E⁺ by shapes, of the latest steps
  // [bodies − 1][3 (bodies − 1)] moments by the shapes k − 1, k, k + 1: rows of joints, and of bodies or weighed
  std::vector<Four33> moment_, weighed_;
  std::vector<Four33> moment_form_;  // [3 (bodies − 1)] squared
  std::vector<Four33> by_control_;   // [bodies − 1] squared
  std::vector<Four> flat_, half_;    // column after column
  // where joints lead their children
  LedTurns led_left_, led_right_;
  std::vector<CompliantAngle> compliant_;
  std::vector<Four3> gradient_,
      gradient_change_;              // [2 (bodies − 1)] of V by the bodies' turns, and along the multipliers
  std::vector<Four> along_;          // [2 n] multipliers along the coordinates
  std::vector<Four> bend_;           // [2 n] squared: what coordinates that bend add to the form
  std::vector<Four> seen_, turned_;  // [6 (bodies − 1)][2 n], [2 n] squared
};

}  // namespace lamprey::shape
