#include "maneuver/maneuver.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "lie/so3.hpp"
#include "maneuver/asked_attitudes.hpp"
#include "mechanics/connection.hpp"
#include "model/input_error.hpp"
#include "model/world_axes.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::InputError;
using model::System;
using model::world_axes;

constexpr double no_rate = 1e-12;    // of what bodies turn at, that joints turn at
constexpr double most_misfit = 0.1;  // rad, of a measured rotation beside its joint

// The only axis about which moments turn a joint, in the parent's frame.
Vector3d axis_of_turn(const model::Joint& joint, const Matrix3d& child_to_parent) {
  switch (joint.kind) {
    case model::JointKind::hinge:
      return child_to_parent * joint.child_axis;
    case model::JointKind::universal:
      return joint.actuation(0, 0) != 0.0 ? joint.parent_axis : Vector3d(child_to_parent * joint.child_axis);
    case model::JointKind::ball:
    case model::JointKind::fixed:
      break;
  }
  return joint.actuation.col(0);
}

// The largest angle between a direction and another that is carried right round an axis.
double largest_angle_on_the_way_round(const Vector3d& axis, const Vector3d& fixed, const Vector3d& carried) {
  const auto angle = [&](const Vector3d& arm) { return std::atan2(axis.cross(arm).norm(), axis.dot(arm)); };
  const double sum = angle(fixed) + angle(carried);
  return std::min(sum, 2.0 * std::numbers::pi - sum);
}

// Whether a limit certainly stops the only axis of a joint before it has turned right round: an arm that is turned about itself
// does not swing.
bool stopped_on_the_way_round(const mechanics::Rotations& start, const model::Joint& joint, const Limits& limits) {
  constexpr double beside = 1e-6;  // rad
  const Matrix3d Q = mechanics::child_to_parent(start, joint);
  const Vector3d axis = axis_of_turn(joint, Q).normalized(), arm = -(Q * joint.child_offset).normalized();
  const auto angle = limits.angle.find(joint.name);
  const auto swing = limits.swing.find(joint.name), twist = limits.twist.find(joint.name);
  if (angle != limits.angle.end()) {
    const int freedom = joint.kind == model::JointKind::universal && joint.actuation(0, 0) == 0.0 ? 1 : 0;
    const auto& [least, most] = angle->second[at(freedom)];
    if (least > beside - std::numbers::pi || most < std::numbers::pi - beside) return true;
  }
  if (swing != limits.swing.end() &&
      largest_angle_on_the_way_round(axis, joint.parent_offset.normalized(), arm) > swing->second + beside)
    return true;
  return twist != limits.twist.end() && twist->second < std::numbers::pi - beside && axis.cross(arm).norm() < beside;
}

// Whether a single joint angle is all that moves and nothing keeps it from turning right round, where the goal asks for a
// displacement that ends in the first shape: to and fro it gets nowhere, but where its momentum takes it.
bool needs_whole_turns(const System& system, const Problem& problem, const Maneuver& maneuver) {
  if (system.control_count() != 1 || !ends_in_first_shape(system, maneuver)) return false;
  if (has_momentum(system, maneuver.start)) return false;
  if (!asks_to_move(system, maneuver) && !maneuver.cost_weights.of_displacement()) return false;
  return std::all_of(system.joints().begin(), system.joints().end(), [&](const model::Joint& joint) {
    if (joint.kind == model::JointKind::fixed) return true;
    const bool held = joint.stiffness != 0.0 && joint.kind == model::JointKind::ball;
    return joint.actuation.cols() == 1 && !held &&
           !stopped_on_the_way_round(maneuver.start.rotation, joint, problem.limits);
  });
}

// What a body weighs, fluid included, where that is the same in all directions in which it moves: in a vacuum, spheres, circles in
// their plane.
std::optional<double> mass_in_all_directions(const model::Body& body) {
  constexpr double round_off = 1e-9;  // of the mass
  if (body.coupled) return std::nullopt;
  const Eigen::Index directions = body.ellipse ? 2 : 3;
  const MatrixXd matrix = body.mass_matrix.topLeftCorner(directions, directions);
  const double mass = matrix.trace() / static_cast<double>(directions);
  const MatrixXd differences = matrix - mass * MatrixXd::Identity(directions, directions);
  if (differences.norm() > round_off * mass) return std::nullopt;
  return mass;
}

