#include "task/model_remarks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "document/text_table.hpp"
#include "document/toml_document.hpp"
#include "lie/so3.hpp"
#include "mechanics/continuous.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::task {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using maneuver::Problem;
using model::at;
using model::Body;
using model::Joint;
using model::System;

constexpr double far_from_displaced = 20.0;  // times heavier or lighter
constexpr double trimmed = 0.02;             // of what is displaced, that vehicles trim away
constexpr double gravity = 9.81;             // m/s²
constexpr double lightest_liquid = 50.0;     // kg/m³
constexpr double rounded_digits = 0.02;      // of a mass or inertia, by which given matrices may fall short of the body
constexpr double far_off = 2.0;              // times the way to the body's surface
constexpr double far_within = 5e-3;          // likewise: a length in another unit is 10⁻³ of that
constexpr double inertia_range = 1e10;       // of the bodies' J: round-off of the largest covers the smallest
constexpr double far_goal = 5.0;             // lengths of the swimmer
constexpr double half_turn_slack = 1e-3;     // rad, of a half turn that was rounded
constexpr double much_easier = 1e3;          // times as far as another joint's, that a moment bends a joint

double least_eigenvalue(const Matrix3d& m) {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

std::string mass_remark(const Body& body, const model::BodyDescription& described, double density) {
  const double displaced = density * body.volume;
  if (!described.mass || described.mass_matrix || displaced == 0.0) return "";
  const double ratio = body.mass / displaced;
  if (ratio < far_from_displaced && ratio > 1.0 / far_from_displaced) return "";
  return fmt::format("{} has {} kg and displaces {} kg of fluid; are mass, semi_axes (m) and density (kg/m³) meant so?",
                     document::printable(body.name), document::short_number(body.mass),
                     document::short_number(displaced));
}

// Bodies of given mass matrices are anybody's; those that state nothing float.
std::string weight_remark(const Problem& problem, const System& system) {
  double mass = 0.0, displaced = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    if (problem.swimmer.bodies[at(i)].mass_matrix) return "";
    mass += system.body(i).mass;
    displaced += system.density() * system.body(i).volume;
  }
  if (displaced == 0.0 || std::abs(mass - displaced) <= trimmed * displaced) return "";
  return fmt::format("the bodies have {} kg and displace {} kg of fluid: {} N of {}, which the model leaves out",
                     document::short_number(mass), document::short_number(displaced),
                     document::short_number(gravity * std::abs(mass - displaced)),
                     mass > displaced ? "weight" : "buoyancy");
}

std::string density_remark(const Problem& problem) {
  const auto& bodies = problem.swimmer.bodies;
  const double density = problem.swimmer.density;
  const bool computed = std::any_of(bodies.begin(), bodies.end(), [](const auto& body) { return !body.mass_matrix; });
  if (!computed || density == 0.0 || density >= lightest_liquid) return "";
  return fmt::format("a fluid of {} kg/m³ is a gas; water has 1000 kg/m³, which is 1 g/cm³",
                     document::short_number(density));
}

std::string total_remark(const Body& body, bool given, const char* key, const Matrix3d& total, const Matrix3d& alone,
                         const char* what) {
  if (!given || least_eigenvalue(total - alone) >= -rounded_digits * alone.trace() / 3.0) return "";
  return fmt::format("{}.{} is less than {} alone, as if the fluid took some away; it is body + fluid",
                     document::printable(body.name), key, what);
}

std::string offset_remark(const Joint& joint, const char* key, const Vector3d& offset, const Body& body) {
  const double surfaces = offset.cwiseQuotient(body.semi_axes).norm();
  if (surfaces > 0.0 && surfaces < far_within)
    return fmt::format(
        "{}.{}: the joint sits {} m off the centre of {}, {:.1g} of the way to its surface; are semi_axes and offsets "
        "both in m?",
        document::printable(joint.name), key, document::short_number(offset.norm()), document::printable(body.name),
        surfaces);
  if (surfaces < far_off) return "";
  return fmt::format("{}.{}: the joint sits {} m off the centre of {}, {} times as far as its surface",
                     document::printable(joint.name), key, document::short_number(offset.norm()),
                     document::printable(body.name), fmt::format("{:.3g}", surfaces));
}

