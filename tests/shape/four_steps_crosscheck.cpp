// Four steps at once, as derivatives of one function of both shapes, against ShapeKernel's momenta and their rates.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "shape/four_steps.hpp"
#include "shape/pose_at_end.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanics::DiscreteLagrangian;
using mechanics::Moments;
using mechanics::Rotations;
using shape::ForFour;
using shape::FourSteps;
using shape::ShapeKernel;
using shape::ShapeMultipliers;
using shape::ShapeStep;
using shape::ShapeTangent;

// An entry from each of four.
template <typename T, typename Q = T>
ForFour<Q*> pointers(std::vector<T>& all) {
  return {&all[0], &all[1], &all[2], &all[3]};
}

struct FourStepsSetting {
  std::string name;
  int bodies;
  bool all_coordinates;
  bool every_joint = false;
  unsigned seed = 40;
};

model::SwimmerDescription tree_of(Random& random, const FourStepsSetting& setting) {
  if (!setting.every_joint) return random_tree(random, setting.bodies);
  model::SwimmerDescription tree = random_swimmer(random, setting.bodies);
  for (model::BodyDescription& body : tree.bodies) body.coupling_matrix.reset();
  for (model::JointDescription& joint : tree.joints)
    if (joint.kind == model::JointKind::ball) joint.stiffness = joint.damping = 0.0;
  return tree;
}

class FourStepsOf : public ::testing::TestWithParam<FourStepsSetting> {
 protected:
  FourStepsOf()
      : random_(GetParam().seed + static_cast<unsigned>(GetParam().bodies)), system_(tree_of(random_, GetParam())) {
    const int size = maneuver::shape_size(system_);
    coordinates_ = MatrixXd::Identity(size, size);
    if (!GetParam().all_coordinates) {
      const MatrixXd some = MatrixXd::NullaryExpr(size, size / 2, [&] { return random_.uniform(-1.0, 1.0); });
      coordinates_ = some.householderQr().householderQ() * MatrixXd::Identity(size, size / 2);
    }
    for (int l = 0; l < 4; ++l) {
      world_.push_back(random_rotations(random_, system_));
      left_.push_back(seen_from_root(world_.back()));
      turn_to_right_.push_back(random_freedoms(random_, system_, GetParam().every_joint ? 0.2 : 0.4));
      control_.push_back(random_moments(random_, system_, 5.0));
      control_next_.push_back(random_moments(random_, system_, 5.0));
      multiplier_.push_back(random_coordinates());
      multiplier_next_.push_back(random_coordinates());
      turn_.push_back(random_.vector());
      shift_.push_back(random_.vector());
    }
  }

  VectorXd random_coordinates() {
    return VectorXd::NullaryExpr(coordinates_.cols(), [&] { return random_.uniform(-1.0, 1.0); });
  }
  static Rotations seen_from_root(const Rotations& R) {
    Rotations shape = R;
    for (Matrix3d& Q : shape) Q = (R[0].transpose() * Q).eval();
    return shape;
  }

  void agree_with_one_after_the_other(DiscreteLagrangian lagrangian, double time_step, double share);

  // The same steps by either road.
  std::vector<ShapeStep> solved_one_by_one(ShapeKernel& kernel, double time_step) {
    std::vector<ShapeStep> steps(4, ShapeStep(system_));
    for (std::size_t l = 0; l < 4; ++l) EXPECT_TRUE(kernel.solve(time_step, world_[l], right_[l], steps[l]));
    return steps;
  }

  Random random_;
  model::System system_;
  MatrixXd coordinates_;
  std::vector<Rotations> world_, left_, right_;
  std::vector<mechanics::Freedoms> turn_to_right_;
  std::vector<Moments> control_, control_next_;
  std::vector<VectorXd> multiplier_, multiplier_next_;
  std::vector<Vector3d> turn_, shift_;
};

void expect_near(const MatrixXd& one, const MatrixXd& other, const std::string& what) {
  EXPECT_LE((one - other).norm(), tolerance(1e-12) * (1.0 + other.norm())) << what;
}

