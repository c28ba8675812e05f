#include <cmath>

#include <fmt/format.h>

#include "report/summary.hpp"
#include "report/wording.hpp"

namespace lamprey::report {
namespace {

using certificate::unset;

constexpr double goal_mark = 1e-9;       // rad, m; also rest
constexpr double momentum_mark = 1e-11;  // of the scale
constexpr double equation_mark = 1e-10;
constexpr double replay_mark = 1e-3;     // rad at a window's end
constexpr double feedback_mark = 1e-2;   // rad at the end
constexpr double curvature_mark = 1e-6;  // of the effort's own

std::string with_unit(double value, const char* unit) {
  if (std::isnan(value) || *unit == '\0') return number(value, 3);
  return number(value, 3) + " " + unit;
}

CertificateRow held(const char* name, double value, const char* unit, double mark, const char* meaning) {
  if (std::isnan(mark)) return {name, with_unit(value, unit), "", std::nullopt, meaning};
  std::optional<bool> holds;
  if (!std::isnan(value)) holds = value <= mark;
  return {name, with_unit(value, unit), fmt::format("≤ {}", with_unit(mark, unit)), holds, meaning};
}

CertificateRow shown(const char* name, double value, const char* unit, const char* meaning) {
  return {name, with_unit(value, unit), "", std::nullopt, meaning};
}

CertificateRow second_order_row(const std::optional<certificate::SecondOrder>& second_order) {
  const double value = second_order ? second_order->smallest_eigenvalue : unset;
  std::optional<bool> holds;
  if (!std::isnan(value)) holds = second_order->positive;
  return {"Smallest curvature", number(value, 3), fmt::format("> {}", number(curvature_mark)), holds,
          "Smallest eigenvalue of the Lagrangian’s Hessian among the changes of control that keep the goal, relative "
          "to the "
          "effort alone (1 = pure effort). Above zero: a strict local minimum; below: a saddle."};
}

}  // namespace

std::vector<CertificateRow> certificate_rows(const certificate::Certificate& proof,
                                             const file::ResolvedProblem& problem) {
  const certificate::Replay replay = proof.replay.value_or(certificate::Replay{});
  const certificate::Refinement refinement = proof.refinement.value_or(certificate::Refinement{});
  const double asked = problem.goal ? goal_mark : unset;
  const double rests = problem.goal && problem.goal->rest ? goal_mark : unset;
  return {
      held("Goal error", proof.goal_error, "", asked,
           "Largest distance of the end from what the goal asks, over all its rows, in rad or m."),
      held("Rest error", proof.rest_error, "", rests,
           "Largest momentum left at the end, relative to the largest of the motion. 0 is rest."),
      held(
          "Discrete equations", proof.equation_residual, "", equation_mark,
          "Largest residual of the discrete Euler–Lagrange equations at the nodes, both ends included, relative to the "
          "largest momentum or impulse of a step."),
      held("Momentum drift", proof.momentum_drift, "", momentum_mark,
           "Largest change of the total linear and angular momentum, relative to the largest momentum or impulse of a "
           "step. "
           "Joint moments act in pairs, so nothing may change it."),
      shown("Rotation drift", proof.rotation_drift, "",
            "Largest entry of RᵀR − I: how far stored rotations are from rotations."),
      held("First-order optimality (KKT)", proof.kkt, "", problem.tolerance,
           "Largest part of the cost’s gradient that no multiplier of the goal explains, relative to the gradient "
           "itself."),
      second_order_row(proof.second_order),
      held("Replay, rotation", replay.rotation_error, "rad", replay_mark,
           "The stored controls through another integrator of the continuous equations, restarted from the stored "
           "state at "
           "each window’s start: largest rotation error at a window’s end."),
      shown("Replay, position", replay.position_error, "m", "The same for the root’s position."),
      shown("Replay window", replay.window, "s", "Time between two restarts of the replay."),
      shown("Whole replay, rotation", replay.whole_rotation_error, "rad",
            "The same replay, never restarted. Unstable motions amplify any difference, so this is no fault of the "
            "solution."),
      shown("Whole replay, position", replay.whole_position_error, "m", "The same for the root’s position."),
      held("Replay with feedback, rotation", replay.feedback_rotation_error, "rad", feedback_mark,
           "The same replay, never restarted, with the stored gains: moments answer how far it is off the answer, as a "
           "vehicle’s would."),
      shown("Replay with feedback, position", replay.feedback_position_error, "m", "The same for the root’s position."),
      shown("Growth rate", replay.growth_rate, "1/s",
            "How fast small perturbations grow along the motion: as e to this rate × time."),
      shown("Cost at half the step", refinement.cost_half_step, "(N m)² s",
            "Cost of the same problem solved with twice the steps."),
      shown("Observed order", refinement.observed_order, "", "Order at which the cost settles as the step is halved."),
  };
}

}  // namespace lamprey::report
