// Certificate: the numbers that prove an answer, in the words of solution.json. NaN: not computed (written as null).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace lamprey::certificate {

inline constexpr double unset = std::numeric_limits<double>::quiet_NaN();

/// Marks of an optimal answer; that of kkt is the problem's tolerance.
inline constexpr double goal_mark = 1e-9;       // rad, m
inline constexpr double rest_mark = 1e-9;       // of the scale
inline constexpr double equation_mark = 1e-10;  // of the scale, or what round-off leaves
inline constexpr double momentum_mark = 1e-11;  // of the scale, or what round-off leaves
inline constexpr double start_mark = 1e-9;      // rad, m
inline constexpr double rotation_mark = 1e-11;  // of |RᵀR − I| and |det R − 1|
inline constexpr double control_mark = 1e-9;    // of the largest moment
inline constexpr double time_mark = 1e-9;       // of the duration
inline constexpr double velocity_mark = 1e-6;   // of the largest: round-off of short steps is in them
inline constexpr double cost_mark = 1e-9;       // of the cost
inline constexpr double limit_mark = 1e-7;      // rad, m, of the bound
inline constexpr double replay_mark = 1e-3;     // rad, at a window's end: what steps that resolve a motion miss by
inline constexpr double work_mark = 0.02;       // of the work by the replay, that the nodes' may be beside it
inline constexpr double feedback_mark = 1e-2;   // rad, at the end of the whole replay with feedback
inline constexpr double proof_mark = 1e-6;      // of kkt: beyond, a proof would rest on a loose tolerance
inline constexpr double complementarity_mark = 5e-7;  // of the cost over the duration: a barrier leaves 1e-7 or 2e-7
inline constexpr double sign_mark = 1e-6;             // of the largest multiplier, that one may push the wrong way
inline constexpr double curvature_mark = 1e-6;        // of the effort's own

/// Eigenvalues of the Lagrangian's Hessian among changes of the moments that keep the goal, against the effort metric.
struct SecondOrder {
  double smallest_eigenvalue = unset;  // 1: pure effort
  bool positive = false;               // smallest eigenvalue above 1e-6
  std::optional<int> negative_eigenvalues = {};
  bool costs_nothing =
      false;  // and nothing less can be, so that other directions, of a duration or a first shape, may be flat; not stored
  std::optional<double> along_phase =
      {};  // set aside of the numbers above: that of beginning elsewhere along a gait, within ±1e-6
  /// Whether round-off hides how many directions lower the cost, and how steeply.
  bool lost() const { return !positive && !negative_eigenvalues && smallest_eigenvalue < -curvature_mark; }
};

/// The same with every direction moved that actuated joints leave free: control_axes set aside.
struct AllAxes {
  double kkt = unset;  // among all these moments; unless it is small the eigenvalues mean nothing and are unset
  SecondOrder second_order;
};

/// What the numbers add up to.
enum class Verdict {
  proved,  // goal met, stationary, positive on the tangent space: a strict local minimum; or at no cost, where none is less
  stationary,  // goal met, stationary; curvature not positive or not known
  not_optimal
};

/// The stored controls through an independent high-order integrator of the continuous equations.
struct Replay {
  std::string scheme;
  double window = unset;                   // s between restarts from the stored state
  double rotation_error = unset;           // rad, largest at a window's end
  double position_error = unset;           // m, largest at a window's end
  double whole_rotation_error = unset;     // rad, never restarted
  double whole_position_error = unset;     // m, never restarted
  double growth_rate = unset;              // 1/s of small perturbations
  double feedback_rotation_error = unset;  // rad, never restarted, with the stored gains; at the end
  double feedback_position_error = unset;  // m, likewise
  double servo_rotation_error = unset;     // rad, of the root at the end, the joints led along the stored angles
  double servo_position_error = unset;     // m, likewise
  double work =
      unset;  // J, ∫ Σ_j |u_j·ω_j| dt, each step from its stored state; where costs beside effort are asked for

  bool cut_short = false;  // its time was over before it was done: what is unset is not known
  /// Whether it says that the steps do not resolve the motion: it misses, or broke off by itself.
  bool misses() const { return !cut_short && !(rotation_error <= replay_mark); }

  /// Whether the joints do other work than that at the nodes, J.
  bool works_otherwise(double at_nodes) const { return std::abs(work - at_nodes) > work_mark * work; }
};