std::string range_remark(const System& system) {
  const auto size = [](const Body& body) { return body.inertia_matrix.trace(); };
  const auto [least, largest] = std::minmax_element(system.bodies().begin(), system.bodies().end(),
                                                    [&](const Body& a, const Body& b) { return size(a) < size(b); });
  if (size(*largest) < inertia_range * size(*least)) return "";
  return fmt::format("inertias of {} and {} differ by a factor of {:.1g}; double precision cannot hold both",
                     document::printable(largest->name), document::printable(least->name),
                     size(*largest) / size(*least));
}

// m, of all bodies in a row.
double length_of(const System& system) {
  double length = 0.0;
  for (const Body& body : system.bodies()) length += 2.0 * body.semi_axes.maxCoeff();
  return length;
}

std::string velocity_remark(const Problem& problem, const System& system) {
  const double duration = problem.duration.free ? problem.duration.max : problem.duration.value;
  const double lengths = problem.start.linear_velocity.norm() * duration / problem.steps / length_of(system);
  if (!(lengths > 1.0)) return "";
  return fmt::format("start.linear_velocity takes the swimmer {:.3g} lengths on in each step{}; is it meant in m/s?",
                     lengths, problem.duration.free ? " of the longest duration" : "");
}

std::string goal_remark(const Problem& problem, const System& system) {
  if (!problem.goal || !problem.start.linear_velocity.isZero(0.0)) return "";  // else momentum may take it there
  double square = 0.0;
  for (const auto& move : problem.goal->move) square += move ? *move * *move : 0.0;
  const double lengths = std::sqrt(square) / length_of(system);
  if (lengths < far_goal) return "";
  return fmt::format("goal.move is {:.3g} lengths of the swimmer, who gains a fraction of one in a stroke", lengths);
}

// How fast a moment of 1 N m makes a joint's rate grow at the start, 1/(kg m²); 0 of a joint without motors.
struct Ease {
  double most = 0.0, least = 0.0;  // about the axes that it turns most easily and least
};

// [joints]
std::vector<Ease> ease_of_joints(const Problem& problem, const System& system) {
  mechanics::Rotations R(at(system.body_count()), Matrix3d::Identity());
  for (std::size_t i = 0; i < problem.start.rotation.size(); ++i) R[i] = lie::exp(problem.start.rotation[i]);
  const Eigen::VectorXd answer = mechanics::answers_to_moments(system, R);
  std::vector<Ease> ease;
  Eigen::Index control = 0;
  for (const Joint& joint : system.joints()) {
    Ease own_ease;
    for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c, ++control) {
      const double about = answer[control];
      own_ease = {std::max(own_ease.most, about), c == 0 ? about : std::min(own_ease.least, about)};
    }
    ease.push_back(own_ease);
  }
  return ease;
}

double one_digit(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  return power * std::round(value / power);
}

// Effort weighs the moments of all joints alike.
std::string light_remark(const Problem& problem, const System& system) {
  const maneuver::Limits& limits = problem.limits;
  if (problem.control != maneuver::ControlKind::steps || !integrator::single_step(problem.scheme))
    return "";  // which take none of what would help
  if (!problem.goal || problem.cost_weights.any() || limits.angular_velocity || limits.angular_velocity_component)
    return "";
  const std::vector<Ease> ease = ease_of_joints(problem, system);
  std::optional<std::size_t> lightest, heaviest;
  for (std::size_t j = 0; j < ease.size(); ++j) {
    if (ease[j].most == 0.0) continue;
    if (!heaviest || ease[j].most < ease[*heaviest].most) heaviest = j;
    const std::string& name = system.joint(static_cast<int>(j)).name;
    if (limits.joint_angular_velocity.contains(name) || limits.joint_angular_velocity_component.contains(name) ||
        limits.joint_torque.contains(name) || limits.joint_torque_component.contains(name))
      continue;
    if (!lightest || ease[j].most > ease[*lightest].most) lightest = j;
  }
  if (!lightest || ease[*lightest].most < much_easier * ease[*heaviest].most) return "";
  const std::string name = document::printable(system.joint(static_cast<int>(*lightest)).name);
  const double duration = problem.duration.free ? problem.duration.max : problem.duration.value;
  const double weight =
      problem.effort * std::pow(ease[*heaviest].least * duration, -2);  // turns cost as the effort for them
  return fmt::format(
      "a moment turns what joint {} moves some {} times as fast as one at joint {}: cost.effort weighs it next to "
      "nothing, so that the cheapest motions may whirl it as fast as steps show; where searches find no end let rates "
      "cost (cost.angular_velocity = {}), give it limits.angular_velocity.{}, or have it follow (actuated = false, "
      "with stiffness and damping)",
      name, document::short_number(one_digit(ease[*lightest].most / ease[*heaviest].most)),
      document::printable(system.joint(static_cast<int>(*heaviest)).name), document::short_number(one_digit(weight)),
      name);
}

