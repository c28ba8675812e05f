#include "certificate/certify.hpp"

#include <gtest/gtest.h>

#include "marched_answers.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using certificate::Certificate;
using integrator::Scheme;

const certificate::Options laws_only{.optimality = false, .replay = false};

Certificate certified(const MarchedAnswer& answer, const certificate::Options& options = laws_only) {
  return certificate::certify(model::System(answer.problem.swimmer), answer.problem, answer.solution, options);
}

MarchedAnswer tumbling(Scheme scheme, int steps = 200) {
  maneuver::Problem problem = chain_problem(steps, 0.001 * steps);
  problem.scheme = scheme;
  problem.start.angular_velocity = {Vector3d(0.6, -0.9, 1.2), Vector3d(2.5, 1, -1.5), Vector3d(-2, 1.5, 1)};
  problem.start.linear_velocity = Vector3d(0.5, 0.2, -0.1);
  problem.start.position = Vector3d(0.3, -0.2, 0.1);
  problem.goal->rest = false;
  return march(problem, smooth_moments(steps, 50.0));
}

TEST(Certificate, of_a_marched_motion_finds_the_laws_kept) {
  for (Scheme scheme : {Scheme::paper, Scheme::trapezoid}) {
    const Certificate proof = certified(tumbling(scheme));
    EXPECT_LE(proof.momentum_drift, tolerance(1e-12));
    EXPECT_LE(proof.equation_residual, tolerance(1e-12));
    EXPECT_LE(proof.rotation_drift, tolerance(1e-14));
    EXPECT_LE(proof.start_error, tolerance(1e-14));
    EXPECT_LE(proof.control_error, tolerance(1e-14));
  }
}

TEST(Certificate, of_one_scheme_does_not_pass_for_the_other) {
  MarchedAnswer answer = tumbling(Scheme::paper);
  answer.problem.scheme = Scheme::trapezoid;
  EXPECT_GT(certified(answer).equation_residual, 1e-7);
}

TEST(Certificate, finds_one_rotation_that_is_off_by_a_millionth) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  answer.solution.rotation[70][1] *= lie::exp(Vector3d(1e-6, 0, 0));
  const Certificate proof = certified(answer);
  EXPECT_GT(proof.equation_residual, 1e-7);
  EXPECT_GT(proof.momentum_drift, 1e-7);
  EXPECT_LE(proof.rotation_drift, tolerance(1e-14));
}

TEST(Certificate, finds_a_matrix_that_is_no_rotation) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  answer.solution.rotation[70][1](0, 2) += 1e-9;
  EXPECT_NEAR(certified(answer).rotation_drift, 1e-9, 1e-9);
  EXPECT_GT(certified(answer).rotation_drift, 1e-10);
  answer.solution.rotation[70][1](0, 2) = NAN;
  EXPECT_FALSE(certified(answer).rotation_drift < 1.0);
  EXPECT_FALSE(certified(answer).equation_residual < 1.0);
}

TEST(Certificate, finds_one_moment_that_was_changed) {
  for (std::size_t node : {std::size_t{0}, std::size_t{90}}) {
    MarchedAnswer answer = tumbling(Scheme::trapezoid);
    answer.solution.control[node][1].y() += 1e-3;
    const Certificate proof = certified(answer);
    EXPECT_GT(proof.equation_residual, 1e-9) << node;
    EXPECT_LE(proof.momentum_drift, tolerance(1e-12)) << "moments act in pairs";
  }
}

TEST(Certificate, finds_moments_that_the_joint_does_not_have) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  for (auto& joint : answer.problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  EXPECT_GT(certified(answer).control_error, 0.1);
}

TEST(Certificate, finds_another_start) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  answer.problem.start.rotation[2].z() += 1e-5;
  EXPECT_NEAR(certified(answer).start_error, 1e-5, 1e-10);
  MarchedAnswer faster = tumbling(Scheme::trapezoid);
  faster.problem.start.angular_velocity[0].x() += 1e-5;
  EXPECT_GT(certified(faster).equation_residual, 1e-7);
  EXPECT_GT(certified(faster).momentum_drift, 1e-7);
}

