// Solution: a motion and how it was found, in the words and shapes of solution.json.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamprey::maneuver {

enum class Status { optimal, simulated, feasible, infeasible, stalled, time_limit, interrupted };

using Vectors = std::vector<Eigen::Vector3d>;

/// Momentum at the nodes, world frame; angular about the world origin.
struct MomentumHistory {
  Vectors bodies;  // [N+1] with mass and body_inertia alone; kg m/s or kg m²/s
  Vectors fluid;   // [N+1] the rest
  Vectors total;   // [N+1] the conserved discrete momentum at the node
};

struct SolverIteration {
  int iteration = 0;
  double cost = 0.0;
  double goal_error = 0.0;
  double kkt = 0.0;
  double step = 0.0;
  double momentum =
      std::numeric_limits<double>::quiet_NaN();  // largest total momentum of the iterate less the start's / its scale
};

/// What a square weighs in the cost where multipliers are being found; 0: there are none.
struct MultiplierWeight {
  double value = 0.0;
  double largest = 0.0;  // that the search would take
};

struct SolverRecord {
  std::string name;
  int iterations = 0;
  int evaluations = 0;
  double wall_seconds = 0.0;        // of the search
  double total_wall_seconds = 0.0;  // with certificates, other grids and feedback; 0: not known
  double processor_seconds = std::numeric_limits<double>::quiet_NaN();  // of all threads and worker processes
  std::vector<SolverIteration> history;
  MultiplierWeight limit_weight;               // (N m)², of limits, for a Solver to go on with
  MultiplierWeight work_weight;                // 1/W, of powers, likewise
  std::optional<double> held_joint_rate = {};  // rad/s, to which joints were held where more is allowed; not in files
};

struct Minimum {
  double cost = 0.0;
  int count = 0;
  std::optional<int> by_ipopt = {};  // of the count, where both solvers searched
};

/// The cheapest motion that costs less than the answer, and that the steps do not resolve.
struct SetAside {
  double cost = 0.0;
  std::optional<int> steps = {};  // that would resolve it; nothing: not known
};

struct SearchRecord {
  int starts = 0;
  int strokes = 0;  // of the starts, those that begin with many strokes
  int hops = 0;     // solves from perturbed copies of the best minimum
  int solved = 0;
  std::vector<Minimum> minima;  // by rising cost
  std::optional<SetAside> set_aside = {};
};

/// Where a march had to divide its steps; empty for motions that were not marched so.
struct DividedSteps {
  int steps = 0;               // steps of the problem that were divided
  int substeps = 0;            // into how many, in all
  double smallest_step = 0.0;  // s, of the substeps
};

/// What a limit or a waypoint costs at the nodes: by how much the cost would fall for each unit that the limit gave way,
/// density in time; of waypoints, at their node alone.
struct LimitMultiplier {
  std::string key;                 // of the problem file
  int joint = -1;                  // index, −1: none
  int body = -1;                   // index, −1: none
  int other_body = -1;             // the second of a pair
  int component = -1;              // of a moment, a position or a turn; number of a sphere or half-space
  bool upper = false;              // of two bounds the upper one
  std::vector<double> multiplier;  // [N+1] (N m)² for each N m, rad, rad/s, m or s of the limit
};

/// How moments answer deviations from the motion: u = u* + K s, with s as integrator::deviation has it.
struct Feedback {
  std::vector<double> time;           // [M+1] s, from the motion's start to its end; gains run linearly between
  std::vector<Eigen::MatrixXd> gain;  // [M+1][controls][2 velocity_count] N m by rad, m, rad/s, m/s; none: no feedback
};

/// How a march with feedback kept to the maneuver that it follows.
struct Tracking {
  std::string maneuver;                 // its name
  double rotation_error = 0.0;          // rad, of a body, at the end
  double position_error = 0.0;          // m, of the root's mass centre, at the end
  double largest_rotation_error = 0.0;  // rad, at any node
  double largest_position_error = 0.0;  // m, at any node
  double largest_correction = 0.0;      // N m, of a joint's moment against the planned one, at any node
  double cut_share = 0.0;               // of the times at which moments were asked for: limits of torque cut some
  std::optional<double> cut_from = {};  // s, the first of these times
  std::optional<double> off_from = {};  // s, when a body was first farther off than gains about the plan surely answer
  /// Whether the swimmer was farther off than gains about the plan can mean, and did not come back.
  bool lost() const { return largest_rotation_error > 0.5 && rotation_error > 0.1; }
  /// Whether moments were cut before: motors at their limits are why, if anything is.
  bool cut_first() const { return cut_from && (!off_from || *cut_from < *off_from); }
};

/// What a motion costs by each measure, before weighting.
struct CostParts {
  double effort = 0.0;            // (N m)² s, ∫ ½ Σ_j |u_j|² dt
  double work = 0.0;              // J, ∫ Σ_j |u_j·ω_j| dt
  double power = 0.0;             // W² s, ∫ Σ_j (u_j·ω_j)² dt
  double smoothness = 0.0;        // (N m)²/s, ∫ ½ Σ_j |du_j/dt|² dt
  double angular_velocity = 0.0;  // rad²/s, ∫ ½ Σ_j |ω_j|² dt
  double time = 0.0;              // s
  double transport = 0.0;         // J/m, work per distance; NaN where there is none
};

/// J/m; NaN where the distance is no way beside the swimmer's length unit, m, but round-off.
inline double work_per_distance(double work, double distance, double length_unit) {
  constexpr double least = 1e-12;
  return distance > least * length_unit ? work / distance : std::numeric_limits<double>::quiet_NaN();
}

struct Solution {
  Status status = Status::stalled;
  std::string message;
  double cost = 0.0;                                   // by the file's rule, (N m)² s; NaN where it has no meaning
  std::optional<CostParts> cost_parts;                 // where more than effort and time is asked for
  std::vector<double> time;                            // [N+1] s
  Vectors position;                                    // [N+1] m, root's mass centre, world
  std::vector<std::vector<Eigen::Matrix3d>> rotation;  // [N+1][bodies] body → world
  std::vector<Vectors> control;                        // [N+1][joints] N m, on the parent, parent's frame
  std::vector<Vectors> joint_angle;                    // [N+1][joints] rad, as mechanics::turn_from_zero has them
  Vectors linear_velocity;                             // [N+1] m/s of the root, root frame
  std::vector<Vectors> angular_velocity;               // [N+1][bodies] rad/s, body frames
  MomentumHistory linear_momentum;                     // kg m/s
  MomentumHistory angular_momentum;                    // kg m²/s
  std::vector<std::vector<double>> stage_time;         // [N][s] s, nodes of a scheme's stages; above order 2 only
  std::vector<std::vector<Vectors>> control_stages;    // [N][s][joints] N m, on the parent, parent's frame at that time
  std::vector<LimitMultiplier> limit_multipliers;      // of limits that hold somewhere
  std::vector<std::vector<double>> work_multipliers;  // [drives][N+1] signs of the powers; −1 … 1 where a power is 0
  std::vector<std::vector<double>> work_change_multipliers;  // [drives][N+1] slopes of the work by the powers' changes
  Feedback feedback;                                         // about the motion; of optimal ones
  std::optional<Tracking> tracking;                          // of a march with feedback
  std::string marched_by;                                    // what marched in place of the scheme; empty: the scheme
  DividedSteps divided;                                      // of a march that divides its steps
  SearchRecord search;                                       // starts = 0: no search was made
  SolverRecord solver;
};

}  // namespace lamprey::maneuver