// Rotations turn by half a turn at most: beyond it a vector means the shorter way back.
std::string turn_remark(const std::string& key, const Vector3d& turn) {
  const double angle = turn.norm(), whole = 2.0 * std::numbers::pi;
  if (angle <= std::numbers::pi + half_turn_slack) return "";
  return fmt::format("{} turns by {} rad, which ends where {} rad the other way do; is it meant in radians?", key,
                     document::short_number(angle), document::short_number(whole - angle));
}

// Of joints that end at an angle whole turns are not told apart.
std::string angle_remark(const std::string& key, double angle) {
  const double nearest = std::remainder(angle, 2.0 * std::numbers::pi);
  if (std::abs(angle) <= std::numbers::pi + half_turn_slack) return "";
  return fmt::format("{} of {} rad ends where {} rad does: a goal counts no whole turns; is it meant in radians?", key,
                     document::short_number(angle), document::short_number(nearest));
}

// Whether a point that lies so far from a body's mass centre is inside of it.
bool inside(const Body& body, const Eigen::Matrix3d& rotation, const Vector3d& from_centre) {
  return (rotation.transpose() * from_centre).cwiseQuotient(body.semi_axes).norm() < 1.0;
}

// Rotors within a hull turn about their own mass centre, or hang at the hull's: these are meant to be inside.
bool is_rotor(const System& system, const Body& body) {
  return body.joint >= 0 &&
         (system.joint(body.joint).child_offset.isZero(0.0) || system.joint(body.joint).parent_offset.isZero(0.0));
}

// Bodies that begin so deep within each other that the mass centre of each is inside of the other; the first two, and how many more.
std::string overlap_remark(const Problem& problem, const System& system) {
  mechanics::Rotations R;
  for (int i = 0; i < system.body_count(); ++i) R.push_back(lie::exp(problem.start.rotation[at(i)]));
  const std::vector<Vector3d> centres = system.mass_centres(R, problem.start.position);
  std::string first;
  int pairs = 0;
  for (int i = 0; i < system.body_count(); ++i)
    for (int k = i + 1; k < system.body_count(); ++k) {
      const Body &one = system.body(i), &other = system.body(k);
      const Vector3d way = centres[at(k)] - centres[at(i)];
      if (!inside(one, R[at(i)], way) || !inside(other, R[at(k)], -way)) continue;
      if (system.move_as_one(i, k) || is_rotor(system, one) || is_rotor(system, other)) continue;
      if (++pairs == 1)
        first = fmt::format("{} and {}", document::printable(one.name), document::printable(other.name));
    }
  if (pairs == 0) return "";
  return fmt::format(
      "{}{} begin within each other, the mass centre of each inside of the other; do parent_offset and child_offset "
      "point from the mass centres to the joint, each in its own body's frame and in m?",
      first, pairs > 1 ? fmt::format(" and {} more {}", pairs - 1, pairs == 2 ? "pair" : "pairs") : "");
}

// Two hinges whose axes, as the swimmer begins, are parallel but for digits that were left out.
std::string axes_remark(const Problem& problem, const System& system) {
  constexpr double round_off = 1e-12, rounded = 1e-4;  // rad
  std::vector<std::pair<const Joint*, Vector3d>> axes;
  for (const Joint& joint : system.joints()) {
    if (joint.kind != model::JointKind::hinge) continue;
    const Vector3d axis = lie::exp(problem.start.rotation[at(joint.child)]) * joint.child_axis;
    for (const auto& [other, its] : axes)
      if (const double beside = its.cross(axis).norm(); beside > round_off && beside < rounded)
        return fmt::format(
            "the axes of {} and {} are parallel but for {} rad, which takes the swimmer out of its plane; with all "
            "digits "
            "(π is {}) it stays there",
            document::printable(other->name), document::printable(joint.name),
            document::short_number(one_digit(beside)), std::numbers::pi);
    axes.emplace_back(&joint, axis);
  }
  return "";
}

