// What a method has found, and the solution that it makes.
#pragma once

#include <optional>
#include <string>

#include "maneuver/node_path.hpp"
#include "maneuver/problem.hpp"
#include "optimizer/outcome.hpp"
#include "shape/cost_terms.hpp"
#include "shape/limit_terms.hpp"

namespace lamprey::search {

/// A motion that a method has arrived at.
struct Found {
  optimizer::Outcome outcome;
  maneuver::NodePath path;          // empty: none
  maneuver::NodePath coarser;       // the same solution on a grid whose nodes are among the path's; empty: not known
  Eigen::VectorXd end_multipliers;  // of the end rows
  double cost = 0.0;                // by the file's rule
  double duration = 0.0;            // s
  shape::LimitMultipliers limit_multipliers;
  std::optional<maneuver::CostParts> cost_parts;  // where more than effort and time is asked for
  shape::WorkMultipliers work_multipliers;
  std::optional<double> joint_rate;  // rad/s that joints were held to beyond what is asked, where they were
  bool by_second = false;            // whether the second solver found it, where two searched
  bool converged() const { return outcome.termination == optimizer::Termination::converged; }
  /// Whether it is a minimum with joints held to that rate, and meets all else that is asked.
  bool held() const { return joint_rate && outcome.termination == optimizer::Termination::feasible; }
};

/// To stay as a maneuver of the problem starts, and what that costs: an outcome that has converged for this reason.
Found staying(const model::System& system, const maneuver::Problem& problem, const maneuver::Maneuver& maneuver,
              const std::string& reason);

/// Has a motion that costs nothing but its free duration last as short as it may, and that bound pull as much as time costs.
void hold_in_least_time(const model::System& system, const maneuver::Problem& problem,
                        const maneuver::Maneuver& maneuver, Found& found);

/// Whether a motion ends as the problem's goal asks, those of its conditions included that were taken to follow from others.
bool reaches_goal(const model::System& system, const maneuver::Problem& problem, const maneuver::NodePath& motion);

/// Whether any of them has arrived.
bool any_converged(const std::vector<Found>& all);

/// Adds the iterations and evaluations of one search to those of another; their histories stay their own.
void count_effort(const optimizer::Outcome& other, optimizer::Outcome& outcome);

/// Moves motions to the end of others.
void append(std::vector<Found> more, std::vector<Found>& all);

/// The largest turn of a body in one step.
struct StepTurn {
  double angle = 0.0;  // rad
  std::size_t body = 0, step = 0;
};

StepTurn largest_turn(const std::vector<mechanics::Rotations>& rotation);

/// rad, next to the quarter turn that is the most that a step can show.
inline constexpr double nearly_quarter_turn = 1.5;

/// The optimiser's own view of how it ended.
maneuver::Status status_of(const optimizer::Outcome& outcome);

/// Nodes, moments, velocities, momenta, cost and multipliers of what was found for a maneuver, as solution.json has them; the
/// multipliers of limits that hold nowhere are left out. `limits`: the rows that limit_multipliers belong to.
maneuver::Solution describe(const model::System& system, const maneuver::Maneuver& maneuver, maneuver::Scheme scheme,
                            const std::vector<maneuver::LimitRow>& limits, const Found& found);

/// The way back: nodes without their moments, duration and multipliers of limits and work with their weights.
Found found_in(const model::System& system, const maneuver::Maneuver& maneuver,
               const std::vector<maneuver::LimitRow>& limits, const maneuver::Solution& solution);

}  // namespace lamprey::search
