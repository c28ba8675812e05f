#include "task/march_remarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "integrator/scheme.hpp"
#include "lie/so3.hpp"
#include "maneuver/energy_balance.hpp"
#include "maneuver/goal_miss.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/tracking.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::task {

namespace {

using maneuver::Problem;

// Of moments that belong to a motion that began otherwise than this march, as a sentence; empty where it did not. Where the whole
// lies and how it is headed is no difference.
std::string other_start(const result::ControlSamples& samples, const model::System& system,
                        const maneuver::Start& start) {
  constexpr double same = 1e-6;  // rad, rad/s, units of length a second: of what people see
  if (!samples.first || samples.first->rotation.size() != start.rotation.size()) return "";
  const integrator::State was = maneuver::start_state(system, *samples.first),
                          is = maneuver::start_state(system, start);
  double turned = 0.0;
  const Eigen::Matrix3d heading = is.rotation[0] * was.rotation[0].transpose();
  for (std::size_t i = 0; i < was.rotation.size(); ++i)
    turned = std::max(turned, lie::rotation_angle(was.rotation[i].transpose() * heading.transpose() * is.rotation[i]));
  Eigen::VectorXd faster = integrator::velocity_of_state(system, was);
  faster.tail<3>() = heading * Eigen::Vector3d(faster.tail<3>());
  faster -= integrator::velocity_of_state(system, is);
  const double most = faster.lpNorm<Eigen::Infinity>();
  Eigen::VectorXd seen = faster;
  seen.tail<3>() /= system.length_unit();
  if (!(turned > same || seen.lpNorm<Eigen::Infinity>() > same)) return "";
  return fmt::format(
      " The moments are those of a motion that began otherwise: bodies turned by up to {:.3g} rad, and velocities "
      "by up to {:.3g} (rad/s, m/s), beside this march's start.",
      turned, most);
}

// Steps for each second that a motion has.
double steps_per_second(const result::Results& results) {
  const std::vector<double>& time = results.solution.time;
  return time.size() < 2 ? 0.0 : static_cast<double>(time.size() - 1) / time.back();
}

// Whether it kept to its plan, and why not.
std::string remarks_on_tracking(const maneuver::Tracking& tracking, const MarchOptions& options,
                                const Problem& problem) {
  constexpr double fewer = 0.99;
  std::string text;
  const double duration = problem.duration.value, planned = steps_per_second(*options.followed) * duration;
  const bool coarse = !options.reference && problem.steps < fewer * planned;
  if (tracking.lost() && tracking.cut_first())
    text += fmt::format(
        " The feedback had lost the plan, {:.2g} rad beside it at most: its motors are at their limits of "
        "torque from {:.3g} s on; a plan with smaller limits leaves them a reserve.",
        tracking.largest_rotation_error, *tracking.cut_from);
  else if (tracking.lost() && coarse)
    text += fmt::format(
        " The feedback had lost the plan, {:.2g} rad beside it at most: the plan has {:.0f} steps in this time, the "
        "march has {}; --steps {:.0f} marches as many.",
        tracking.largest_rotation_error, planned, problem.steps, planned);
  else if (tracking.lost())
    text += fmt::format(
        " The feedback had lost the plan, {:.2g} rad beside it at most{}: its gains answer smaller "
        "differences of start, swimmer and scheme only, and neither more steps nor stronger motors mend "
        "that; servos along the maneuver's angles (--angles) may, or plans renewed on the way.",
        tracking.largest_rotation_error,
        tracking.off_from ? fmt::format(", from {:.3g} s on", *tracking.off_from) : "");
  if (tracking.cut_share > 0.0)
    text += fmt::format(
        " At {:.1f} % of the times at which the feedback asked for moments the problem's limits of torque cut some.",
        100.0 * tracking.cut_share);
  return text;
}

std::string remark_on_energy(const model::System& system, const result::Results& results) {
  const auto energy = energy_out_of_balance(system, results);
  if (!energy) return "";
  return fmt::format(
      " Energy balance: off by up to {:.3g} J that no moment has worked; these steps do not resolve the motion, try "
      "--steps {}.",
      energy->unworked, 4 * results.problem.steps);
}

// How far it ends from the goal of its problem.
std::string remark_on_goal(const model::System& system, const Problem& asked, const maneuver::Solution& solution) {
  if (solution.status != maneuver::Status::simulated) return "";
  const auto miss = maneuver::goal_miss(system, asked, solution);
  if (!miss || (!miss->turns() && !miss->moves)) return "";
  std::string words;
  if (miss->turns())
    words += fmt::format("{:.3g} rad ({})", miss->rotation,
                         miss->joint >= 0 ? "joint " + system.joint(miss->joint).name : system.body(miss->body).name);
  if (miss->moves) words += fmt::format("{}{:.3g} m", words.empty() ? "" : " and ", miss->position);
  return fmt::format(" It ends {} beside the goal.", words);
}

// A table or a stored motion of another length than the march.
std::string remark_on_length(const MarchOptions& options, const maneuver::Duration& asked, double marched) {
  constexpr double same = 1e-9;
  if (options.controls) {
    const double whole = options.controls->time.back();
    if (whole <= (1.0 + same) * marched) return "";
    return fmt::format(
        " The moments go on until {:.4g} s, of which this march has the first {:.4g} s; --duration {:.4g} marches the "
        "whole.",
        whole, marched, whole);
  }
  if (!options.angles || options.duration > 0.0 || asked.free || options.cycles > 1) return "";
  if (std::abs(marched - asked.value) <= same * asked.value) return "";
  return fmt::format(" The angles take {:.4g} s, and so does this march; the file's duration is {:.4g} s.", marched,
                     asked.value);
}

// Where a march by a table of moments ends early: long steps may have more than one answer, and a table tells none from the other.
std::string remark_on_table(const MarchOptions& options, const maneuver::Solution& solution) {
  if (solution.status != maneuver::Status::stalled || !options.controls || options.controls->first) return "";
  return " A table of moments tells nothing of the motion that they were made for: --controls with its solution.json "
         "seeks "
         "each step where that went.";
}

// Angles that look like degrees, and a first shape that is not the problem's.
std::string remarks_on_angles(const MarchOptions& options, const model::System& system, const Problem& asked) {
  constexpr double three_turns = 6.0 * std::numbers::pi, same = 1e-6;  // rad
  if (!options.angles || options.angles->first) return "";
  const result::AngleSamples& angles = *options.angles;
  std::string far, elsewhere;  // of the first joint that is
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const auto place = static_cast<std::size_t>(j);
    if (!angles.passive.empty() && angles.passive[place]) continue;
    double most = 0.0;
    for (const auto& node : angles.angle) most = std::max(most, node[place].lpNorm<Eigen::Infinity>());
    if (most >= three_turns && far.empty())
      far = fmt::format(" The angles of {} go to {:.4g} rad, {:.3g} turns; are they meant in radians?", joint.name,
                        most, most / (2.0 * std::numbers::pi));
    const Eigen::Matrix3d begins = mechanics::rotation_at_turn(joint, angles.angle.front()[place]),
                          was = lie::exp(asked.start.rotation[model::at(joint.parent)]).transpose() *
                                lie::exp(asked.start.rotation[model::at(joint.child)]);
    const double beside = lie::rotation_angle(was.transpose() * begins);
    if (beside > same && elsewhere.empty() && !asked.start.free_shape)
      elsewhere = fmt::format(" The march begins with {} as the angles have it, {:.3g} rad beside the problem's start.",
                              joint.name, beside);
  }
  return far + elsewhere;
}

