#include "file/problem_checks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "file/goal_checks.hpp"
#include "file/problem_limits.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"
#include "model/system.hpp"

namespace lamprey::file {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using maneuver::Problem;
using model::JointDescription;
using model::SwimmerDescription;

constexpr double velocity_tolerance = 1e-9;  // relative
constexpr double symmetry_tolerance = 1e-9;  // relative

std::size_t body_named(const BodyIndex& index, const std::string& name, const std::string& key) {
  const auto found = index.find(name);
  if (found != index.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& entry : index) names.push_back(entry.first);
  refuse(key, document::in_quotes(name) + ", which names no body", "the name of a [[body]]",
         fmt::format("the nearest is {}", document::in_quotes(nearest(name, names))));
}

constexpr std::size_t nobody = static_cast<std::size_t>(-1);

struct Parent {
  std::size_t body = nobody;
  std::size_t joint = nobody;
};

std::vector<Parent> find_parents(const SwimmerDescription& swimmer, const BodyIndex& index) {
  std::vector<Parent> parents(swimmer.bodies.size());
  for (std::size_t j = 0; j < swimmer.joints.size(); ++j) {
    const JointDescription& joint = swimmer.joints[j];
    const std::size_t parent = body_named(index, joint.parent, joint_key(j, "parent"));
    const std::size_t child = body_named(index, joint.child, joint_key(j, "child"));
    const std::string child_key = joint_key(j, "child");
    if (parent == child)
      refuse(child_key, document::in_quotes(joint.child) + ", the joint's own parent", "another body than the parent",
             "name the other body");
    if (child == 0)
      refuse(child_key, document::in_quotes(joint.child) + ", the root", "any body but the first",
             "exchange parent and child, or list another body first");
    if (parents[child].joint != nobody)
      refuse(child_key,
             fmt::format("{} with a second parent, {}", document::in_quotes(joint.child),
                         document::in_quotes(joint.parent)),
             "one parent for each body",
             fmt::format("remove this joint or the one with {}",
                         document::in_quotes(swimmer.joints[parents[child].joint].parent)));
    parents[child] = {parent, j};
  }
  return parents;
}

void check_names_of_joints(const SwimmerDescription& swimmer) {
  std::set<std::string> names;
  for (std::size_t j = 0; j < swimmer.joints.size(); ++j) {
    const std::string& name = swimmer.joints[j].name;
    if (!names.insert(name).second)
      refuse(joint_key(j, "name"), document::in_quotes(name) + " a second time",
             "names that differ (default: the child's name)", "give one of the two joints another name");
  }
}

// Walks from every body towards the root; each body is visited at most twice in all.
void check_reach(const SwimmerDescription& swimmer, const std::vector<Parent>& parents) {
  enum class Mark { unknown, walking, reaches_root };
  std::vector<Mark> marks(parents.size(), Mark::unknown);
  marks[0] = Mark::reaches_root;
  for (std::size_t start = 0; start < parents.size(); ++start) {
    std::vector<std::size_t> walked;
    std::size_t i = start;
    while (marks[i] == Mark::unknown) {
      marks[i] = Mark::walking;
      walked.push_back(i);
      if (parents[i].body == nobody)
        refuse(body_key(i, "name"),
               fmt::format("{}, which no joint leads to from the root", document::in_quotes(swimmer.bodies[i].name)),
               "one tree with the first body as root",
               fmt::format("add a [[joint]] with child = {}", document::in_quotes(swimmer.bodies[i].name)));
      i = parents[i].body;
    }
    if (marks[i] == Mark::walking)
      refuse(joint_key(parents[i].joint, "child"),
             fmt::format("a cycle of joints through {}", document::in_quotes(swimmer.bodies[i].name)),
             "a tree with the first body as root", "remove one of the cycle's joints and join it to the root");
    for (std::size_t body : walked) marks[body] = Mark::reaches_root;
  }
}

std::string shown_matrix(const Matrix3d& m) {
  return fmt::format("[{}, {}, {}]", shown(Vector3d(m.row(0))), shown(Vector3d(m.row(1))), shown(Vector3d(m.row(2))));
}

void check_matrix(const std::optional<Matrix3d>& matrix, const std::string& key) {
  if (!matrix) return;
  const double asymmetry = (*matrix - matrix->transpose()).cwiseAbs().maxCoeff();
  const bool symmetric = asymmetry <= symmetry_tolerance * matrix->cwiseAbs().maxCoeff();
  if (!symmetric || !model::positive_definite(*matrix))
    refuse(
        key, shown_matrix(*matrix), "a symmetric positive definite matrix",
        symmetric ? "all its eigenvalues must be > 0: mend its entries" : "make each entry equal to its mirror image");
}

// [J Cᵀ; C M] with the body's own or resolved J and M, as model::System judges it.
void check_coupling(const SwimmerDescription& swimmer, std::size_t i) {
  const model::BodyDescription& body = swimmer.bodies[i];
  if (!body.coupling_matrix) return;
  try {
    model::System(SwimmerDescription{swimmer.density, {body}, {}});
  } catch (const model::InputError&) {
    refuse(body_key(i, "coupling_matrix"), shown_matrix(*body.coupling_matrix),
           "a matrix C (kg m) with which the whole inertia [J Cᵀ; C M] is positive definite",
           "make its entries smaller, or M and J larger");
  }
}

// Of any mass distribution the largest principal moment is at most the sum of the others: ½ tr(J) I − J ⪰ 0.
// The margin of a thousandth forgives rounded digits.
void check_triangle(const Matrix3d& inertia, const std::string& key) {
  constexpr double margin = 1e-3;
  if (!model::positive_definite((0.5 + 0.25 * margin) * inertia.trace() * Matrix3d::Identity() - inertia))
    refuse(key, shown_matrix(inertia),
           "a largest principal moment up to the sum of the other two (kg m²), as of every solid body",
           "mend an entry; added fluid belongs into inertia_matrix");
}

bool independent(const std::vector<Vector3d>& axes) {
  std::vector<Vector3d> basis;
  for (const Vector3d& axis : axes) {
    const double length = axis.stableNorm();
    if (!(length > 0.0) || !std::isfinite(length)) return false;
    Vector3d rest = axis / length;
    for (const Vector3d& direction : basis) rest -= direction * direction.dot(rest);
    if (rest.norm() < 1e-9) return false;
    basis.push_back(rest.normalized());
  }
  return basis.size() <= 3;
}

std::string shown_axes(const std::vector<Vector3d>& axes) {
  std::string text;
  for (std::size_t a = 0; a < std::min<std::size_t>(axes.size(), 5); ++a) text += (a > 0 ? ", " : "") + shown(axes[a]);
  return fmt::format("[{}{}]", text, axes.size() > 5 ? ", …" : "");
}

// Beyond these, inertia about a joint leaves no digits to the bodies'.
void check_offsets(const JointDescription& joint, std::size_t j, double size) {
  constexpr double farthest = 1e6;  // of the largest semi-axis
  for (const auto& [name, offset] :
       {std::pair("parent_offset", &joint.parent_offset), std::pair("child_offset", &joint.child_offset)})
    if (!(offset->norm() <= farthest * size))
      refuse(joint_key(j, name), fmt::format("a joint {:.3g} m from the body's centre", offset->norm()),
             fmt::format("at most {:.3g} m, a million times the largest semi-axis", farthest * size),
             "mind the unit, m");
}

void check_control_axes(const JointDescription& joint, std::size_t j) {
  if (!joint.control_axes) return;
  const std::string key = joint_key(j, "control_axes");
  if (!joint.actuated)
    refuse(key, "axes on a joint with actuated = false", "only on actuated joints", "remove one of the two keys");
  if (!independent(*joint.control_axes))
    refuse(key, shown_axes(*joint.control_axes), "one to three non-zero, linearly independent vectors",
           "remove the axis that repeats others");
}

void check_joint_axes(const JointDescription& joint, std::size_t j) {
  if (joint.kind == JointKind::hinge) {
    const std::string key = joint_key(j, "axis");
    if (!joint.axis) refuse(key, "nothing on a hinge", "three numbers: the free axis, child's frame", "add this key");
    if (!independent({*joint.axis}))
      refuse(key, shown(*joint.axis), "a vector that is not zero", "as in [0.0, 0.0, 1.0]");
  }
  if (joint.kind != JointKind::universal) return;
  const std::string key = joint_key(j, "axes");
  if (!joint.axes)
    refuse(key, "nothing on a universal joint", "two vectors: first in the parent's frame, second in the child's",
           "add this key");
  for (const Vector3d& axis : *joint.axes)
    if (!independent({axis}))
      refuse(key, shown(axis), "vectors that are not zero", "as in [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]");
  const double cosine =
      (*joint.axes)[0].stableNormalized().dot(lie::exp(joint.reference_rotation) * (*joint.axes)[1].stableNormalized());
  if (std::abs(cosine) > angle_tolerance)
    refuse(key, fmt::format("axes at {} rad to each other at zero angle", std::acos(std::clamp(cosine, -1.0, 1.0))),
           "axes orthogonal at zero angle (second turned by reference_rotation)", "turn one of them");
}

}  // namespace