void FourStepsOf::agree_with_one_after_the_other(DiscreteLagrangian lagrangian, double time_step, double share) {
  ASSERT_TRUE(FourSteps::serves(system_, lagrangian));
  for (std::size_t l = 0; l < 4; ++l) {
    for (Vector3d& turn : turn_to_right_[l]) turn *= share;
    right_.push_back(seen_from_root(turned(system_, left_[l], turn_to_right_[l])));
  }
  ShapeKernel kernel(system_, lagrangian, coordinates_);
  FourSteps four(system_, lagrangian, coordinates_);
  std::vector<ShapeStep> expected = solved_one_by_one(kernel, time_step), steps(4, ShapeStep(system_));
  four.take_shapes(time_step, pointers<Rotations, const Rotations>(left_),
                   pointers<Rotations, const Rotations>(right_));
  ASSERT_TRUE(four.solve(pointers(steps)));
  for (std::size_t l = 0; l < 4; ++l) {
    expect_near(steps[l].root_turn, expected[l].root_turn, "root's turn");
    expect_near(steps[l].root_shift, expected[l].root_shift, "root's shift");
    expect_near(steps[l].minus, expected[l].minus, "E-");
    expect_near(steps[l].plus, expected[l].plus, "E+");
    EXPECT_LE(steps[l].momentum.norm(), tolerance(1e-12) * steps[l].largest_momentum);
    if (!GetParam().every_joint) {
      EXPECT_NEAR(steps[l].largest_momentum, expected[l].largest_momentum, 1e-10 * expected[l].largest_momentum);
    }
    steps[l].interval = expected[l].interval;
  }
  const int f = static_cast<int>(coordinates_.cols());
  std::vector<ShapeTangent> tangents(4), expected_tangents(4);
  std::vector<MatrixXd> hessians(4, MatrixXd::Zero(2 * f + 8, 2 * f + 8)), expected_hessians(4);  // room to spare
  for (MatrixXd& hessian : expected_hessians) hessian.setZero(2 * f + 3, 2 * f + 3);
  std::vector<ShapeMultipliers> multipliers;
  for (std::size_t l = 0; l < 4; ++l) multipliers.push_back({multiplier_[l], multiplier_next_[l], turn_[l], shift_[l]});
  const auto controls = pointers<Moments, const Moments>(control_);
  const auto controls_next = pointers<Moments, const Moments>(control_next_);
  four.tangent(pointers<ShapeStep, const ShapeStep>(steps), controls, controls_next, pointers(tangents));
  four.curvature(pointers<ShapeStep, const ShapeStep>(steps), controls, controls_next,
                 pointers<ShapeMultipliers, const ShapeMultipliers>(multipliers), pointers(hessians));
  for (std::size_t l = 0; l < 4; ++l) {
    kernel.tangent(time_step, control_[l], control_next_[l], expected[l], expected_tangents[l]);
    kernel.curvature(time_step, control_[l], control_next_[l], expected[l], multipliers[l], expected_hessians[l]);
    shape::turn_at_end(expected_tangents[l], expected_hessians[l]);
    expect_near(tangents[l].pose, expected_tangents[l].pose, "pose by shapes");
    expect_near(tangents[l].minus, expected_tangents[l].minus, "E- by shapes");
    expect_near(tangents[l].plus, expected_tangents[l].plus, "E+ by shapes");
    expect_near(hessians[l].topLeftCorner(2 * f + 3, 2 * f + 3), expected_hessians[l], "Hessian");
    hessians[l].topLeftCorner(2 * f + 3, 2 * f + 3).setZero();
    EXPECT_TRUE(hessians[l].isZero(0.0)) << "beyond the Hessian";
  }
}

TEST_P(FourStepsOf, AgreeWithOneStepAfterTheOther) {
  agree_with_one_after_the_other(DiscreteLagrangian::trapezoid, 0.1, 1.0);
}

// From no guess at all it loses motions that turn the root far.
TEST_P(FourStepsOf, AgreeByTheMidpointToo) { agree_with_one_after_the_other(DiscreteLagrangian::midpoint, 0.1, 0.25); }

// Stages of a scheme above order 2.
TEST_P(FourStepsOf, AgreeBackInTimeToo) { agree_with_one_after_the_other(DiscreteLagrangian::midpoint, -0.1, 0.25); }

TEST(FourStepsServe, AllButSpringsOfBallJointsAndCoupledInertiaByTrapezoidAndMidpoint) {
  Random random(3);
  model::SwimmerDescription tree = random_tree(random, 4);
  EXPECT_TRUE(FourSteps::serves(model::System(tree), DiscreteLagrangian::trapezoid));
  EXPECT_TRUE(FourSteps::serves(model::System(tree), DiscreteLagrangian::midpoint));
  EXPECT_FALSE(FourSteps::serves(model::System(tree), DiscreteLagrangian::paper));
  tree.joints[1].stiffness = 1.0;
  EXPECT_FALSE(FourSteps::serves(model::System(tree), DiscreteLagrangian::trapezoid));
  tree.joints[1].stiffness = 0.0;
  tree.joints[0].kind = model::JointKind::hinge;
  tree.joints[0].axis = Vector3d::UnitZ();
  tree.joints[0].stiffness = 2.0;
  tree.joints[0].damping = 0.1;
  EXPECT_TRUE(FourSteps::serves(model::System(tree), DiscreteLagrangian::trapezoid));
  tree.joints[2].kind = model::JointKind::fixed;
  EXPECT_TRUE(FourSteps::serves(model::System(tree), DiscreteLagrangian::trapezoid));
  tree.bodies[1].coupling_matrix = 0.01 * Matrix3d::Identity();
  EXPECT_FALSE(FourSteps::serves(model::System(tree), DiscreteLagrangian::trapezoid));
}

INSTANTIATE_TEST_SUITE_P(Trees, FourStepsOf,
                         ::testing::Values(FourStepsSetting{"two_bodies", 2, true},
                                           FourStepsSetting{"three_bodies", 3, true},
                                           FourStepsSetting{"seven_bodies", 7, true},
                                           FourStepsSetting{"some_coordinates", 5, false},
                                           FourStepsSetting{"every_joint_1", 4, true, true, 1},
                                           FourStepsSetting{"every_joint_2", 6, true, true, 2},
                                           FourStepsSetting{"every_joint_3", 9, true, true, 6},
                                           FourStepsSetting{"every_joint_4", 9, true, true, 4},
                                           FourStepsSetting{"every_joint_5", 8, false, true, 5}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
