// Moments that follow joint by joint from what they do, against the whole matrix of their virtual work.
#include "shape/moment_basis.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using shape::MomentBasis;

MatrixXd all_coordinates(const model::System& system) {
  const int size = maneuver::shape_size(system);
  return MatrixXd::Identity(size, size);
}

// A tree of ball joints, listed in another order than its bodies, whose moments act along axes of their own.
model::System tree_with_axes(Random& random, int bodies) {
  model::SwimmerDescription tree = random_tree(random, bodies);
  std::reverse(tree.joints.begin(), tree.joints.end());
  for (model::JointDescription& joint : tree.joints)
    joint.control_axes = {random.vector(), random.vector(), random.vector()};
  return model::System(tree);
}

TEST(MomentBasis, joint_by_joint_is_the_inverse_of_the_virtual_work) {
  for (int bodies : {2, 3, 5, 7}) {
    Random random(60U + static_cast<unsigned>(bodies));
    const model::System system = tree_with_axes(random, bodies);
    const mechanics::Rotations R = random_rotations(random, system);
    MomentBasis moments(system, all_coordinates(system), R);
    ASSERT_TRUE(moments.joint_by_joint());
    MatrixXd work(moments.size(), moments.size());
    moments.virtual_work(R, work);
    const VectorXd expected = VectorXd::NullaryExpr(moments.size(), [&] { return random.uniform(-1.0, 1.0); });
    VectorXd found = work * expected;
    moments.solve(R, found);
    EXPECT_LE((found - expected).norm(), tolerance(1e-14) * bodies * expected.norm()) << bodies;
    found = work.transpose() * expected;
    moments.solve_transposed(R, found);
    EXPECT_LE((found - expected).norm(), tolerance(1e-14) * bodies * expected.norm()) << bodies;
  }
}

TEST(MomentBasis, other_joints_coordinates_and_actuations_ask_for_the_matrix) {
  Random random(5);
  const auto by_joints = [&](const model::System& system, const MatrixXd& coordinates) {
    return MomentBasis(system, coordinates, random_rotations(random, system)).joint_by_joint();
  };
  model::SwimmerDescription tree = random_tree(random, 3);
  const model::System free(tree);
  EXPECT_TRUE(by_joints(free, all_coordinates(free)));
  EXPECT_FALSE(by_joints(free, all_coordinates(free).rowwise().reverse()));
  tree.joints[0].control_axes = {Vector3d::UnitX(), Vector3d::UnitY()};
  const model::System partly(tree);
  EXPECT_FALSE(by_joints(partly, all_coordinates(partly)));
  tree.joints[0].control_axes.reset();
  tree.joints[1].kind = model::JointKind::fixed;
  const model::System led(tree);
  EXPECT_FALSE(by_joints(led, all_coordinates(led)));
}

}  // namespace
}  // namespace lamprey::tests
