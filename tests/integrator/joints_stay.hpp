// Whether bodies that their joints lead stay on their joints over a long march.
#pragma once

#include <algorithm>

#include "integrator/marching.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {

/// Two of each kind of joint that leads its child, and ball joints between.
inline model::SwimmerDescription led_swimmer(Random& random) {
  model::SwimmerDescription swimmer = random_tree(random, 9);
  const model::JointKind kinds[] = {model::JointKind::hinge, model::JointKind::universal, model::JointKind::fixed,
                                    model::JointKind::ball};
  for (std::size_t j = 0; j < swimmer.joints.size(); ++j) {
    model::JointDescription& joint = swimmer.joints[j];
    joint.kind = kinds[j % 4];
    joint.reference_rotation = random.vector();
    if (joint.kind == model::JointKind::hinge) joint.axis = random.vector();
    if (joint.kind == model::JointKind::universal) {
      const Vector3d second = random.vector();
      joint.axes = {(lie::exp(joint.reference_rotation) * second).cross(random.vector()), second};
    }
  }
  return swimmer;
}

/// How far a body is off its joint.
inline double joint_error(const model::Joint& joint, const Matrix3d& R_parent, const Matrix3d& R_child) {
  switch (joint.kind) {
    case model::JointKind::ball:
      return 0.0;
    case model::JointKind::universal:
      return std::abs((R_parent * joint.parent_axis).dot(R_child * joint.child_axis));
    case model::JointKind::hinge:
      return (R_parent * joint.parent_axis - R_child * joint.child_axis).norm();
    case model::JointKind::fixed:
      break;
  }
  return (R_parent * joint.reference_rotation - R_child).norm();
}

/// Marches a tree with joints of every kind for so many stages.
inline void expect_joints_stay(integrator::Scheme scheme, int stages) {
  Random random(91);
  const Moving swimmer = moving(random, led_swimmer(random));
  const int steps = stages / integrator::composition(scheme).stages();
  double largest[4] = {}, turned_away = 0.0;
  marched(swimmer.system, scheme, 5e-3, steps, swimmer.start, {}, [&](int, const integrator::State& state) {
    for (const model::Joint& joint : swimmer.system.joints()) {
      const Matrix3d& R_parent = state.rotation[model::at(joint.parent)];
      const Matrix3d& R_child = state.rotation[model::at(joint.child)];
      double& error = largest[static_cast<int>(joint.kind)];
      error = std::max({error, joint_error(joint, R_parent, R_child),
                        (R_child.transpose() * R_child - Matrix3d::Identity()).lpNorm<Eigen::Infinity>()});
      if (joint.kind == model::JointKind::hinge || joint.kind == model::JointKind::universal)
        turned_away = std::max(turned_away, (R_child - R_parent * joint.reference_rotation).norm());
    }
  });
  for (double error : largest) {
    EXPECT_LE(error, tolerance(1e-12));
    EXPECT_GT(error, 0.0);
  }
  EXPECT_GT(turned_away, 1.0) << "the joints hardly turned";
}

}  // namespace lamprey::tests
