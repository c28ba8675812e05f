#include <gtest/gtest.h>

#include <numbers>

#include "chains.hpp"
#include "guess/guess.hpp"
#include "guess/mirror.hpp"
#include "tolerance.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;

// The paper's rotation by half a turn about e_1 at N = 20.
maneuver::Maneuver half_turn() {
  maneuver::Maneuver maneuver;
  mechanics::Rotations rotation(3, Matrix3d::Identity());
  rotation[2] = lie::exp(Vector3d(0, 0, std::numbers::pi / 4));
  maneuver.start = {rotation, Vector3d(0.3, -0.2, 0.7), VectorXd::Zero(12)};
  for (const Matrix3d& R : rotation) maneuver.end_rotation.push_back(lie::exp(Vector3d(std::numbers::pi, 0, 0)) * R);
  maneuver.steps = 20;
  maneuver.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.05, 20);
  return maneuver;
}

const Vector3d about_e1(std::numbers::pi, 0, 0);

maneuver::NodePath random_motion(const model::System& system, const maneuver::Maneuver& maneuver) {
  maneuver::NodePath path = guess::random_guess(system, maneuver, 7);
  Random random(3);
  for (VectorXd& u : path.control)
    for (double& value : u) value = 50.0 * random.normal();
  return path;
}

TEST(Mirror, the_half_turn_of_the_chain_is_its_own_image_in_the_plane_of_e1_and_e2) {
  EXPECT_EQ(guess::mirror_axis(model::System(paper_chain()), half_turn(), about_e1), 2);
}

// Twist counts from the zero angle, which an image would turn the other way.
TEST(Mirror, there_is_none_of_joints_whose_zero_angle_it_changes) {
  model::SwimmerDescription chain = paper_chain();
  chain.joints[0].reference_rotation = Vector3d(0.0, 0.0, 0.4);  // kept by a reversal of e_3
  EXPECT_EQ(guess::mirror_axis(model::System(chain), half_turn(), about_e1), 2);
  chain.joints[0].reference_rotation = Vector3d(0.4, 0.0, 0.0);
  EXPECT_FALSE(guess::mirror_axis(model::System(chain), half_turn(), about_e1));
}

TEST(Mirror, an_image_costs_the_same_and_violates_the_equations_as_much) {
  const model::System system(paper_chain());
  const maneuver::Maneuver maneuver = half_turn();
  transcription::Transcription program(system, maneuver, transcription::stated_goal_rows(system, maneuver));
  const maneuver::NodePath path = random_motion(system, maneuver);
  const VectorXd x = program.pack(path);
  const VectorXd y = program.pack(guess::mirrored(system, path, 2));
  EXPECT_GT((x - y).norm(), 1.0) << "the image must be another motion";
  VectorXd cx(program.constraint_count()), cy(program.constraint_count());
  program.constraints(x, cx);
  program.constraints(y, cy);
  EXPECT_GT(cx.norm(), 1.0);
  EXPECT_NEAR(cx.norm(), cy.norm(), tolerance(1e-12) * cx.norm());
  EXPECT_NEAR(program.objective(x), program.objective(y), tolerance(1e-14) * program.objective(x));
}

TEST(Mirror, images_turn_opposite_ways_and_two_reflections_are_none) {
  const model::System system(paper_chain());
  const maneuver::Maneuver maneuver = half_turn();
  const maneuver::NodePath path = random_motion(system, maneuver);
  const maneuver::NodePath image = guess::mirrored(system, path, 2);
  const Vector3d turn(std::numbers::pi, 0, 0);
  EXPECT_NE(guess::turns_against(turn, path), guess::turns_against(turn, image));
  EXPECT_NE(guess::turns_against(turn, path), guess::turns_against(-turn, path));
  const maneuver::NodePath again = guess::mirrored(system, image, 2);
  for (std::size_t k = 0; k < path.rotation.size(); ++k) {
    EXPECT_LE((path.position[k] - again.position[k]).norm(), 1e-14);
    EXPECT_LE((path.rotation[k][1] - again.rotation[k][1]).norm(), 1e-14);
    EXPECT_LE((path.control[k] - again.control[k]).norm(), 1e-12);
  }
}

// A reflection along the turn's own axis would keep it.
TEST(Mirror, reverses_the_turn_wherever_the_chain_lies) {
  for (int along = 0; along < 3; ++along) {
    model::SwimmerDescription chain = paper_chain();
    for (model::JointDescription& joint : chain.joints)
      for (Vector3d* offset : {&joint.parent_offset, &joint.child_offset})
        *offset = offset->x() * Vector3d::Unit(along);
    maneuver::Maneuver straight = half_turn();
    straight.start.rotation.assign(3, Matrix3d::Identity());
    straight.end_rotation.assign(3, lie::exp(about_e1));
    const auto axis = guess::mirror_axis(model::System(chain), straight, about_e1);
    ASSERT_TRUE(axis);
    EXPECT_NE(*axis, 0);
    EXPECT_NE(*axis, along);
  }
}

TEST(Mirror, is_refused_where_swimmer_start_or_goal_is_lopsided) {
  const model::System system(paper_chain());
  maneuver::Maneuver turned = half_turn();
  turned.start.rotation[1] = lie::exp(Vector3d(0.1, 0.2, 0.3));
  EXPECT_FALSE(guess::mirror_axis(system, turned, about_e1));
  maneuver::Maneuver aside = half_turn();
  aside.end_position[2] = 1.0;
  EXPECT_FALSE(guess::mirror_axis(system, aside, about_e1));
  maneuver::Maneuver quarter = half_turn();
  for (auto& R : quarter.end_rotation) R = lie::exp(Vector3d(1.0, 0, 0));
  EXPECT_FALSE(guess::mirror_axis(system, quarter, about_e1));
  maneuver::Maneuver drawn = half_turn();
  drawn.cost_weights.displacement[2] = 1.0;
  EXPECT_FALSE(guess::mirror_axis(system, drawn, about_e1)) << "the image would lose what it wins";
  model::SwimmerDescription oblique = paper_chain();
  oblique.joints[0].control_axes = {Vector3d(0, 1, 0), Vector3d(1, 0, 1), Vector3d(1, 0, -1)};
  EXPECT_FALSE(guess::mirror_axis(model::System(oblique), half_turn(), about_e1)) << "moments change their places";
  model::SwimmerDescription crooked = paper_chain();
  crooked.joints[0].parent_offset[2] = 0.1;
  EXPECT_FALSE(guess::mirror_axis(model::System(crooked), half_turn(), about_e1));
}

}  // namespace
}  // namespace lamprey::tests