// What people should know of a march, as further sentences.
std::string remarks_on_what_is_marched(const MarchOptions& options, const model::System& system, const Problem& problem,
                                       const result::Results& results) {
  std::string text;
  if (results.solution.tracking) text += remarks_on_tracking(*results.solution.tracking, options, problem);
  if (options.followed) {
    constexpr double whole_share = 1.0 - 1e-9;
    const double whole = options.followed->solution.time.back(), marched = problem.duration.value;
    const double from = options.followed_from;
    if (from > 0.0)
      text +=
          fmt::format(" The maneuver that is followed takes {:.4g} s, of which this march has {:.4g} s to {:.4g} s.",
                      whole, from, from + marched);
    else if (marched < whole_share * whole)
      text += fmt::format(
          " The maneuver that is followed takes {:.4g} s, of which this march has the first {:.4g} s; --duration {} "
          "marches the whole.",
          whole, marched, whole);
  }
  if (problem.duration.free)
    text += fmt::format(
        " The duration is free, from {:.4g} s to {:.4g} s: this march takes {:.4g} s; --duration sets another.",
        problem.duration.min, problem.duration.max, problem.duration.value);
  if (!options.controls) return text;
  if (problem.start.free_shape && !options.controls->first)
    text +=
        " A gait of these bodies begins in a shape of its own (start.free_shape), of which a table of moments tells "
        "nothing: this march began as the file says; --controls with the gait's solution.json begins as it does.";
  const std::string missing = result::left_out(*options.controls, results.problem.joints);
  text += (missing.empty() ? "" : " ") + missing;
  return options.perturb > 0.0 ? text : text + other_start(*options.controls, system, problem.start);
}

}  // namespace

std::optional<maneuver::EnergyBalance> energy_out_of_balance(const model::System& system,
                                                             const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  if (solution.status != maneuver::Status::simulated || !solution.marched_by.empty()) return std::nullopt;
  if (system.compliant() || !integrator::single_step(results.problem.scheme)) return std::nullopt;
  if (solution.tracking && solution.tracking->lost()) return std::nullopt;  // which has its own words
  const auto energy = maneuver::energy_balance(system, solution);
  return energy && energy->off() ? energy : std::nullopt;
}

std::string march_remarks(const MarchOptions& options, const model::System& system, const Problem& problem,
                          const Problem& with_goal, const maneuver::Duration& asked, const result::Results& results) {
  return remarks_on_what_is_marched(options, system, problem, results) + remark_on_table(options, results.solution) +
         remark_on_length(options, asked, problem.duration.value) + remarks_on_angles(options, system, with_goal) +
         remark_on_goal(system, with_goal, results.solution) + remark_on_energy(system, results);
}

}  // namespace lamprey::task