BodyIndex index_bodies(const SwimmerDescription& swimmer) {
  BodyIndex index;
  for (std::size_t i = 0; i < swimmer.bodies.size(); ++i) {
    const std::string& name = swimmer.bodies[i].name;
    if (!index.emplace(name, i).second)
      refuse(body_key(i, "name"), document::in_quotes(name) + " a second time", "names that differ",
             "rename one of the two bodies");
  }
  return index;
}

double misfit(const JointDescription& joint, const Matrix3d& child_to_parent) {
  const Matrix3d from_zero = lie::exp(joint.reference_rotation).transpose() * child_to_parent;
  switch (joint.kind) {
    case JointKind::ball:
      return 0.0;
    case JointKind::fixed:
      return lie::rotation_angle(from_zero);
    case JointKind::hinge: {
      const Vector3d axis = joint.axis->stableNormalized();
      return 2.0 * std::asin(std::min(0.5 * (from_zero * axis - axis).norm(), 1.0));
    }
    case JointKind::universal:
      return std::asin(std::min(
          std::abs((*joint.axes)[0].stableNormalized().dot(child_to_parent * (*joint.axes)[1].stableNormalized())),
          1.0));
  }
  return 0.0;
}

namespace {

Matrix3d start_rotation(const Problem& problem, const BodyIndex& index, const std::string& body) {
  return lie::exp(problem.start.rotation[index.at(body)]);
}

// The child's angular velocity (child's frame) nearest to the stated one that its joint lets it have.
Vector3d allowed_velocity(const JointDescription& joint, const Matrix3d& child_to_parent, const Vector3d& parent,
                          const Vector3d& child) {
  const Vector3d carried = child_to_parent.transpose() * parent;
  if (joint.kind == JointKind::fixed) return carried;
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();
  if (joint.kind == JointKind::hinge) {
    axes.col(0) = joint.axis->stableNormalized();
  } else {
    axes.col(0) = child_to_parent.transpose() * (*joint.axes)[0].stableNormalized();
    axes.col(1) = (*joint.axes)[1].stableNormalized();
  }
  return carried + axes * lie::coordinates_along(axes, child - carried);
}

std::string allowed_turns(const JointDescription& joint) {
  switch (joint.kind) {
    case JointKind::hinge:
      return fmt::format(" plus any turn about its axis {} (child's frame)", shown(*joint.axis));
    case JointKind::universal:
      return fmt::format(" plus any turns about its axes {} (parent's frame) and {} (child's frame)",
                         shown((*joint.axes)[0]), shown((*joint.axes)[1]));
    default:
      return "";
  }
}

void check_start_velocities(const Problem& problem, const BodyIndex& index) {
  for (const JointDescription& joint : problem.swimmer.joints) {
    if (joint.kind == JointKind::ball) continue;
    const Matrix3d Q =
        start_rotation(problem, index, joint.parent).transpose() * start_rotation(problem, index, joint.child);
    const Vector3d& parent = problem.start.angular_velocity[index.at(joint.parent)];
    const Vector3d& child = problem.start.angular_velocity[index.at(joint.child)];
    const Vector3d nearest_one = allowed_velocity(joint, Q, parent, child);
    const double off = (child - nearest_one).norm();
    if (off > velocity_tolerance * std::max(parent.norm(), child.norm()))
      refuse(document::key_path("start.angular_velocity", joint.child),
             fmt::format("{}, {} rad/s outside what the {} joint {} allows", shown(child), off, word(joint.kind),
                         document::in_quotes(joint.name)),
             fmt::format("the angular velocity of {} seen from this body{}", document::in_quotes(joint.parent),
                         allowed_turns(joint)),
             fmt::format("remove this key to move with the parent, or write the nearest one, {}", shown(nearest_one)));
  }
}

}  // namespace

