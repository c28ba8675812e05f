// Certificate: the numbers that prove an answer, in the words of solution.json. NaN: not computed (written as null).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "evidence/findings.hpp"
#include "optimality/curvature.hpp"

namespace lamprey::certificate {

using evidence::unset;

/// Marks of replays.
inline constexpr double replay_mark = 1e-3;    // rad, at a window's end: what steps that resolve a motion miss by
inline constexpr double asked_share = 0.1;     // of the turn or displacement asked for, that it may miss by as well
inline constexpr double work_mark = 0.02;      // of the work by the replay, that the nodes' may be beside it
inline constexpr double feedback_mark = 1e-2;  // rad, at the end of the whole replay with feedback

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

  double rotation_mark =
      replay_mark;  // rad, what a window may miss by: a tenth of the turn asked for, where that is less
  double position_mark =
      std::numeric_limits<double>::infinity();  // m: a tenth of the displacement asked for, if any is

  bool cut_short = false;  // its time was over before it was done: what is unset is not known
  /// Whether it says that the steps do not resolve the motion: it misses, or broke off by itself.
  bool misses() const { return !cut_short && !(excess() <= 1.0); }
  /// What it misses by, of what it may; NaN where it broke off.
  double excess() const {
    const double turned = rotation_error / rotation_mark, moved = position_error / position_mark;
    return turned > moved ? turned : std::isnan(turned) ? turned : moved;
  }
  /// Whether displacement is what it misses.
  bool misses_by_place() const { return position_error / position_mark > rotation_error / rotation_mark; }

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
  std::optional<evidence::CostsKept> costs;    // where the problem has costs beside effort and time
  std::optional<evidence::LimitsKept> limits;  // where the problem has any, or waypoints, or a free duration
  std::optional<optimality::SecondOrder> second_order;
  std::optional<optimality::AllAxes> all_axes;  // where control_axes confine an actuated joint and there are no limits
  std::optional<Verdict> verdict;               // of sought motions
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

  std::optional<evidence::Clearance> clearance;  // least gap of two bodies; nothing for a single one

  /// Marks that no motion of so many digits in so short steps could miss for that alone.
  double equation_allowed() const { return std::max(evidence::equation_mark, momentum_round_off); }
  double momentum_allowed() const { return std::max(evidence::momentum_mark, momentum_round_off); }
  double kkt_allowed(double tolerance) const { return std::max(tolerance, kkt_round_off); }
};

}  // namespace lamprey::certificate