// The centre of all bodies so weighted, from the root's mass centre, m; nothing where one is heavier in some directions.
std::optional<Vector3d> weighted_centre(const System& system, const mechanics::Rotations& rotation) {
  const std::vector<Vector3d> centres = system.mass_centres(rotation, Vector3d::Zero());
  Vector3d sum = Vector3d::Zero();
  double whole = 0.0;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const std::optional<double> mass = mass_in_all_directions(system.bodies()[i]);
    if (!mass) return std::nullopt;
    sum += *mass * centres[i];
    whole += *mass;
  }
  return Vector3d(sum / whole);
}

// How all bodies are turned at the end where the goal leaves none of that open and tells where the weighted centre is from the
// root. Of a gait that is free to choose its shape where the swimmer keeps its heading.
std::optional<mechanics::Rotations> fixed_attitudes(const Maneuver& maneuver) {
  const mechanics::Rotations& start = maneuver.start.rotation;
  mechanics::Rotations ends;
  if (maneuver.periodic) {
    const auto& root = maneuver.end_rotation[0];
    if (!root) return std::nullopt;
    const Matrix3d turn = *root * start[0].transpose();
    if (maneuver.free_shape && lie::rotation_angle(turn) > same_pose) return std::nullopt;
    for (const Matrix3d& R : start) ends.emplace_back(turn * R);
    return ends;
  }
  for (const auto& end : maneuver.end_rotation) {
    if (!end) return std::nullopt;
    ends.push_back(*end);
  }
  return ends;
}

// How far the weighted centre of such bodies may be from the root, all joints stretched, m.
double farthest_centre(const System& system) {
  double sum = 0.0, whole = 0.0;
  for (const model::Body& body : system.bodies()) {
    const double mass = mass_in_all_directions(body).value_or(0.0);
    double length = 0.0;
    for (const model::PathPoint& point : body.path) length += point.offset.norm();
    sum += mass * length;
    whole += mass;
  }
  return sum / whole;
}

// Where attitudes are free the root comes as far from the centre, which is there `before` unless the first shape is free, as joints are
// long.
void refuse_beyond_centre(const System& system, const Maneuver& maneuver, const Vector3d& before,
                          const std::string& put, const std::string& cure) {
  const double far = farthest_centre(system);
  for (int c = 0; c < 3; ++c) {
    const auto& asked = maneuver.end_position[at(c)];
    if (!asked) continue;
    const double way = *asked - maneuver.start.position[c];
    const double most = far + (maneuver.free_shape ? far : way > 0.0 ? before[c] : -before[c]);
    if (std::abs(way) <= most + same_pose * system.size()) continue;
    std::ostringstream text;
    text << "found " << way << " m along " << world_axes[at(c)] << ", but " << put
         << "the root moves that way by at most " << most << " m, with all joints stretched; ask for less" << cure;
    throw InputError("goal.move", text.str());
  }
}

// Linear momentum zero, Σ m_i v_i of such bodies, keeps their weighted centre where it is.
void refuse_to_move_centre(const System& system, const Maneuver& maneuver) {
  const std::optional<Vector3d> before = weighted_centre(system, maneuver.start.rotation);
  if (!before) return;
  const std::string put = std::string("each body is as heavy in all directions (") +
                          (system.density() == 0.0  ? "a vacuum"
                           : system.body(0).ellipse ? "circles, fluid included"
                                                    : "spheres, fluid included") +
                          "), so that at zero momentum their weighted centre stays put, and ";
  const std::string cure = system.density() == 0.0 ? "" : ", or give bodies longer in one direction than in others";
  const std::optional<mechanics::Rotations> ends = fixed_attitudes(maneuver);
  if (!ends) return refuse_beyond_centre(system, maneuver, *before, put, cure);
  const std::string stays = put + "the attitudes asked for tell where the root is from there";
  if (maneuver.cost_weights.of_displacement())
    throw InputError("cost.displacement",
                     "found a price of displacement, but " + stays + "; leave it out or an attitude \"free\"" + cure);
  const Vector3d moved = *before - *weighted_centre(system, *ends);
  for (int c = 0; c < 3; ++c) {
    const auto& asked = maneuver.end_position[at(c)];
    if (!asked || std::abs(*asked - maneuver.start.position[c] - moved[c]) <= same_pose * system.size()) continue;
    std::ostringstream text;
    text << "found " << *asked - maneuver.start.position[c] << " m along " << world_axes[at(c)] << ", but " << stays
         << ": " << moved[c] << " m along that axis; leave it or an attitude \"free\"" << cure;
    throw InputError("goal.move", text.str());
  }
}

