#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "report/summary.hpp"
#include "report/wording.hpp"

namespace lamprey::report {
namespace {

constexpr double undercut = 1e-6;  // of a clearance, less than asked for

using evidence::complementarity_mark;
using evidence::control_mark;
using evidence::cost_mark;
using evidence::goal_mark;
using evidence::limit_mark;
using evidence::rest_mark;
using evidence::sign_mark;
using evidence::start_mark;
using evidence::time_mark;
using evidence::unset;
using evidence::velocity_mark;
using optimality::curvature_mark;

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

CertificateRow cost_row(const char* name, double value, const char* meaning) {
  return {name, std::isnan(value) ? number(value) : cost_number(value) + " (N m)² s", "", std::nullopt, meaning};
}

// Of the search itself, which the files do not hold: nothing can recompute it.
CertificateRow stored(CertificateRow row) {
  row.stored = true;
  return row;
}

CertificateRow shown(const char* name, double value, const char* unit, const char* meaning) {
  return {name, with_unit(value, unit), "", std::nullopt, meaning};
}

std::string curvature_value(const optimality::SecondOrder& second_order) {
  std::string text = number(second_order.smallest_eigenvalue, 3);
  if (second_order.held()) return "limits leave no direction";
  if (second_order.lost()) return text + ", lost in round-off";
  if (second_order.along_phase)
    text += fmt::format(", and {} by beginning elsewhere", number(*second_order.along_phase, 1));
  if (const int descents = second_order.negative_eigenvalues.value_or(0); descents > 0)
    text += fmt::format(" ({} descent direction{})", descents, descents == 1 ? "" : "s");
  return text;
}

CertificateRow second_order_row(const optimality::SecondOrder& second_order) {
  std::optional<bool> holds;
  if (!std::isnan(second_order.smallest_eigenvalue)) holds = second_order.positive;
  return {"Smallest curvature", curvature_value(second_order), fmt::format("> {}", number(curvature_mark)), holds,
          "Smallest eigenvalue of the Lagrangian’s Hessian among the changes of control that keep the goal, relative "
          "to the "
          "effort alone (1 = pure effort). Above zero: a strict local minimum; below: a saddle. A gait that nothing "
          "ties to "
          "its start may begin elsewhere along itself, which changes nothing and is set aside."};
}

using Rows = std::vector<CertificateRow>;

// What the problem asks for.
Rows rows_of_goal(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  const double asked = problem.goal ? goal_mark : unset;
  const double rests = problem.goal && problem.goal->stills_joints() ? rest_mark : unset;
  Rows rows = {
      held("Goal error", proof.goal_error, "", asked,
           "Largest distance of the end from what the goal asks, over all its rows, in rad or m."),
      held(
          "Rest error", proof.rest_error, "", rests,
          problem.goal && problem.goal->joints_rest
              ? "Largest difference of the momenta at the end from those of a whole that moves as one, relative to the "
                "largest of the motion. 0 is rest of all joints."
              : "Largest momentum left at the end, relative to the largest of the motion. 0 is rest."),
  };
  if (problem.goal && problem.goal->periodic && std::isnan(rests)) rows.back().value = "not required";
  if (proof.limits)
    rows.insert(rows.begin() + 1,
                held("Limits", proof.limits->violation, "", limit_mark,
                     "Largest violation of a limit or miss of a waypoint at the nodes, in rad or m; of moments, "
                     "rates and durations relative to the bound."));
  return rows;
}

// Whether it is a motion of these bodies in this fluid.
Rows rows_of_mechanics(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  return {
      held(
          "Discrete equations", proof.equation_residual, "", proof.equation_allowed(),
          "Largest residual of the discrete Euler–Lagrange equations at the nodes, both ends included, relative to the "
          "largest momentum or impulse of a step."),
      held("Momentum drift", proof.momentum_drift, "", proof.momentum_allowed(),
           "Largest change of the total linear and angular momentum, relative to the largest momentum or impulse of a "
           "step. "
           "Joint moments act in pairs, so nothing may change it."),
      stored(
          held("Momentum over all iterates", proof.iterates_momentum, "", proof.momentum_allowed(),
               "Largest total momentum of any point that the solver went through, as it measured it, relative to that "
               "point's largest momentum: the search cannot live on momentum that leaks.")),
      held("Rotation drift", proof.rotation_drift, "", evidence::rotation_mark,
           "Largest entry of RᵀR − I, or of det R − 1: how far stored rotations are from rotations."),
      {"Clearance",
       proof.clearance ? clearance_words(*proof.clearance, problem)
                       : (problem.bodies.size() == 1 ? "one body" : number(unset)),
       "", std::nullopt,
       "Least distance of two bodies at the nodes and between them, with joints turning evenly from node to node. "
       "Where "
       "bodies overlap: the shortest way out of each other. Nothing in the mechanics keeps bodies apart."},
  };
}

// Whether the file's numbers are those of that motion.
Rows rows_of_file(const certificate::Certificate& proof) {
  return {
      held("Start", proof.start_error, "", start_mark,
           "Largest distance of the first node from where the problem begins, in rad or m."),
      held("Times of the nodes", proof.time_error, "", time_mark,
           "Largest difference of a node’s time from equal steps over the duration, relative to the duration."),
      held("Unactuated moment", proof.control_error, "", control_mark,
           "Largest part of a moment that joints, control_axes or the control’s kind do not have, relative to the "
           "largest moment."),
      held("Stored velocities", proof.velocity_error, "", velocity_mark,
           "Largest difference of the stored velocities and momenta from those of the steps, relative to the largest, "
           "and of "
           "joint angles from the bodies' turns, in rad."),
      held("Stored cost", proof.cost_error, "", cost_mark,
           "Relative difference of the stored cost from the one recomputed along the motion."),
  };
}

// Whether the joints' freedoms are more than the axes along which moments act.
bool confines_axes(const result::ResolvedProblem& problem) {
  return std::any_of(problem.joints.begin(), problem.joints.end(), [](const result::ResolvedJoint& joint) {
    const std::size_t freedoms = joint.kind == model::JointKind::ball ? 3 : 0;
    return joint.actuated && joint.control_axes.size() < freedoms;
  });
}

Rows rows_of_optimality(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  return {
      held("First-order optimality (KKT)", proof.kkt, "", proof.kkt_allowed(problem.tolerance),
           "Largest part of the cost’s gradient that no multiplier of the goal explains, relative to the gradient "
           "itself."),
      second_order_row(proof.second_order.value_or(optimality::SecondOrder{})),
      {"Curvature, all axes free",
       proof.all_axes || !proof.second_order || confines_axes(problem)
           ? curvature_value(proof.all_axes.value_or(optimality::AllAxes{}).second_order)
           : "no axes are confined",
       "", std::nullopt,
       "The same with every direction moved that the joints leave free, where control_axes confine them. Below zero: "
       "moments out of these axes would lower the cost."},
  };
}

// What another integrator makes of the moments.
Rows rows_of_replay(const certificate::Replay& replay) {
  return {
      held("Replay, rotation", replay.rotation_error, "rad", replay.rotation_mark,
           "The stored controls through another integrator of the continuous equations, restarted from the stored "
           "state at "
           "each window’s start: largest rotation error at a window’s end."),
      held("Replay, position", replay.position_error, "m",
           std::isfinite(replay.position_mark) ? replay.position_mark : unset,
           "The same for the root’s position, beside a tenth of the displacement that is asked for."),
      shown("Replay window", replay.window, "s", "Time between two restarts of the replay."),
      shown("Whole replay, rotation", replay.whole_rotation_error, "rad",
            "The same replay, never restarted. Unstable motions amplify any difference, so this is no fault of the "
            "solution."),
      shown("Whole replay, position", replay.whole_position_error, "m", "The same for the root’s position."),
      held("Replay with feedback, rotation", replay.feedback_rotation_error, "rad", certificate::feedback_mark,
           "The same replay, never restarted, with the stored gains: moments answer how far it is off the answer, as a "
           "vehicle’s would."),
      shown("Replay with feedback, position", replay.feedback_position_error, "m", "The same for the root’s position."),
      shown("Position-controlled joints: attitude error", replay.servo_rotation_error, "rad",
            "Where the root ends if servos lead the joints along the answer’s angles, whatever moments that takes, "
            "beside "
            "where it should. Not where freedoms of the joints move that nothing drives."),
      shown("Position-controlled joints: position error", replay.servo_position_error, "m",
            "The same for the root’s position."),
      shown(
          "Work by the replay", replay.work, "J",
          "What the joints do between the nodes, too, where costs beside effort are asked for: next to the work of the "
          "nodes where the steps resolve it."),
      shown("Growth rate", replay.growth_rate, "1/s",
            "How fast small perturbations grow along the motion: as e to this rate × time."),
  };
}

// What other steps make of the cost.
Rows rows_of_refinement(const certificate::Refinement& refinement) {
  Rows rows = {
      cost_row("Cost at half the step", refinement.cost_half_step,
               "Cost of the same problem solved with twice the steps."),
      shown("Observed order", refinement.observed_order, "", "Order at which the cost settles as the step is halved."),
      cost_row("Cost in the limit", refinement.cost_limit, "Cost extrapolated to steps of no length."),
      shown("Discretisation error of the cost", refinement.cost_error, "(N m)² s",
            "Distance of the answer’s cost from that."),
  };
  for (CertificateRow& row : rows) row.stored = true;
  return rows;
}

}  // namespace

std::string clearance_words(const evidence::Clearance& clearance, const result::ResolvedProblem& problem) {
  if (std::isnan(clearance.gap) || clearance.first < 0 || clearance.second < 0) return number(unset);
  const std::string pair = fmt::format("{} and {}", problem.bodies[static_cast<std::size_t>(clearance.first)].name,
                                       problem.bodies[static_cast<std::size_t>(clearance.second)].name);
  const std::string time = number(clearance.time, 6) + " s";
  const std::optional<double> asked = problem.limits.clearance;
  const bool between = asked && clearance.gap < (1.0 - undercut) * *asked;
  if (clearance.gap >= 0.0)
    return fmt::format("{} m: {} at {}{}", number(clearance.gap, 3), pair, time,
                       between ? fmt::format(", where the limit of {} m holds at nodes alone", number(*asked, 3)) : "");
  return fmt::format("bodies pass through each other: {} by {} m at {}{}", pair, number(-clearance.gap, 3), time,
                     asked ? fmt::format(" (limits.clearance asks for {} m, at nodes)", number(*asked, 3)) : "");
}

namespace {

Rows rows_of_multipliers(const certificate::Certificate& proof) {
  if (!proof.limits || std::isnan(proof.limits->complementarity)) return {};
  return {held("Pull of limits not reached", proof.limits->complementarity, "", complementarity_mark,
               "Largest product of a limit’s multiplier and its margin, of the cost over the duration: a minimum is "
               "held by limits that are reached."),
          held("Limits that push the wrong way", proof.limits->negative, "", sign_mark,
               "Most negative multiplier of a limit, of the largest: a limit keeps a motion in, it does not push it "
               "out.")};
}

}  // namespace

Rows certificate_rows(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  Rows all;
  for (const Rows& rows : {rows_of_goal(proof, problem), rows_of_mechanics(proof, problem), rows_of_file(proof),
                           rows_of_optimality(proof, problem), rows_of_multipliers(proof),
                           rows_of_replay(proof.replay.value_or(certificate::Replay{})),
                           rows_of_refinement(proof.refinement.value_or(certificate::Refinement{}))})
    all.insert(all.end(), rows.begin(), rows.end());
  if (proof.costs)
    all.push_back(held("Signs of powers", proof.costs->signs, "", sign_mark,
                       "How far a joint’s power is from what its multipliers belong to, of its largest: the "
                       "multipliers are the powers’ signs, and less where a power vanishes or changes its sign."));
  return all;
}

}  // namespace lamprey::report