std::string joint_key(std::size_t j, std::string_view name) {
  return document::key_path(fmt::format("joint[{}]", j), name);
}
std::string body_key(std::size_t i, std::string_view name) {
  return document::key_path(fmt::format("body[{}]", i), name);
}

void check_tree(const SwimmerDescription& swimmer) {
  const std::vector<Parent> parents = find_parents(swimmer, index_bodies(swimmer));
  check_reach(swimmer, parents);
  check_names_of_joints(swimmer);
}

namespace {

std::string semi_axes_shown(const model::BodyDescription& body) {
  return body.ellipse ? fmt::format("[{}, {}]", body.semi_axes[0], body.semi_axes[1]) : shown(body.semi_axes);
}

}  // namespace

void check_bodies(const SwimmerDescription& swimmer) {
  for (std::size_t i = 0; i < swimmer.bodies.size(); ++i) {
    const model::BodyDescription& body = swimmer.bodies[i];
    const double volume = body.ellipse ? std::numbers::pi * body.semi_axes.head<2>().prod()
                                       : 4.0 / 3.0 * std::numbers::pi * body.semi_axes.prod();
    const double mass = body.mass.value_or(swimmer.density * volume);
    const double inertia = mass * body.semi_axes.squaredNorm();
    if (swimmer.density == 0.0 && !body.mass)
      refuse(body_key(i, "mass"), "nothing in a vacuum (fluid.density = 0)", "a number > 0 (kg)",
             "add this key: nothing buoys the body");
    if (!std::isnormal(volume) || !std::isnormal(mass) || !std::isnormal(inertia))
      refuse(body_key(i, "semi_axes"), fmt::format("{}, volume {} m³, mass {} kg", semi_axes_shown(body), volume, mass),
             "sizes whose volume, mass and inertia are ordinary numbers", "check the units: metres, kg/m³");
    if (body.semi_axes.minCoeff() < 1e-50 * body.semi_axes.maxCoeff())
      refuse(body_key(i, "semi_axes"), semi_axes_shown(body), "lengths that differ by a factor of 1e50 at most",
             "check the units: metres");
    check_matrix(body.body_inertia, body_key(i, "body_inertia"));
    check_matrix(body.mass_matrix, body_key(i, "mass_matrix"));
    check_matrix(body.inertia_matrix, body_key(i, "inertia_matrix"));
    check_coupling(swimmer, i);
    if (body.body_inertia) check_triangle(*body.body_inertia, body_key(i, "body_inertia"));
  }
}

