#include <string>

#include "maneuver/maneuver.hpp"
#include "model/input_error.hpp"
#include "search/method.hpp"

namespace lamprey::search {

std::unique_ptr<Method> choose_method(const model::System& system, const maneuver::Problem& problem,
                                      const SolveOptions& options, const Budget& budget) {
  if (problem.goal && problem.goal->periodic && maneuver::has_momentum(system, problem.start))
    throw model::InputError("start",
                            "found total momentum, with which this version takes no periodic goal; take the velocities "
                            "out, or let goal.periodic be false");
  const bool newton = newton_takes(system, problem), both = options.solver == Backend::both;
  const bool ipopt = options.solver == Backend::ipopt || both || !newton;
  if (ipopt && problem.goal && problem.goal->joints_rest && maneuver::has_momentum(system, problem.start))
    throw model::InputError(
        "goal.rest",
        "found \"joints\" with a start that carries momentum, which takes control.kind = \"steps\", "
        "integrator.scheme of order 1 or 2 and not --solver ipopt or both; use those, or "
        "rest = false");
  if (!integrator::single_step(problem.scheme) && (options.solver == Backend::ipopt || both || !newton))
    throw model::InputError(
        "integrator.scheme",
        "found a scheme above order 2, which takes control.kind = \"steps\", no limits, waypoints, "
        "periodic goal or free duration, a start without total momentum, and not --solver ipopt or both; "
        "use \"trapezoid\" with more steps");
  if ((options.solver == Backend::newton || both) && !newton)
    throw model::InputError("--solver", std::string("found \"") + (both ? "both" : "newton") +
                                            "\", which takes control.kind = \"steps\"; use --solver ipopt for this "
                                            "problem, or none");
  if (options.solver == Backend::ipopt || !newton) return ipopt_method(system, problem, options, budget);
  return newton_method(system, problem, options, budget);
}

}  // namespace lamprey::search