// Bodies on ball joints of which nothing is stated begin as the world is turned, while all others go with their parents.
std::string left_behind_remark(const file::ProblemFile& file, const System& system) {
  constexpr double bent = 1e-3;  // rad
  const maneuver::Start& start = file.problem.start;
  if (start.free_shape) return "";
  const auto stated = [&](const char* table, const std::string& name) {
    return file.positions.contains(document::key_path(table, name));
  };
  const Joint* first = nullptr;
  double first_angle = 0.0;
  int more = 0;
  for (const Joint& joint : system.joints()) {
    if (!joint.free() || stated("start.rotation", system.body(joint.child).name) || stated("start.angle", joint.name))
      continue;
    const Matrix3d parent = lie::exp(start.rotation[at(joint.parent)]);
    const double angle = lie::rotation_angle(
        Matrix3d((parent * joint.reference_rotation).transpose() * lie::exp(start.rotation[at(joint.child)])));
    if (lie::rotation_angle(parent) < bent || angle < bent) continue;
    if (first != nullptr)
      ++more;
    else
      first = &joint, first_angle = angle;
  }
  if (first == nullptr) return "";
  const std::string &parent = system.body(first->parent).name, &child = system.body(first->child).name;
  return fmt::format(
      "{} begins turned, {} (on a ball joint{}) does not turn with it, so that the joint begins bent by {:.3g} rad; "
      "give {}, or {} = [0, 0, 0] to begin straight",
      document::printable(parent), document::printable(child), more == 0 ? "" : fmt::format("; so are {} more", more),
      first_angle, document::key_path("start.rotation", child), document::key_path("start.angle", first->name));
}

}  // namespace

std::vector<std::string> model_remarks(const file::ProblemFile& file, const System& system) {
  std::vector<std::string> remarks = model_remarks(file.problem, system);
  if (std::string remark = left_behind_remark(file, system); !remark.empty()) remarks.push_back(std::move(remark));
  return remarks;
}

std::vector<std::string> model_remarks(const Problem& problem, const System& system) {
  std::vector<std::string> remarks;
  const auto add = [&](std::string remark) {
    if (!remark.empty()) remarks.push_back(std::move(remark));
  };
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const model::BodyDescription& described = problem.swimmer.bodies[at(i)];
    add(mass_remark(body, described, system.density()));
    add(total_remark(body, described.mass_matrix.has_value(), "mass_matrix", body.mass_matrix,
                     body.mass * Matrix3d::Identity(), "its mass"));
    add(total_remark(body, described.inertia_matrix.has_value(), "inertia_matrix", body.inertia_matrix,
                     body.body_inertia, "its inertia"));
  }
  for (const Joint& joint : system.joints()) {
    add(offset_remark(joint, "parent_offset", joint.parent_offset, system.body(joint.parent)));
    add(offset_remark(joint, "child_offset", joint.child_offset, system.body(joint.child)));
  }
  add(overlap_remark(problem, system));
  add(weight_remark(problem, system));
  add(density_remark(problem));
  add(range_remark(system));
  add(axes_remark(problem, system));
  add(light_remark(problem, system));
  add(velocity_remark(problem, system));
  add(goal_remark(problem, system));
  if (problem.goal && problem.goal->turn) add(turn_remark("goal.turn", *problem.goal->turn));
  if (problem.goal)
    for (const auto& [body, rotation] : problem.goal->rotation)
      if (rotation) add(turn_remark(document::printable(document::key_path("goal.rotation", body)), *rotation));
  if (problem.goal)
    for (const auto& [joint, angles] : problem.goal->angle) {
      const std::string key = document::printable(document::key_path("goal.angle", joint));
      if (angles.size() == 3)
        add(turn_remark(key, *problem.goal->turn_of_joint(joint)));
      else
        for (const double angle : angles) add(angle_remark(key, angle));
    }
  return remarks;
}

}  // namespace lamprey::task