void check_joints(const SwimmerDescription& swimmer) {
  double size = 0.0;  // m, largest semi-axis
  for (const model::BodyDescription& body : swimmer.bodies) size = std::max(size, body.semi_axes.maxCoeff());
  for (std::size_t j = 0; j < swimmer.joints.size(); ++j) {
    check_joint_axes(swimmer.joints[j], j);
    check_control_axes(swimmer.joints[j], j);
    check_offsets(swimmer.joints[j], j, size);
  }
}

void check_start(const Problem& problem) {
  const BodyIndex index = index_bodies(problem.swimmer);
  for (const JointDescription& joint : problem.swimmer.joints) {
    const Matrix3d shape =
        start_rotation(problem, index, joint.parent).transpose() * start_rotation(problem, index, joint.child);
    const double off = misfit(joint, shape);
    if (off > angle_tolerance)
      refuse(document::key_path("start.rotation", joint.child),
             fmt::format("start rotations that are {:.4g} rad outside what the {} joint {} allows", off,
                         word(joint.kind), document::in_quotes(joint.name)),
             "start rotations that fit the joints",
             fmt::format("turn this body or its parent, or set the joint's reference_rotation{}",
                         joint.kind == JointKind::hinge || joint.kind == JointKind::universal
                             ? "; " + document::key_path("start.angle", joint.name) + " in its place always fits"
                             : ""));
  }
  check_start_velocities(problem, index);
  if (problem.start.free_shape && !(problem.goal && problem.goal->periodic))
    refuse("start.free_shape", "true without a periodic goal", "only with goal.periodic = true",
           "remove it or add periodic = true to [goal]");
}