void refuse_contradictions(const System& system, const Goal& goal, const Maneuver& maneuver) {
  const bool moving = has_momentum(system, maneuver.start);
  if (goal.rest && moving)
    throw InputError(
        "goal.rest",
        "found true, but the start carries momentum, which joint moments cannot change; "
        "set rest = \"joints\" to end with still joints on a whole that drifts on, rest = false to leave them "
        "free, or start with zero total momentum");
  if (!moving) refuse_to_move_centre(system, maneuver);
  if (system.control_count() == 0)
    throw InputError("joint.actuated",
                     "found no actuated joint; a maneuver needs at least one joint with actuated = true");
}

}  // namespace

integrator::State start_state(const System& system, const Start& start) {
  mechanics::Rotations rotation;
  for (const Vector3d& vector : start.rotation) rotation.push_back(lie::exp(vector));
  const VectorXd velocity =
      mechanics::velocity_of_bodies(system, rotation, start.angular_velocity, start.linear_velocity);
  return integrator::state_of_velocity(system, rotation, start.position, velocity);
}

void fit_to_joints(const System& system, mechanics::Rotations& R) {
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) continue;
    const model::Joint& joint = system.joint(body.joint);
    const Vector3d angles = mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint));
    R[at(i)] = R[at(body.parent)] * mechanics::joint_rotation(joint, angles);
  }
}

mechanics::Rotations fitted_to_joints(const System& system, const mechanics::Rotations& seen, double most,
                                      const std::string& key, const std::string& as) {
  mechanics::Rotations rotation = seen;
  fit_to_joints(system, rotation);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const double off = lie::rotation_angle(seen[i].transpose() * rotation[i]);
    if (off <= most) continue;
    const model::Body& body = system.body(static_cast<int>(i));
    std::ostringstream text;
    text << "found " << body.name << " turned by " << off << " rad beside what joint " << system.joint(body.joint).name
         << " allows; allowed: up to " << most << " rad" << as << "; mend this rotation or its parent's";
    throw InputError(key + body.name, text.str());
  }
  return rotation;
}

namespace {

mechanics::Rotations as_measured(const System& system, const Start& start) {
  mechanics::Rotations seen;
  for (const Vector3d& vector : start.rotation) seen.push_back(lie::exp(vector));
  return fitted_to_joints(system, seen, most_misfit, "start.rotation.", ", as measurements have it");
}

}  // namespace

integrator::State start_as_seen(const System& system, const Start& start) {
  const mechanics::Rotations rotation = as_measured(system, start);
  return integrator::state_of_velocity(
      system, rotation, start.position,
      mechanics::velocity_of_bodies(system, rotation, start.angular_velocity, start.linear_velocity));
}

integrator::State start_without_momentum(const System& system, const Start& start) {
  const mechanics::Rotations rotation = as_measured(system, start);
  const VectorXd moving = mechanics::velocity_of_bodies(system, rotation, start.angular_velocity, Vector3d::Zero());
  // twice: of joints that hardly turn the round-off of the whole would be left
  const VectorXd once = mechanics::with_momentum(system, rotation, Vector3d::Zero(), moving, {});
  VectorXd velocity = mechanics::with_momentum(system, rotation, Vector3d::Zero(), once, {});
  if (velocity.lpNorm<Eigen::Infinity>() <= no_rate * moving.lpNorm<Eigen::Infinity>()) velocity.setZero();
  return integrator::state_of_velocity(system, rotation, start.position, velocity);
}

double bodies_momentum(const System& system, const integrator::State& state) {
  const Eigen::Index turns = state.momentum.size() - 3;
  return std::max(system.length_unit() * state.momentum.tail<3>().lpNorm<Eigen::Infinity>(),
                  state.momentum.head(turns).lpNorm<Eigen::Infinity>());
}

bool has_momentum(const System& system, const integrator::State& state) {
  constexpr double round_off = 1e-10;  // of what the bodies have: velocities that cancel are known to some digits
  const double length = system.length_unit();
  // about the root's mass centre, however far from the world's origin that is
  const auto total = mechanics::spatial_momentum(system, state.rotation, Vector3d::Zero(), state.momentum);
  const double largest =
      std::max(length * total.linear.lpNorm<Eigen::Infinity>(), total.angular.lpNorm<Eigen::Infinity>());
  return largest > round_off * bodies_momentum(system, state);
}

bool has_momentum(const System& system, const Start& start) { return has_momentum(system, start_state(system, start)); }