struct GridCost {
  int steps;
  double cost;
};

/// The same minimum on other grids (equation 6.8); found by solving, so not by this room.
struct Refinement {
  double cost_half_step = unset;
  double observed_order = unset;  // from the three grids
  double cost_limit = unset;      // extrapolated to no step at all
  double cost_error = unset;      // of the answer's cost against it
  std::vector<GridCost> grids;    // by rising steps

  /// Whether each finer grid costs half as much again as the one before it, or more: the goal may be within reach of long steps alone.
  bool grows() const {
    for (std::size_t g = 0; g + 1 < grids.size(); ++g)
      if (!(grids[g].cost > 0.0 && grids[g + 1].cost > 1.5 * grids[g].cost)) return false;
    return grids.size() >= 3;
  }
};

/// Limits and waypoints along the stored motion.
struct LimitsKept {
  double violation = unset;  // largest: rad or m, moments, rates and durations against the bound; 0 where all are kept
  std::string key;           // of the worst, as in the problem file
  double time = unset;       // s, of the worst
  double complementarity = unset;  // largest |multiplier · margin| / (what is spent / duration)
  double negative = unset;         // most negative multiplier / the largest; 0 where none is
  std::map<std::string, double> reached =
      {};  // key of a limit that is reached or broken somewhere → share of the nodes; not stored
};

/// Costs beside effort and time along the stored motion.
struct CostsKept {
  double error = unset;  // relative difference of the stored cost from the one recomputed
  double signs = unset;  // how far powers are from what their multipliers belong to, of their joint's largest
};

/// Where two bodies come nearest to each other.
struct Clearance {
  double gap = unset;   // m; below zero they overlap, and this is minus the shortest way out
  double time = unset;  // s
  int first = -1;       // body indices, first < second
  int second = -1;
};

struct Certificate {
  double goal_error = unset;     // max over goal rows, rad or m
  std::string goal_missed = {};  // which of them that is, and whether it is in rad; not stored
  bool goal_missed_by_turn = true;
  double rest_error = unset;      // max |μ_N| / scale
  double momentum_drift = unset;  // max |p − p_0| / scale
  double momentum_round_off =
      0.0;                        // what the digits of stored rotations and positions leave of a step's momenta / scale
  double rotation_drift = unset;  // max |RᵀR − I|, |det R − 1|
  double iterates_momentum = unset;  // largest total momentum / scale over all iterates that the solver recorded
  double kkt = unset;                // scaled, in the space of controls
  double kkt_round_off = 0.0;        // what the digits of stored rotations and positions leave of it
  std::optional<CostsKept> costs;    // where the problem has costs beside effort and time
  std::optional<LimitsKept> limits;  // where the problem has any, or waypoints, or a free duration
  std::optional<SecondOrder> second_order;
  std::optional<AllAxes> all_axes;  // where control_axes confine an actuated joint and there are no limits
  std::optional<Verdict> verdict;   // of sought motions
  std::optional<Replay> replay;
  std::optional<Refinement> refinement;
  double equation_residual = unset;  // largest residual of the discrete equations, both ends included, / scale
  double start_error = unset;        // largest difference of node 0 from the problem's start, rad or m
  double control_error = unset;      // largest part of a moment that joints or control kind forbid / largest moment
  double time_error = unset;         // largest difference of a node's time from equal steps / duration
  double velocity_error = unset;     // largest difference of stored velocities and momenta from those of the steps /
                                     // largest, and of joint angles from those of the bodies, and of led bodies
                                     // from what their joints allow, rad
  double cost_error = unset;         // relative difference of the stored cost from the one recomputed
  double beyond_moments = unset;     // of marches whose files do not tell the steps: how many times as far as moments
                                     // leave open one leads; not stored

  std::string refusal;  // of files: why no problem file may ask their question, which is then not judged; else empty

  std::optional<Clearance> clearance;  // least gap of two bodies; nothing for a single one

  /// Marks that no motion of so many digits in so short steps could miss for that alone.
  double equation_allowed() const { return std::max(equation_mark, momentum_round_off); }
  double momentum_allowed() const { return std::max(momentum_mark, momentum_round_off); }
  double kkt_allowed(double tolerance) const { return std::max(tolerance, kkt_round_off); }
};

}  // namespace lamprey::certificate