void check_costs(const Problem& problem) {
  const maneuver::CostWeights& weights = problem.cost_weights;
  if (!problem.goal) return;
  const std::optional<double> distance = problem.goal->distance();
  if (weights.transport > 0.0 && distance && *distance == 0.0)
    refuse("cost.transport", "a cost for each metre with a goal.move of 0 m", "with a distance that is not zero",
           "move somewhere, leave a part of goal.move \"free\", or use cost.work");
  for (std::size_t c = 0; c < 3; ++c)
    if (weights.displacement[static_cast<Eigen::Index>(c)] != 0.0 && problem.goal->move[c])
      refuse("cost.displacement", fmt::format("a worth of metres along {}, which goal.move fixes", "xyz"[c]),
             "worth along axes where goal.move is \"free\"",
             fmt::format("write \"free\" for {} in goal.move, or 0 here", "xyz"[c]));
  if (weights.smoothness > 0.0 && !problem.goal->stills_joints() && !problem.goal->periodic)
    refuse("cost.smoothness", fmt::format("{} with an end that is neither at rest nor periodic", weights.smoothness),
           "with goal.rest = true or \"joints\" or goal.periodic = true",
           "set one of them (with a start that carries momentum \"joints\"), or remove this key: a free end has no "
           "last moment");
}

void check_transcription(const Problem& problem) {
  const bool high_order = problem.scheme == Scheme::order4 || problem.scheme == Scheme::order6;
  if (high_order && problem.rule)
    refuse("cost.rule",
           fmt::format("{} with scheme {}", document::in_quotes(word(*problem.rule)),
                       document::in_quotes(word(problem.scheme))),
           "no rule above order 2: the scheme's own quadrature is used", "remove this key");
  const bool spline = problem.control == ControlKind::spline;
  if (spline && problem.points == 0)
    refuse("control.points", "nothing with kind = \"spline\"", "a whole number from 2 to steps + 1",
           "add this key, as in points = 21");
  if (!spline && problem.points != 0)
    refuse("control.points", fmt::format("{} with kind = \"steps\"", problem.points), "only with kind = \"spline\"",
           "remove it or set kind = \"spline\"");
  if (spline && problem.points > problem.steps + 1)
    refuse("control.points", fmt::format("{} with {} steps", problem.points, problem.steps),
           fmt::format("a whole number from 2 to steps + 1 = {}", problem.steps + 1), "use fewer points or more steps");
  if (problem.search.method == SearchMethod::shooting && !spline)
    refuse("search.method", "\"shooting\" with control.kind = \"steps\"",
           "\"simultaneous\", or \"shooting\" with kind = \"spline\"",
           "set control.kind = \"spline\" with points, or use \"simultaneous\"");
}

void check_statement(const Problem& problem) {
  check_start(problem);
  check_goal(problem);
  check_limits(problem);
  check_waypoints(problem);
  check_transcription(problem);
  check_costs(problem);
}

}  // namespace lamprey::file
