#include "search/drifting.hpp"

#include <cmath>

#include "guess/coasting.hpp"
#include "integrator/scheme.hpp"
#include "maneuver/simulate.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::search {

namespace {

using maneuver::Maneuver;
using maneuver::Problem;

constexpr double calm_share = 0.5;  // of a guess's swings, beside a momentum that may do the most
constexpr int calm_guesses = 4;     // in all but one of so many
constexpr double met = 1e-10;       // units of the end rows and of limits
constexpr double round_off = 1e-9;  // of the momentum, in a step

// Whether only moments cost, and a motion may be without.
bool may_coast(const Problem& problem, const Maneuver& maneuver) {
  const maneuver::CostWeights& weights = problem.cost_weights;
  return !maneuver.start.momentum.isZero(0.0) && !maneuver.periodic && maneuver.spline_points == 0 &&
         problem.waypoints.empty() && integrator::single_step(problem.scheme) && weights.angular_velocity == 0.0 &&
         !weights.of_displacement();
}

// Motions without moments in given times, as far as they are simulated.
class Coasts {
 public:
  Coasts(const model::System& system, const Problem& problem, int steps, const std::function<bool()>& stopped)
      : system_(system), problem_(problem), steps_(steps), stopped_(stopped) {}

  struct Coast {
    Found found;
    double missed;  // in units of the rows, by the goal and, over limits, by those
  };

  std::optional<Coast> in(double duration) const { return in(duration, steps_); }

  // Of durations over a range the one in which the goal is missed least, to round-off; looked for on few steps first.
  std::optional<Coast> nearest(double least, double most) const {
    const double ratio = std::pow(most / least, 1.0 / tried_durations);
    std::optional<double> missed;
    double at = least;
    for (int n = 0; n <= tried_durations; ++n)
      if (const std::optional<Coast> coast = in(least * std::pow(ratio, n), std::min(steps_, scanning_steps));
          coast && !(missed && *missed <= coast->missed))
        missed = coast->missed, at = coast->found.duration;
    std::optional<Coast> best = missed ? in(at) : std::nullopt;
    double left = std::max(least, at / ratio), right = std::min(most, at * ratio);
    const double first = best ? best->missed : 0.0;
    for (int n = 0; n < golden_sections && best && best->missed > met; ++n) {
      if (n == telling_sections && best->missed > telling_share * first) break;  // it comes by, and does not meet it
      const double inner = left + golden * (right - left), outer = right - golden * (right - left);
      const std::optional<Coast> one = in(inner), other = in(outer);
      if (!one || !other) break;
      const bool nearer_left = one->missed <= other->missed;
      (nearer_left ? right : left) = nearer_left ? outer : inner;
      if (const Coast& nearer = nearer_left ? *one : *other; nearer.missed < best->missed) best = nearer;
    }
    return best;
  }

 private:
  static constexpr int tried_durations = 32, scanning_steps = 500, golden_sections = 64, telling_sections = 10;
  static constexpr double golden = 0.3819660112501051, telling_share = 0.1;

  std::optional<Coast> in(double duration, int steps) const {
    if (stopped_ && stopped_()) return std::nullopt;
    Problem given = problem_;
    given.duration = {};
    given.duration.value = duration;
    given.steps = steps;
    const maneuver::Solution motion =
        maneuver::simulate(system_, given, maneuver::no_control(system_), {.interrupted = stopped_});
    if (motion.status != maneuver::Status::simulated) return std::nullopt;
    Coast coast{found_of(motion, duration), 0.0};
    Maneuver asked = maneuver::make_maneuver(system_, given, steps);
    asked.cost_weights = {};
    asked.time_weight = 0.0;  // what a given duration costs is no moment's
    shape::ShapeProgram program(system_, asked, maneuver::ShapeCoordinates(system_), {},
                                maneuver::limit_rows(system_, given), shape::Steps::faithful);
    if (!program.go_to(coast.found.path)) return std::nullopt;
    coast.missed = std::max(program.stated_goal_error(), program.limit_violation());
    // moments that still the joints at the end, where they are asked to
    const double still = round_off * maneuver::bodies_momentum(system_, asked.start) / asked.time_step();
    if (asked.rest && !(program.cost() <= asked.effort * still * still * duration)) return std::nullopt;
    return coast;
  }

  Found found_of(const maneuver::Solution& motion, double duration) const {
    Found found;
    found.path.rotation = motion.rotation;
    found.path.position = motion.position;
    for (std::size_t k = 0; k + 1 < motion.rotation.size(); ++k)
      maneuver::cayley_between(motion.rotation[k], motion.rotation[k + 1], found.path.cayley.emplace_back());
    found.path.control.assign(motion.rotation.size(), Eigen::VectorXd::Zero(system_.control_count()));
    if (problem_.cost_weights.any())
      found.cost_parts = maneuver::CostParts{.time = duration, .transport = std::nan("")};
    found.duration = duration;
    found.cost = problem_.time_weight * duration;
    found.outcome.termination = optimizer::Termination::converged;
    found.outcome.reason = "the goal is where the swimmer gets by itself";
    found.outcome.infeasibility = 0.0;
    return found;
  }

  const model::System& system_;
  const Problem& problem_;
  int steps_;
  const std::function<bool()>& stopped_;  // asked at every step; may be empty
};

}  // namespace

maneuver::NodePath carried_by_momentum(const model::System& system, const Problem& problem, maneuver::NodePath guess,
                                       int start) {
  if (!maneuver::has_momentum(system, problem.start)) return guess;
  const double share = start % calm_guesses < calm_guesses - 1 ? calm_share : 1.0;
  return guess::coasting(system, problem, guess, share).value_or(std::move(guess));
}

std::optional<Found> coasting(const model::System& system, const Problem& problem, const Maneuver& maneuver,
                              const std::function<bool()>& stopped) {
  if (maneuver.start.momentum.isZero(0.0) || maneuver.periodic || !integrator::single_step(problem.scheme))
    return std::nullopt;
  Problem free = problem;
  if (free.goal) free.goal->rest = free.goal->joints_rest = false;
  std::optional<Coasts::Coast> coast = Coasts(system, free, maneuver.steps, stopped).in(maneuver.duration);
  return coast ? std::optional(std::move(coast->found)) : std::nullopt;
}

std::optional<Found> coasting_to_goal(const model::System& system, const Problem& problem, const Maneuver& maneuver,
                                      const std::function<bool()>& stopped) {
  if (!may_coast(problem, maneuver)) return std::nullopt;
  const Coasts coasts(system, problem, maneuver.steps, stopped);
  const maneuver::Duration& asked = problem.duration;
  std::optional<Coasts::Coast> coast = coasts.in(asked.free ? asked.min : asked.value);
  const bool at_once = coast && coast->missed <= met;
  if (asked.free && !at_once && problem.time_weight == 0.0) coast = coasts.nearest(asked.min, asked.max);
  if (!coast || !(coast->missed <= met)) return std::nullopt;
  if (asked.free && at_once) hold_in_least_time(system, problem, maneuver, coast->found);
  return std::move(coast->found);
}

}  // namespace lamprey::search
