// Limits and waypoints as terms of the cost: an augmented Lagrangian with a multiplier for each row and node, so that the
// search stays one over free shapes (equations 10.5 to 10.7).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "maneuver/limit_rows.hpp"
#include "maneuver/shape_turns.hpp"

namespace lamprey::maneuver {

/// Where the worst of the limits stands.
struct LimitError {
  double value = 0.0;  // largest |min(g, λ/weight)|, of equalities |g|; in units of the rows
  int row = -1;
  int node = -1;
};

/// Multipliers between searches: a density in time for limits, a number for waypoints.
struct LimitMultipliers {
  MatrixXd value;       // [rows][N + 1] (N m)², waypoints (N m)² s; not negative but for waypoints
  double weight = 0.0;  // the same: of ½ g² where a row is violated; 0: not chosen yet
  double largest_weight = 0.0;
};

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

  bool empty() const { return rows_.empty(); }
  /// Without rows of no size.
  LimitModel model_of_size() const;
  const std::vector<LimitRow>& rows() const { return rows_; }

  /// Values of all rows at a node, [rows]; infinite where a row does not apply.
  void measure(int node, const LimitedNode& at, Eigen::Ref<VectorXd> value) const;
  /// What a node's values add to the cost.
  double cost(int node, const Eigen::Ref<const VectorXd>& value) const;
  /// Adds the derivatives of `cost` by the node's moments, [controls], squared.
  void add_by_moments(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, VectorXd& gradient,
                      MatrixXd& hessian);
  /// Derivatives of `cost` by the node's shape and pose.
  void model(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, LimitModel& model);

  LimitError error(const MatrixXd& value) const;
  /// Multipliers at the point with these values, [rows][N + 1]; where `heavier`, the weight rises if the error has not fallen.
  /// Returns whether it falls: once limits are met, to what keeps round-off in the rows out of the multipliers.
  bool renew(const MatrixXd& value, bool heavier);
  const LimitMultipliers& multipliers() const { return multipliers_; }
  /// Takes over multipliers of another grid, or chooses the first weight by a cost.
  void take(const LimitMultipliers& from, double cost);

 private:
  bool applies(const LimitRow& row, int node) const { return maneuver::applies(row, node, steps_, duration_); }
  double node_time(const LimitRow& row, int node) const { return counted_time(row, node, steps_, duration_); }
  double pull(std::size_t row, int node, double value) const;
  void add_row(double time, double pulled, VectorXd& gradient, MatrixXd& hessian) const;
  void add_rows(int node, const LimitedNode& at, const Eigen::Ref<const VectorXd>& value, LimitModel& model);
  void map_bodies(const LimitedNode& at);
  void add_curvatures(const LimitedNode& at, LimitModel& model);

  const model::System& system_;
  std::vector<LimitRow> rows_;
  MatrixXd shape_basis_, pose_basis_;
  int steps_;
  double duration_;
  bool before_ = false;  // whether any row looks at the node before
  LimitMultipliers multipliers_;
  double last_error_ = 0.0;
  ShapeTurns turns_;
  // workspace
  VectorXd by_bodies_, slope_;   // [body_coordinates] gradient of all rows and of one, [controls] for moments
  MatrixXd bend_bodies_, bend_;  // likewise squared
  MatrixXd map_,
      transposed_;  // [body_coordinates][2 f + p + 1] by (shape before, shape, pose, logarithm), its transpose
  MatrixXd bent_;   // [body_coordinates][2 f + p + 1]
  MatrixXd turn_shape_, mixed_;  // [3][f], [p][f]
  VectorXd angle_;               // [f]
};

}  // namespace lamprey::maneuver