// The goal put where the motion ended is met; moved from there it is missed by as much.
TEST(Certificate, goal_error_is_the_full_angle_and_the_displacement) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  maneuver::Goal& goal = *answer.problem.goal;
  const auto& end = answer.solution.rotation.back();
  goal.turn.reset();
  for (std::size_t i = 0; i < 3; ++i) goal.rotation[answer.problem.swimmer.bodies[i].name] = lie::log(end[i]);
  goal.move[0] = answer.solution.position.back().x() - answer.problem.start.position.x();
  EXPECT_LE(certified(answer).goal_error, tolerance(1e-14));
  goal.move[0] = *goal.move[0] + 0.25;
  EXPECT_NEAR(certified(answer).goal_error, 0.25, tolerance(1e-14));
  EXPECT_EQ(certified(answer).goal_missed, "goal.move along e₁");
  EXPECT_FALSE(certified(answer).goal_missed_by_turn);
  goal.rotation["front"] = lie::log(end[1] * lie::exp(Vector3d(0, M_PI, 0)));
  EXPECT_NEAR(certified(answer).goal_error, M_PI, tolerance(1e-7)) << "a half turn away is not at the goal";
  EXPECT_EQ(certified(answer).goal_missed, "the end attitude of front");
  EXPECT_TRUE(certified(answer).goal_missed_by_turn);
  goal.rotation["front"] = std::nullopt;
  EXPECT_NEAR(certified(answer).goal_error, 0.25, tolerance(1e-14)) << "free";
}

TEST(Certificate, turn_is_about_world_axes_from_each_start_rotation_and_a_named_rotation_overrides_it) {
  maneuver::Problem problem = chain_problem(4, 0.01);
  const MarchedAnswer still = march(problem, NodeMoments(5, mechanics::Moments(2, Vector3d::Zero())));
  EXPECT_NEAR(certified(still).goal_error, problem.goal->turn->norm(), tolerance(1e-14));
  MarchedAnswer answer = still;
  answer.problem.goal->move[0] = 0.0;
  for (auto& rotations : answer.solution.rotation)
    for (auto& R : rotations) R = lie::exp(*answer.problem.goal->turn) * R;
  EXPECT_LE(certified(answer).goal_error, tolerance(1e-14));
  answer.problem.goal->rotation["back"] = Vector3d::Zero();
  EXPECT_GT(certified(answer).goal_error, 0.1);
}

TEST(Certificate, rest_error_is_the_momentum_left_at_the_end) {
  maneuver::Problem problem = chain_problem(50, 0.05);
  const NodeMoments none(51, mechanics::Moments(2, Vector3d::Zero()));
  EXPECT_EQ(certified(march(problem, none)).rest_error, 0.0);
  const Certificate moving = certified(march(problem, smooth_moments(50, 20.0)));
  EXPECT_GT(moving.rest_error, 0.01);
  EXPECT_GE(moving.equation_residual, moving.rest_error);
  // the motion is so small that the rounding of stored rotations, divided by h, shows
  EXPECT_LE(moving.momentum_drift, tolerance(1e-10)) << "total momentum stays zero from rest";
}

TEST(Certificate, of_a_simulated_motion_knows_the_laws_alone) {
  MarchedAnswer answer = tumbling(Scheme::trapezoid);
  answer.problem.goal.reset();
  answer.solution.status = maneuver::Status::simulated;
  const Certificate proof = certified(answer, {});
  EXPECT_LE(proof.momentum_drift, tolerance(1e-12));
  EXPECT_LE(proof.equation_residual, tolerance(1e-12));
  EXPECT_TRUE(std::isnan(proof.goal_error));
  EXPECT_TRUE(std::isnan(proof.kkt));
  EXPECT_FALSE(proof.replay.has_value());
}

