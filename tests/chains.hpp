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
  const auto body = [](const std::string& name, Vector3d axes, Vector3d M, Vector3d J) {
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

/// A step of random rotations of about `turn` rad, updated.
inline mechanics::Interval random_interval(Random& random, const model::System& system, double turn) {
  mechanics::Interval step(system.body_count());
  for (auto& R : step.rotation) R = random.rotation();
  for (auto& zeta : step.cayley) zeta = random.vector(0.5 * turn);
  step.displacement = random.vector(turn);
  mechanics::update_interval(system, step);
  return step;
}

}  // namespace lamprey::tests
