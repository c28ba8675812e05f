#include "study/drifting.hpp"

#include <cmath>

#include "guess/coasting.hpp"
#include "integrator/scheme.hpp"
#include "maneuver/simulate.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::study {

namespace {

constexpr double calm_share = 0.5;  // of a guess's swings, beside a momentum that may do the most
constexpr int calm_guesses = 4;     // in all but one of so many
constexpr double met = 1e-10;       // rad, m, units of limits
constexpr double round_off = 1e-9;  // of the momentum, in a step

// Whether only moments cost, and a motion may be without.
bool may_coast(const maneuver::Problem& problem, const maneuver::Maneuver& maneuver) {
  const maneuver::CostWeights& weights = problem.cost_weights;
  return !maneuver.start.momentum.isZero(0.0) && !maneuver.periodic && !maneuver.free_duration &&
         maneuver.spline_points == 0 && problem.waypoints.empty() && integrator::single_step(problem.scheme) &&
         weights.angular_velocity == 0.0 && !weights.of_displacement();
}

}  // namespace

maneuver::NodePath carried_by_momentum(const model::System& system, const maneuver::Problem& problem,
                                       maneuver::NodePath guess, int start) {
  if (!maneuver::has_momentum(system, problem.start)) return guess;
  const double share = start % calm_guesses < calm_guesses - 1 ? calm_share : 1.0;
  return guess::coasting(system, problem, guess, share).value_or(std::move(guess));
}

std::optional<Found> coasting_to_goal(const model::System& system, const maneuver::Problem& problem,
                                      const maneuver::Maneuver& maneuver) {
  if (!may_coast(problem, maneuver)) return std::nullopt;
  const maneuver::Solution coast =
      maneuver::simulate(system, problem, maneuver::no_control(system), maneuver::SimulateOptions());
  if (coast.status != maneuver::Status::simulated) return std::nullopt;
  Found found;
  found.path.rotation = coast.rotation;
  found.path.position = coast.position;
  for (std::size_t k = 0; k + 1 < coast.rotation.size(); ++k)
    maneuver::cayley_between(coast.rotation[k], coast.rotation[k + 1], found.path.cayley.emplace_back());
  found.path.control.assign(coast.rotation.size(), Eigen::VectorXd::Zero(system.control_count()));
  maneuver::Maneuver asked = maneuver;
  asked.cost_weights = {};
  shape::ShapeProgram program(system, asked, maneuver::ShapeCoordinates(system), {},
                              maneuver::limit_rows(system, problem), shape::Steps::faithful);
  if (!program.go_to(found.path) || !(program.stated_goal_error() <= met) || !(program.limit_violation() <= met))
    return std::nullopt;
  // moments that still the joints at the end, where they are asked to
  const double still = round_off * maneuver::bodies_momentum(system, maneuver.start) / maneuver.time_step();
  if (maneuver.rest && !(program.cost() <= maneuver.effort * still * still * maneuver.duration)) return std::nullopt;
  if (problem.cost_weights.any())
    found.cost_parts = maneuver::CostParts{.time = maneuver.duration, .transport = std::nan("")};
  found.cost = maneuver.time_weight * maneuver.duration;
  found.duration = maneuver.duration;
  found.outcome.termination = optimizer::Termination::converged;
  found.outcome.reason = "the goal is where the swimmer gets by itself";
  found.outcome.infeasibility = 0.0;
  return found;
}

}  // namespace lamprey::study