Maneuver make_maneuver(const System& system, const Problem& problem, int steps) {
  if (!problem.goal) throw InputError("goal", "missing; a maneuver needs a [goal] (simulate and check do not)");
  const Goal& goal = *problem.goal;
  Maneuver maneuver;
  maneuver.start = start_state(system, problem.start);
  maneuver.total =
      mechanics::spatial_momentum(system, maneuver.start.rotation, maneuver.start.position, maneuver.start.momentum);
  const AskedAttitudes asked = asked_attitudes(system, goal, maneuver.start.rotation);
  maneuver.end_rotation = asked.rotation;
  maneuver.end_joint = asked.joint;
  for (int c = 0; c < 3; ++c)
    if (goal.move[static_cast<std::size_t>(c)])
      maneuver.end_position[static_cast<std::size_t>(c)] =
          maneuver.start.position[c] + *goal.move[static_cast<std::size_t>(c)];
  maneuver.rest = goal.stills_joints();
  maneuver.periodic = goal.periodic;
  maneuver.free_shape = problem.start.free_shape;
  maneuver.free_duration = problem.duration.free;
  maneuver.time_weight = problem.time_weight;
  maneuver.cost_weights = weights_along(maneuver, problem.cost_weights);
  maneuver.lagrangian = integrator::lagrangian_of(problem.scheme);
  maneuver.duration = problem.duration.value;
  maneuver.steps = steps;
  maneuver.effort = problem.effort;
  maneuver.node_weight = node_weights(problem.cost_rule(), problem.effort, maneuver.time_step(), steps);
  maneuver.spline_points = problem.control == ControlKind::spline ? problem.points : 0;
  for (const model::Joint& joint : system.joints())
    maneuver.may_turn_round.push_back(may_turn_round(joint, problem.limits));
  maneuver.whole_turns = needs_whole_turns(system, problem, maneuver);
  refuse_contradictions(system, goal, maneuver);
  return maneuver;
}

bool ends_in_first_shape(const System& system, const Maneuver& maneuver) {
  if (maneuver.periodic) return true;
  for (int j = 0; j < system.joint_count(); ++j) {
    const std::optional<Matrix3d> last = joint_at_end(system, maneuver, j);
    if (!last) return false;
    const Matrix3d first = mechanics::child_to_parent(maneuver.start.rotation, system.joint(j));
    if (lie::rotation_angle(first.transpose() * *last) > same_pose) return false;
  }
  return true;
}

std::optional<Matrix3d> joint_at_end(const System& system, const Maneuver& maneuver, int j) {
  const auto &parent = maneuver.end_rotation[at(system.joint(j).parent)],
             &child = maneuver.end_rotation[at(system.joint(j).child)];
  if (parent && child) return Matrix3d(parent->transpose() * *child);
  if (system.joint(j).kind == model::JointKind::fixed)
    return mechanics::child_to_parent(maneuver.start.rotation, system.joint(j));
  return maneuver.tells_joint(j) ? maneuver.end_joint[at(j)] : std::nullopt;
}

bool may_turn_round(const model::Joint& joint, const Limits& limits) {
  return joint.stiffness == 0.0 && !limits.angle.contains(joint.name) && !limits.swing.contains(joint.name) &&
         !limits.twist.contains(joint.name);
}

bool asks_to_move(const System& system, const Maneuver& maneuver) {
  const auto& end = maneuver.end_rotation[0];
  if (end && lie::rotation_angle(maneuver.start.rotation[0].transpose() * *end) > same_pose) return true;
  for (int c = 0; c < 3; ++c)
    if (const auto& x = maneuver.end_position[at(c)];
        x && std::abs(*x - maneuver.start.position[c]) > same_pose * system.size())
      return true;
  return false;
}

CostWeights weights_along(const Maneuver& maneuver, CostWeights asked) {
  if (asked.transport == 0.0) return asked;
  Vector3d way;
  for (int c = 0; c < 3; ++c) {
    const auto& end = maneuver.end_position[static_cast<std::size_t>(c)];
    if (!end) return asked;
    way[c] = *end - maneuver.start.position[c];
  }
  if (way.isZero(0.0))
    throw InputError("cost.transport", "found an end where the motion begins; a cost for each metre needs a distance");
  asked.work += asked.transport / way.norm();
  asked.transport = 0.0;
  return asked;
}

VectorXd node_weights(CostRule rule, double effort, double time_step, int steps) {
  VectorXd weights = VectorXd::Constant(steps + 1, effort * time_step);
  if (rule == CostRule::trapezoid) {
    weights[0] *= 0.5;
    weights[steps] *= 0.5;
  }
  return weights;
}

}  // namespace lamprey::maneuver
