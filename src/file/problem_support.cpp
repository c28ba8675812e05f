// What the interface describes and this version cannot solve yet: said plainly, at the key's place, with what to use instead.
#include <algorithm>

#include <fmt/format.h>

#include "file/keep_out_checks.hpp"
#include "file/plane_checks.hpp"
#include "file/problem_file.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"
#include "fluid/gap.hpp"
#include "maneuver/ends_within_limits.hpp"
#include "maneuver/maneuver.hpp"

namespace lamprey::file {

namespace {

[[noreturn]] void refuse_unsupported(const std::string& key, const std::string& found, const std::string& allowed,
                                     const std::string& cure) {
  throw model::InputError(
      key, fmt::format("found {}, for which this version seeks no maneuvers yet; allowed for now: {}; {}", found,
                       allowed, cure));
}

constexpr double hardly = 1e-9;      // of what joints leave
constexpr double small_ball = 1e-3;  // of a body's least semi-axis, that stands for a point

constexpr const char* only_by_newton = "remove this key, or set control.kind = \"steps\" without --solver ipopt";

// What the transcription for Ipopt, and spline moments with it, lack.
void require_supported_swimmer(const model::SwimmerDescription& swimmer) {
  for (std::size_t i = 0; i < swimmer.bodies.size(); ++i)
    if (const auto& coupling = swimmer.bodies[i].coupling_matrix; coupling && !coupling->isZero(0.0))
      refuse_unsupported(fmt::format("body[{}].coupling_matrix", i), "a matrix that is not zero", "zero",
                         only_by_newton);
}

// And what the certificate's checks of spline moments lack.
void require_supported_spline(const model::SwimmerDescription& swimmer) {
  constexpr const char* only_at_steps = "remove this key, or set control.kind = \"steps\"";
  for (std::size_t j = 0; j < swimmer.joints.size(); ++j) {
    const model::JointDescription& joint = swimmer.joints[j];
    const std::string path = fmt::format("joint[{}]", j);
    if (joint.stiffness > 0.0)
      refuse_unsupported(path + ".stiffness", shown(joint.stiffness), "0.0 (N m/rad)", only_at_steps);
    if (joint.damping > 0.0)
      refuse_unsupported(path + ".damping", shown(joint.damping), "0.0 (N m s/rad)", only_at_steps);
    if (joint.kind != JointKind::ball)
      refuse_unsupported(path + ".kind", document::in_quotes(word(joint.kind)), "\"ball\"",
                         "use a ball joint, or set control.kind = \"steps\"");
  }
}

void require_supported_scheme(Scheme scheme, bool transcribed, bool momentum) {
  if (transcribed && scheme != Scheme::trapezoid && scheme != Scheme::paper)
    refuse_unsupported("integrator.scheme",
                       document::in_quotes(word(scheme)) + " with spline moments or --solver ipopt",
                       "\"trapezoid\" (order 2) or \"paper\" (order 1)",
                       "use \"trapezoid\", or set control.kind = \"steps\" without --solver ipopt");
  if (momentum && !integrator::single_step(scheme))
    refuse_unsupported("integrator.scheme", document::in_quotes(word(scheme)) + " with a start with momentum",
                       "\"trapezoid\" or \"midpoint\" (order 2), \"paper\" (order 1)",
                       "use \"trapezoid\", or begin without momentum");
}

std::string first_limit(const maneuver::Limits& limits) {
  const auto first = [](const std::string& path, const auto& by_joint) {
    return document::key_path(path, by_joint.begin()->first);
  };
  if (limits.torque) return "limits.torque";
  if (!limits.joint_torque.empty()) return first("limits.torque", limits.joint_torque);
  if (!limits.swing.empty()) return first("limits.swing", limits.swing);
  if (!limits.twist.empty()) return first("limits.twist", limits.twist);
  if (!limits.angle.empty()) return first("limits.angle", limits.angle);
  if (limits.torque_component) return "limits.torque_component";
  if (!limits.joint_torque_component.empty()) return first("limits.torque_component", limits.joint_torque_component);
  if (limits.angular_velocity) return "limits.angular_velocity";
  if (!limits.joint_angular_velocity.empty()) return first("limits.angular_velocity", limits.joint_angular_velocity);
  if (limits.angular_velocity_component) return "limits.angular_velocity_component";
  if (!limits.joint_angular_velocity_component.empty())
    return first("limits.angular_velocity_component", limits.joint_angular_velocity_component);
  if (!limits.spheres.empty()) return "limits.sphere";
  if (!limits.half_spaces.empty()) return "limits.half_space";
  return "limits.clearance";
}

void require_supported_maneuver(const maneuver::Problem& problem, Purpose purpose, bool momentum) {
  if (!problem.goal)
    refuse("goal", "no [goal]", "a [goal] with move, turn, rotation.NAME or rest",
           "add one; `lamprey simulate` needs none");
  const bool composed = !integrator::single_step(problem.scheme);
  const bool spline = problem.control == maneuver::ControlKind::spline;
  const std::string mend =
      composed ? "use scheme = \"trapezoid\"" : "use control.kind = \"steps\" without --solver ipopt";
  if (composed || spline) {
    if (problem.limits.any()) refuse_unsupported(first_limit(problem.limits), "a limit", "no [limits]", mend);
    if (problem.duration.free) refuse_unsupported("time.duration", "\"free\"", "a number > 0 (s)", mend);
    if (problem.goal->periodic) refuse_unsupported("goal.periodic", "true", "false", mend);
    if (!problem.waypoints.empty()) refuse_unsupported("waypoint[0]", "a waypoint", "no [[waypoint]]", mend);
  }
  if ((composed || spline) && problem.cost_weights.of_displacement())
    refuse_unsupported("cost.displacement", shown(problem.cost_weights.displacement), "effort and time alone", mend);
  if (momentum && problem.goal->periodic)
    refuse("start", "total momentum, with which this version takes no periodic goal",
           "velocities whose total momentum is zero", "take them out, or let goal.periodic be false");
  if (momentum && problem.goal->joints_rest && (spline || composed || purpose == Purpose::solve_with_ipopt))
    refuse("goal.rest", "\"joints\" with a start that carries momentum",
           "with control.kind = \"steps\", a scheme of order 1 or 2 and without --solver ipopt",
           "use those, or rest = false");
  if (!spline && purpose != Purpose::solve_with_ipopt && !composed) return;
  const bool universal = std::any_of(problem.swimmer.joints.begin(), problem.swimmer.joints.end(),
                                     [](const auto& joint) { return joint.kind == JointKind::universal; });
  if (!composed && !spline && !universal) return;
  const maneuver::CostWeights& weights = problem.cost_weights;
  for (const auto& [key, weight] :
       {std::pair("cost.work", weights.work), std::pair("cost.power", weights.power),
        std::pair("cost.smoothness", weights.smoothness), std::pair("cost.angular_velocity", weights.angular_velocity),
        std::pair("cost.transport", weights.transport)})
    if (weight > 0.0)
      refuse_unsupported(key, shown(weight) + (composed || spline ? "" : " with a universal joint"),
                         "effort and time alone", mend);
}

void refuse_end(const model::System& system, const char* end, const maneuver::BrokenLimit& broken,
                const std::string& bent, const std::string& mend) {
  const maneuver::LimitRow& row = *broken.row;
  refuse(row.listed_key(),
         fmt::format("a {} that breaks this limit{} by {:.3g} {}{}", end, row.body >= 0 ? row.bearer(system) : "",
                     broken.excess, row.unit_name(), bent),
         fmt::format("a {} within the limits", end), mend);
}

// How a joint that breaks a limit begins, ", bent by 1.571 rad"; empty where no joint does.
std::string bent_at_start(const model::System& system, const maneuver::Maneuver& maneuver, int joint) {
  if (joint < 0) return "";
  const model::Joint& own = system.joint(joint);
  const Eigen::Vector3d angles =
      mechanics::turn_from_zero(own, mechanics::child_to_parent(maneuver.start.rotation, own), Eigen::Vector3d::Zero());
  const int count = own.free() ? 3 : system.body(own.child).freedoms;
  std::string words;
  for (int axis = 0; axis < count; ++axis) words += fmt::format("{}{:.4g}", axis > 0 ? ", " : "", angles[axis]);
  return fmt::format(", bent by {} rad", count > 1 ? "(" + words + ")" : words);
}

// m, how far a body is from a point that moves with it, seen from its mass centre; 0 inside.
double distance_to(const model::Body& body, const Eigen::Vector3d& point) {
  const double ball = small_ball * body.semi_axes.minCoeff();
  const fluid::Gap gap = fluid::gap({body.semi_axes, Eigen::Vector3d::Constant(ball), Eigen::Matrix3d::Identity(),
                                     Eigen::Matrix3d::Identity(), point});
  return std::max(gap.value + ball, 0.0);
}

// However a joint bends, from body to body it is no farther than through the joint.
void require_clearance_of_joined(const ProblemFile& file) {
  const maneuver::Problem& problem = file.problem;
  if (!problem.limits.clearance) return;
  const model::System system(problem.swimmer);
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    if (joint.kind == model::JointKind::fixed) continue;
    const model::Body &parent = system.body(joint.parent), &child = system.body(joint.child);
    const double most = distance_to(parent, joint.parent_offset) + distance_to(child, joint.child_offset);
    if (*problem.limits.clearance <= most * (1.0 + hardly)) continue;
    throw model::InputError(
        "limits.clearance",
        fmt::format("found {} m; allowed: at most {:.4g} m, which joint {} leaves between {} and {} however it bends; "
                    "lower the clearance or set the joint's offsets farther out",
                    shown(*problem.limits.clearance), most, joint.name, parent.name, child.name));
  }
}

}  // namespace

