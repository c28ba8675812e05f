// Limits and waypoints as terms of the cost, so that the search stays one over free shapes: limits by a barrier on slacks that an
// augmented Lagrangian ties to them, whose multipliers are unknowns of Newton's method of their own; waypoints by the augmented
// Lagrangian alone (equations 10.5 to 10.7).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "maneuver/limit_rows.hpp"
#include "optimizer/stage_program.hpp"
#include "shape/shape_turns.hpp"

namespace lamprey::shape {

using maneuver::applies;
using maneuver::counted_time;
using maneuver::LimitedNode;
using maneuver::LimitRow;
using maneuver::ShapeCoordinates;

/// Where the worst of the limits stands.
struct LimitError {
  double value = 0.0;  // largest −g, of equalities |g|, in units of the rows; or what λ g has to do with the cost
  int row = -1;
  int node = -1;
};

/// Multipliers between searches: a density in time for limits, a number for waypoints.
struct LimitMultipliers {
  MatrixXd value;       // [rows][N + 1] (N m)², waypoints (N m)² s; not negative but for waypoints
  double weight = 0.0;  // the same: of ½ (g − slack)², of waypoints ½ g²; 0: not chosen yet
  double largest_weight = 0.0;
};

/// Those of a problem's rows for the rows of another, which has limits more or fewer: 0 where it had none.
LimitMultipliers of_rows(const LimitMultipliers& from, const std::vector<LimitRow>& held,
                         const std::vector<LimitRow>& rows);

/// What limits add to the model of a node.
struct LimitModel {
  bool any = false;
  MatrixXd Q;     // [2 f + p + 1] squared, by (shape before, shape, pose, logarithm of the time step)
  VectorXd q;     // [2 f + p + 1]
  Vector3d turn;  // gradient by the swimmer's world turn, by its position
  Vector3d shift;
};

class LimitTerms {
 public:
  LimitTerms(const model::System& system, std::vector<LimitRow> rows, const ShapeCoordinates& coordinates, int steps,
             double duration);

  /// Takes over another duration, s. Not with waypoints: their nodes stay.
  void take_duration(double duration) { duration_ = duration; }

  /// Takes over other bounds of a free duration, s.
  void bound_duration(double least, double most);

  bool empty() const { return rows_.empty(); }
  bool of_moments() const { return of_moments_; }
  /// Without rows of no size.
  LimitModel model_of_size() const;
  const std::vector<LimitRow>& rows() const { return rows_; }

  /// Values of all rows at a node, [rows]; infinite where a row does not apply.
  void measure(int node, const LimitedNode& at, Eigen::Ref<VectorXd> value);
  /// What a node's values add to the cost; adds to its round-off that of the values.
  double cost(int node, const Eigen::Ref<const VectorXd>& value, double& round_off) const;
  /// Adds the derivatives of `cost` by the node's moments, [controls], squared: the gradient, and the Hessian that the
  /// multipliers' own Newton step makes of it.
  void add_by_moments(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, VectorXd& gradient,
                      MatrixXd& hessian);
  /// The same by the node's shape and pose.
  void model(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, LimitModel& model);

  /// Change of the rows' values to first order along a step from the point of the models, for share_within and follow: by the node's
  /// shape before, shape, pose and logarithm of the time step, [≥ 2 f + p] (without the logarithm where it does not change), and
  /// by its moments, [controls].
  void foresee(int node, const Eigen::Ref<const VectorXd>& state, const Eigen::Ref<const VectorXd>& moments);
  const MatrixXd& changes() const { return change_; }
  /// Share of the step foreseen that leaves every slack some of its length, or, but for gaps, a larger one, up to where slacks that are
  /// held as they are there, and not as the model has it, leave nothing more of what the model promises.
  double share_worth(const MatrixXd& value, const optimizer::Promise& promise) const;
  /// After foresee: what the rows changed by beyond first order on the way to a trial point, a share of the step away.
  void compare(const MatrixXd& value, const MatrixXd& trial, double share);
  /// What that, times a factor, adds to the gradient of a node's model: to its first `size` entries, in the order of `foresee`.
  void add_bend(int node, double factor, Eigen::Index size, VectorXd& by_state) const;
  void add_bend_by_moments(int node, double factor, VectorXd& by_moments) const;
  /// The multipliers' part of the step, taken by a share of it.
  void follow(double share);

  /// Where a row is broken most.
  LimitError violation(const MatrixXd& value) const;
  /// The same, and where a limit pulls though it is not reached.
  LimitError error(const MatrixXd& value) const;
  /// At the answer of a search: multipliers as they are there, a weaker barrier and a larger weight from now on.
  void renew(const MatrixXd& value, double cost);
  /// From now on no barrier: limits whose multipliers have outlasted the barrier's last fall are equalities, others have no part.
  /// `renew` then changes which are, where they pull the wrong way or are broken.
  void land(const MatrixXd& value);
  bool landed() const { return landed_; }
  /// Makes the weight of limits that are equalities so many times larger.
  void weigh(double times) { worth_.equality_weight *= times; }
  /// Back to a barrier, at the values and with the multipliers that were left by `land`.
  void take_off(const MatrixXd& value);
  /// Keeps multipliers, weights and barrier, and takes them back.
  void keep() { kept_ = worth_; }
  void take_kept() { worth_ = kept_; }
  const LimitMultipliers& multipliers() const { return worth_.multipliers; }
  /// Takes over multipliers of another grid, or chooses the first barrier and weight by a cost.
  void take(const LimitMultipliers& from, double cost);
  /// Whether multipliers came from an answer on as many steps.
  bool pull_as_answer() const { return carried_ && same_grid_; }
  /// Makes them weaker by so many times, up to those of a first guess; returns false where they are those.
  bool ease(double times);
  /// A barrier and a weight fit for a point with these values.
  void begin(const MatrixXd& value);

