// What the goal asks of the end state, worked out from the problem alone: the error, and independent rows with
// derivatives.
#pragma once

#include <optional>

#include "evidence/findings.hpp"
#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// Rotations asked for at the end, [bodies] body → world; nothing: free.
std::vector<std::optional<Matrix3d>> asked_rotations(const model::System& system, const maneuver::Problem& problem);

/// A joint that the goal tells how to end, child → parent.
struct AskedJoint {
  int joint;
  Matrix3d rotation;
};

/// Those that goal.angle and goal.shape tell, and those that keep their start's angles below joints of goal.angle.
std::vector<AskedJoint> asked_joints(const model::System& system, const maneuver::Problem& problem);

/// Largest miss over all goal rows: full rotation angle, rad, or displacement along an axis, m. Not of rest.
struct GoalMiss {
  double error = unset;
  std::string condition;  // the one that is missed so: "the end attitude of tail", "goal.move along e₁"
  bool is_turn = true;    // rad, not m
};
GoalMiss largest_miss(const StoredMotion& motion);

/// Largest difference of node 0 from the problem's start: full rotation angle, rad, or distance, m.
double start_error(const StoredMotion& motion);

/// Independent goal rows at an end state: log(R_askedᵀ R_N) by body, positions asked for, and, for rest, μ of each body
/// but the root (whose rest follows from zero total momentum), less what it carries where joints alone are to rest.
struct GoalRows {
  VectorXd value;         // [rows] rad, m, kg m²/s: 0 at the goal
  MatrixXd by_end_state;  // [rows][n] columns as integrator::StateLayout
  VectorXd unit;  // [rows] 1 rad, the swimmer's unit of length, or the given momentum scale: makes rows comparable
};

GoalRows goal_rows(const model::System& system, const maneuver::Problem& problem, const integrator::State& end,
                   double momentum_scale);

}  // namespace lamprey::evidence