void require_ends_within_limits(const ProblemFile& file) {
  const maneuver::Problem& problem = file.problem;
  if (!problem.goal) return;
  try {
    const model::System system(problem.swimmer);
    maneuver::make_maneuver(system, problem, problem.steps);  // refuses contradictions
    const maneuver::Problem told = with_plane_told(system, problem);
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, told, problem.steps);
    const std::vector<maneuver::LimitRow> rows = maneuver::limit_rows(system, problem);
    require_clearance_of_joined(file);
    if (problem.start.free_shape) return require_room_for_root(system, told);
    if (const auto broken = maneuver::broken_by_start(system, maneuver, rows)) {
      const int joint = broken->row->joint;
      const std::string own =
          joint < 0 ? "[start]"
                    : document::key_path("start.angle", system.joint(joint).name) + " or " +
                          document::key_path("start.rotation", system.body(system.joint(joint).child).name);
      refuse_end(system, "start", *broken, bent_at_start(system, maneuver, joint),
                 fmt::format("change {}, let start.free_shape be true, or widen the limit", own));
    }
    if (problem.goal->periodic) return require_room_for_root(system, told);
    if (const auto broken = maneuver::broken_by_goal(system, maneuver, rows))
      refuse_end(system, "goal", *broken, "", "change [goal], or widen the limit");
    require_room_for_root(system, told);
  } catch (const model::InputError& error) {
    throw located(error, file);
  }
}

void require_supported(const ProblemFile& file, Purpose purpose) {
  const maneuver::Problem& problem = file.problem;
  try {
    const bool momentum = maneuver::has_momentum(model::System(problem.swimmer), problem.start);
    const bool transcribed = purpose == Purpose::solve_with_ipopt || problem.control == maneuver::ControlKind::spline;
    if (transcribed) require_supported_swimmer(problem.swimmer);
    if (problem.control == maneuver::ControlKind::spline) require_supported_spline(problem.swimmer);
    require_supported_scheme(problem.scheme, transcribed, momentum);
    require_supported_maneuver(file.problem, purpose, momentum);
    require_ends_within_limits(file);
  } catch (const model::InputError& error) {
    throw located(error, file);
  }
}

}  // namespace lamprey::file
