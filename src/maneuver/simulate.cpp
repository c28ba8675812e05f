#include "maneuver/simulate.hpp"

#include <limits>
#include <sstream>

#include "maneuver/maneuver.hpp"
#include "maneuver/motion.hpp"

namespace lamprey::maneuver {

namespace {

using model::System;

// The share of the moments that the joints can exert.
mechanics::Moments exerted(const System& system, mechanics::Moments u) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const auto& actuation = system.joint(j).actuation;
    Vector3d& moment = u[static_cast<std::size_t>(j)];
    moment = actuation * (actuation.transpose() * moment);
  }
  return u;
}

std::string failure(int step, double time, const integrator::StepReport& report) {
  std::ostringstream text;
  text << "step " << step << " at t = " << time << " s did not converge (relative residual " << report.residual
       << " after " << report.iterations << " Newton iterations); try more steps";
  return text.str();
}

}  // namespace

ControlFunction no_control(const System& system) {
  const mechanics::Moments none(static_cast<std::size_t>(system.joint_count()), Vector3d::Zero());
  return [none](double) { return none; };
}

Solution simulate(const System& system, const Problem& problem, const ControlFunction& control,
                  const std::function<bool()>& interrupted) {
  Solution solution;
  solution.status = Status::simulated;
  solution.cost = std::numeric_limits<double>::quiet_NaN();
  const double h = problem.time_step();
  integrator::State state = start_state(system, problem.start);
  integrator::StepWorkspace work(system);
  mechanics::Moments u = exerted(system, control(0.0));
  append_node(system, 0.0, state, u, solution);
  for (int k = 0; k < problem.steps; ++k) {
    if (interrupted && interrupted()) {
      solution.status = Status::interrupted;
      solution.message = "Interrupted at t = " + std::to_string(k * h) + " s.";
      return solution;
    }
    const mechanics::Moments u_next = exerted(system, control((k + 1) * h));
    const auto report = advance(system, integrator::lagrangian_of(problem.scheme), h, u, u_next, state, work);
    if (!report.converged) {
      solution.status = Status::stalled;
      solution.message = failure(k, k * h, report);
      return solution;
    }
    u = u_next;
    append_node(system, (k + 1) * h, state, u, solution);
  }
  solution.message = "Marched " + std::to_string(problem.steps) + " steps of the scheme.";
  return solution;
}

}  // namespace lamprey::maneuver