 private:
  bool applies(const LimitRow& row, int node) const { return maneuver::applies(row, node, steps_, duration_); }
  /// Of `land`: which limits are equalities.
  void hold_those_that_pull(const MatrixXd& value);
  double node_time(const LimitRow& row, int node) const { return counted_time(row, node, steps_, duration_); }
  Vector3d& across(std::size_t row, int node) { return across_[row * model::at(steps_ + 1) + model::at(node)]; }
  /// Time that a row's multipliers, barrier and weight are for: 1 of those with a density in time.
  double time_unit(const LimitRow& row) const { return row.time >= 0.0 || row.of_duration() ? duration_ : 1.0; }
  // A row's pull p on the row, −∂p/∂s and the stiffness −∂p/∂g, and what it all adds to the cost.
  struct Hold {
    double pull, by_slack, stiffness, cost;
  };
  // A row's own derivatives, [body_coordinates] or, of moments, [controls]: each has its own, whose size stays.
  struct RowDerivatives {
    VectorXd slope;
    MatrixXd bend;  // squared
    explicit RowDerivatives(Eigen::Index size) : slope(size), bend(size, size) {}
  };
  Hold hold(std::size_t row, int node, double value) const;
  Hold hold_in_model(std::size_t row, int node, double value);
  double share_within(const MatrixXd& value, double broken) const;
  double gain_rate(const MatrixXd& value, const optimizer::Promise& promise, double share) const;
  double largest() const;  // (N m)², multiplier
  double bearable(double weight) const;
  void set_level(double level, double barrier);
  void come_nearer(double broken, double cost);
  void begin_near(const MatrixXd& value, double least_level, double least_barrier);
  bool tied(std::size_t row, int node) const;
  static void add_row(double time, const Hold& held, const RowDerivatives& row, VectorXd& gradient, MatrixXd& hessian);
  void add_rows(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, LimitModel& model);
  void map_bodies(const LimitedNode& at);
  void add_curvatures(const LimitedNode& at, LimitModel& model);

  // What limits are worth to a search.
  struct Worth {
    LimitMultipliers multipliers;  // λ, of the augmented Lagrangian
    MatrixXd estimate;             // [rows][N + 1] (N m)² z, the multipliers of Newton's method
    MatrixXd before_fall;          // [rows][N + 1] multipliers
    double base = 0.0;             // (N m)², the cost over the duration
    double level = 0.0;            // units of the rows, how far searches let them be off
    double barrier = 0.0;          // (N m)² μ
    double fallen = 1.0;           // share of the barrier that its last fall has left
    double equality_weight = 0.0;  // (N m)²
    double broken = 0.0;           // units of the rows, by how much limits were broken at the last search's answer
    bool taken_off = false;        // after a landing: what the search finds now is the answer
  };

  const model::System& system_;
  std::vector<LimitRow> rows_;
  MatrixXd shape_basis_, pose_basis_;
  int steps_;
  double duration_;
  bool before_ = false;      // whether any row looks at the node before
  bool of_moments_ = false;  // whether any row is of moments
  Worth worth_, kept_;
  bool carried_ = false;                 // whether multipliers came from an answer
  bool same_grid_ = false;               // on as many steps
  MatrixXd pull_, stiffness_;            // [rows][N + 1] (N m)² of the models
  MatrixXd change_;                      // [rows][N + 1] foreseen
  MatrixXd beyond_;                      // [rows][N + 1] what rows changed by beyond, times stiffness and time
  std::vector<MatrixXd> slopes_;         // [N + 1][rows][2 f + p + 1] of the models, rows of moments aside
  std::vector<MatrixXd> moment_slopes_;  // [N + 1][rows][controls], where there are rows of moments
  bool landed_ = false;
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> holds_;  // [rows][N + 1] limits that are equalities, where landed
  MatrixXd before_landing_;                                   // [rows][N + 1] multipliers
  std::vector<Vector3d> across_;                              // [rows · (N + 1)] world frame, of gaps: see limit_value
  ShapeTurns turns_;
  // workspace
  RowDerivatives by_body_, by_moment_;
  VectorXd by_bodies_;    // [body_coordinates] gradient of all rows
  MatrixXd bend_bodies_;  // likewise squared
  MatrixXd map_,
      transposed_;  // [body_coordinates][2 f + p + 1] by (shape before, shape, pose, logarithm), its transpose
  MatrixXd bent_;   // [body_coordinates][2 f + p + 1]
  MatrixXd turn_shape_, mixed_;  // [3][f], [p][f]
  VectorXd angle_;               // [f]
  VectorXd along_;               // [2 f + p + 1]
};

}  // namespace lamprey::shape
