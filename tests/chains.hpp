// Swimmers shared by the tests: the paper's chain and random trees.
#pragma once

#include <random>
#include <string>

#include "lie/so3.hpp"
#include "mechanics/discrete_lagrangian.hpp"
#include "model/system.hpp"

namespace lamprey::tests {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Density for which the paper's table of inertia holds, kg/m³.
inline constexpr double paper_density = 0.00994718394324346;

/// The paper's three bodies; printed four-digit M and J, as a physical chain or with the offsets as printed.
inline model::SwimmerDescription paper_chain(bool physical = true) {
  const double side = physical ? -5.5 : 5.5;
  model::SwimmerDescription chain;
  chain.density = paper_density;
  const auto body = [](const std::string& name, const Vector3d& axes, const Vector3d& M, const Vector3d& J) {
    model::BodyDescription described;
    described.name = name;
    described.semi_axes = axes;
    described.mass_matrix = M.asDiagonal();
    described.inertia_matrix = J.asDiagonal();
    return described;
  };
  const Vector3d M1(0.2664, 0.6551, 0.3677), J1(0.1961, 1.7889, 2.9210);
  chain.bodies = {body("middle", {8, 1.5, 2}, {1.0659, 2.1696, 1.6641}, {1.3480, 20.15, 25.3276}),
                  body("front", {5, 0.8, 1.5}, M1, J1), body("back", {5, 0.8, 1.5}, M1, J1)};
  const auto joint = [](const std::string& child, double parent_x, double child_x) {
    model::JointDescription described;
    described.name = child;
    described.parent = "middle";
    described.child = child;
    described.parent_offset = Vector3d(parent_x, 0, 0);
    described.child_offset = Vector3d(child_x, 0, 0);
    return described;
  };
  chain.joints = {joint("front", 8.8, side), joint("back", -8.8, -side)};
  return chain;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double normal() { return normal_(engine_); }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  Vector3d vector(double size = 1.0) { return size * Vector3d(normal(), normal(), normal()); }
  Matrix3d rotation() { return lie::exp(vector(1.5)); }
  Matrix3d positive_definite() {
    Matrix3d a;
    for (int c = 0; c < 3; ++c) a.col(c) = vector();
    return a * a.transpose() / 3.0 + 0.4 * Matrix3d::Identity();
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// A tree of bodies with full random matrices; parents are drawn at random, so chains and stars both occur.
inline model::SwimmerDescription random_tree(Random& random, int bodies) {
  model::SwimmerDescription tree;
  tree.density = 1.0;
  for (int i = 0; i < bodies; ++i) {
    model::BodyDescription body;
    body.name = "body" + std::to_string(i);
    body.semi_axes = Vector3d(random.uniform(0.5, 2.0), random.uniform(0.5, 2.0), random.uniform(0.5, 2.0));
    body.mass_matrix = random.positive_definite();
    body.inertia_matrix = 2.0 * random.positive_definite();
    tree.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = body.name;
    joint.parent = "body" + std::to_string(random.integer(0, i - 1));
    joint.child = body.name;
    joint.parent_offset = random.vector();
    joint.child_offset = random.vector();
    tree.joints.push_back(joint);
  }
  return tree;
}

/// A tree with every kind of joint, springs, dampers, partial actuation and coupled inertia, drawn at random.
inline model::SwimmerDescription random_swimmer(Random& random, int bodies) {
  model::SwimmerDescription tree = random_tree(random, bodies);
  for (model::BodyDescription& body : tree.bodies)
    if (random.integer(0, 1) == 1) {
      Matrix3d C;
      for (int c = 0; c < 3; ++c) C.col(c) = random.vector(0.08);
      body.coupling_matrix = C;
    }
  for (model::JointDescription& joint : tree.joints) {
    joint.kind = static_cast<model::JointKind>(random.integer(0, 3));
    joint.reference_rotation = random.vector();
    if (joint.kind == model::JointKind::hinge) joint.axis = random.vector();
    if (joint.kind == model::JointKind::universal) {
      const Vector3d second = random.vector();
      joint.axes = {(lie::exp(joint.reference_rotation) * second).cross(random.vector()), second};
    }
    if (joint.kind == model::JointKind::fixed) continue;
    if (random.integer(0, 2) == 0) joint.stiffness = random.uniform(0.5, 5.0);
    if (random.integer(0, 2) == 0) joint.damping = random.uniform(0.1, 1.0);
    joint.actuated = random.integer(0, 3) > 0;
  }
  return tree;
}

/// The rotations turned along freedoms: a body that turns on its own by exp, others about their joints' axes; bodies
/// that are led follow their parents.
inline mechanics::Rotations turned(const model::System& system, const mechanics::Rotations& R,
                                   const mechanics::Freedoms& turn) {
  mechanics::Rotations result = R;
  for (int i : system.root_to_leaves()) {
    const auto n = static_cast<std::size_t>(i);
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      result[n] = R[n] * lie::exp(turn[n]);
      continue;
    }
    const model::Joint& joint = system.joint(body.joint);
    const auto p = static_cast<std::size_t>(body.parent);
    const bool universal = joint.kind == model::JointKind::universal;
    const Vector3d before = universal ? Vector3d(turn[n][0] * joint.parent_axis) : Vector3d(Vector3d::Zero());
    const Vector3d after = turn[n][universal ? 1 : 0] * joint.child_axis;
    result[n] = result[p] * lie::exp(before) * R[p].transpose() * R[n] * lie::exp(after);
  }
  return result;
}

/// Inverse of turned.
inline mechanics::Freedoms turns_between(const model::System& system, const mechanics::Rotations& from,
                                         const mechanics::Rotations& to) {
  mechanics::Freedoms turn(from.size(), Vector3d::Zero());
  for (int i = 0; i < system.body_count(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      turn[n] = lie::log(from[n].transpose() * to[n]);
      continue;
    }
    const model::Joint& joint = system.joint(body.joint);
    const auto p = static_cast<std::size_t>(body.parent);
    turn[n] = mechanics::joint_angles(joint, to[p].transpose() * to[n]) -
              mechanics::joint_angles(joint, from[p].transpose() * from[n]);
    for (double& angle : turn[n]) angle = std::remainder(angle, 2.0 * M_PI);
  }
  return turn;
}

/// Entries beyond a body's freedoms are zero.
inline mechanics::Freedoms random_freedoms(Random& random, const model::System& system, double size) {
  mechanics::Freedoms freedoms(static_cast<std::size_t>(system.body_count()), Vector3d::Zero());
  for (int i = 0; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) freedoms[static_cast<std::size_t>(i)][f] = size * random.normal();
  return freedoms;
}

/// Rotations that the joints allow.
inline mechanics::Rotations random_rotations(Random& random, const model::System& system) {
  mechanics::Rotations zero(static_cast<std::size_t>(system.body_count()), Matrix3d::Identity());
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent >= 0)
      zero[static_cast<std::size_t>(i)] =
          zero[static_cast<std::size_t>(body.parent)] * system.joint(body.joint).reference_rotation;
  }
  return turned(system, zero, random_freedoms(random, system, 0.5));
}

/// Moments that the joints can exert, N m.
inline mechanics::Moments random_moments(Random& random, const model::System& system, double size) {
  mechanics::Moments u;
  for (const model::Joint& joint : system.joints()) {
    Eigen::VectorXd along(joint.actuation.cols());
    for (double& entry : along) entry = size * random.normal();
    u.emplace_back(joint.actuation * along);
  }
  return u;
}

/// A step of random rotations of about `turn` rad, updated.
inline mechanics::Interval random_interval(Random& random, const model::System& system, double turn) {
  mechanics::Interval step(system.body_count());
  step.rotation = random_rotations(random, system);
  const mechanics::Freedoms turns = random_freedoms(random, system, turn);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    step.cayley[i] = 0.5 * turns[i];
    step.joint_turn[i] = turns[i];
  }
  step.displacement = random.vector(turn);
  mechanics::update_interval(system, step);
  return step;
}

}  // namespace lamprey::tests
