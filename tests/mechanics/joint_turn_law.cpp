// Turns of joints from their zero angles: the same rotation comes back, and whole turns add up.
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "mechanics/tree_motion.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using model::JointKind;
using tests::tolerance;

class JointTurn : public testing::TestWithParam<JointKind> {
 protected:
  model::Joint joint() {
    model::Joint joint{};
    joint.kind = GetParam();
    joint.reference_rotation = lie::exp(vector());
    joint.child_axis = vector().normalized();
    joint.parent_axis = (joint.reference_rotation * joint.child_axis).cross(vector()).normalized();
    return joint;
  }
  Vector3d vector() { return {number_(random_), number_(random_), number_(random_)}; }
  // Turns that the joint can make, of this size.
  Vector3d turn(double size) {
    const Vector3d direction = vector().normalized();
    switch (GetParam()) {
      case JointKind::hinge:
        return {size, 0.0, 0.0};
      case JointKind::universal:
        return {size, 0.8 * size, 0.0};
      case JointKind::ball:
        return size * direction;
      case JointKind::fixed:
        break;
    }
    return Vector3d::Zero();
  }

 private:
  std::mt19937_64 random_{7};
  std::normal_distribution<double> number_;
};

TEST_P(JointTurn, comes_back_from_its_rotation) {
  for (int sample = 0; sample < 50; ++sample) {
    const model::Joint of = joint();
    const Vector3d turned = turn(3.0 * sample / 50.0);
    const Vector3d found = mechanics::turn_from_zero(of, mechanics::rotation_at_turn(of, turned), Vector3d::Zero());
    EXPECT_LE((found - turned).norm(), tolerance(1e-13));
  }
}

TEST_P(JointTurn, adds_up_over_whole_turns) {
  for (double step : {0.02, 0.3, -0.3}) {  // the last ones pass whole turns at a distance
    const model::Joint of = joint();
    const Vector3d direction = turn(1.0);
    Vector3d found = Vector3d::Zero();
    for (int k = 0; std::abs(k * step) < 20.0; ++k) {
      found = mechanics::turn_from_zero(of, mechanics::rotation_at_turn(of, k * step * direction), found);
      EXPECT_LE((found - k * step * direction).norm(), tolerance(1e-12)) << k * step;
    }
  }
}

TEST_P(JointTurn, keeps_its_axis_where_a_whole_turn_hides_it) {
  if (GetParam() == JointKind::universal) return;  // whose second angle is not a whole turn
  const model::Joint of = joint();
  const Vector3d whole = 2.0 * std::numbers::pi * turn(1.0);
  const Vector3d found = mechanics::turn_from_zero(of, mechanics::rotation_at_turn(of, whole), 0.95 * whole);
  EXPECT_LE((found - whole).norm(), tolerance(1e-12));
}

std::string name_of(const testing::TestParamInfo<JointKind>& kind) {
  const char* names[] = {"ball", "universal", "hinge", "fixed"};
  return names[static_cast<std::size_t>(kind.param)];
}

INSTANTIATE_TEST_SUITE_P(Kinds, JointTurn,
                         testing::Values(JointKind::ball, JointKind::universal, JointKind::hinge, JointKind::fixed),
                         name_of);

}  // namespace
}  // namespace lamprey