TEST(Certificate, of_any_tree_marched_by_a_scheme_of_one_step_finds_the_laws_kept) {
  for (const Scheme scheme : {Scheme::paper, Scheme::trapezoid, Scheme::midpoint})
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const MarchedAnswer answer = any_tree(seed, scheme, 50);
      ASSERT_EQ(answer.solution.status, maneuver::Status::simulated) << answer.solution.message;
      const Certificate proof = certified(answer);
      EXPECT_LE(proof.momentum_drift, tolerance(1e-11)) << seed;
      EXPECT_LE(proof.equation_residual, tolerance(1e-11)) << seed;
      EXPECT_LE(proof.rotation_drift, tolerance(1e-14));
      EXPECT_LE(proof.start_error, tolerance(1e-14));
    }
}

TEST(Certificate, of_any_tree_finds_a_damper_a_spring_or_a_coupling_that_was_changed) {
  int dampers = 0, springs = 0, couplings = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const MarchedAnswer answer = any_tree(seed, Scheme::midpoint);
    for (std::size_t j = 0; j < 5; ++j) {
      MarchedAnswer changed = answer;
      model::JointDescription& joint = changed.problem.swimmer.joints[j];
      if (joint.damping > 0.0) {
        joint.damping *= 1.001;
        EXPECT_GT(certified(changed).equation_residual, 1e-9) << seed;
        joint.damping /= 1.001;
        ++dampers;
      }
      if (joint.stiffness > 0.0) {
        joint.stiffness *= 1.001;
        EXPECT_GT(certified(changed).equation_residual, 1e-9) << seed;
        ++springs;
      }
    }
    MarchedAnswer changed = answer;
    for (model::BodyDescription& body : changed.problem.swimmer.bodies)
      if (body.coupling_matrix) {
        *body.coupling_matrix *= 1.001;
        ++couplings;
        EXPECT_GT(certified(changed).equation_residual, 1e-9) << seed;
        break;
      }
  }
  EXPECT_GT(dampers, 3);
  EXPECT_GT(springs, 3);
  EXPECT_GT(couplings, 3);
}

TEST(Certificate, finds_a_led_body_that_left_its_hinge) {
  int hinges = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    MarchedAnswer answer = any_tree(seed, Scheme::trapezoid);
    for (const model::JointDescription& joint : answer.problem.swimmer.joints) {
      if (joint.kind != model::JointKind::hinge) continue;
      const std::size_t child = static_cast<std::size_t>(std::stoi(joint.child.substr(4)));
      answer.solution.rotation[40][child] *= lie::exp(1e-6 * joint.axis->unitOrthogonal());
      EXPECT_GT(certified(answer).equation_residual, 1e-8) << seed;
      ++hinges;
      break;
    }
  }
  EXPECT_GT(hinges, 3);
}

// Of compositions the moments of their stages tell whether the steps between the nodes obey the law, polynomials or not.
TEST(Certificate, above_order_2_marches_its_steps_again_and_knows_none_of_divided_ones) {
  for (const Scheme scheme : {Scheme::order4, Scheme::order6})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      MarchedAnswer answer = any_tree(seed, scheme, 25);
      const Certificate proof = certified(answer);
      EXPECT_LE(proof.momentum_drift, tolerance(1e-11));
      EXPECT_LE(proof.rotation_drift, tolerance(1e-14));
      EXPECT_LE(proof.equation_residual, tolerance(1e-11));
      EXPECT_LE(proof.control_error, tolerance(1e-12));
      answer.solution.angular_velocity[12][0].x() += 1e-6;
      EXPECT_GT(certified(answer).momentum_drift, 1e-9);
    }
  MarchedAnswer divided = tumbling(Scheme::trapezoid, 10);
  divided.solution.divided.steps = 1;
  EXPECT_TRUE(std::isnan(certified(divided).equation_residual));
}

TEST(Certificate, leaves_unset_what_it_does_not_know) {
  MarchedAnswer unknown_scheme = tumbling(Scheme::trapezoid, 10);
  unknown_scheme.problem.scheme = Scheme::order4;
  EXPECT_TRUE(std::isnan(certified(unknown_scheme).momentum_drift));
  EXPECT_FALSE(std::isnan(certified(unknown_scheme).goal_error));
}

}  // namespace
}  // namespace lamprey::tests
