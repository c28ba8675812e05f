// A swimmer of one hinge that cannot turn right round reaches a curve: what a march along the hinge shows is found, what lies
// beside it is out of reach, however coarse the steps.
#include <gtest/gtest.h>

#include <cmath>

#include "guess/angle_march.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"
#include "shape/single_angle.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

maneuver::Problem two_halves() {
  maneuver::Problem problem;
  problem.swimmer.density = 1000.0;
  problem.swimmer.bodies.resize(2);
  problem.swimmer.bodies[0].name = "front";
  problem.swimmer.bodies[0].semi_axes = {0.2, 0.05, 0.05};
  problem.swimmer.bodies[1].name = "rear";
  problem.swimmer.bodies[1].semi_axes = {0.2, 0.03, 0.08};
  model::JointDescription joint;
  joint.name = joint.child = "rear";
  joint.parent = "front";
  joint.kind = model::JointKind::hinge;
  joint.axis = Vector3d::UnitZ();
  joint.parent_offset = {-0.21, 0.0, 0.0};
  joint.child_offset = {0.21, 0.0, 0.0};
  problem.swimmer.joints = {joint};
  problem.start.rotation.assign(2, Vector3d::Zero());
  problem.start.angular_velocity.assign(2, Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.limits.angle["rear"] = {{-1.2, 1.2}};
  problem.duration.value = 1.0;
  problem.steps = 100;
  problem.search.starts = 2;
  return problem;
}

// Where the hinge's bending from 0 to an angle, and nothing else, takes the front.
maneuver::Goal led_by(const maneuver::Problem& problem, double angle, int steps = 2000) {
  maneuver::Problem march = problem;
  march.goal.reset();
  march.limits = {};
  march.steps = steps;
  guess::JointAngles angles;
  angles.turn = [angle](double s) { return maneuver::Vectors{Vector3d(angle * s * s * (3.0 - 2.0 * s), 0.0, 0.0)}; };
  angles.rate = [angle](double s) { return maneuver::Vectors{Vector3d(6.0 * angle * s * (1.0 - s), 0.0, 0.0)}; };
  const model::System system(march.swimmer);
  const maneuver::Solution end = guess::march_along(system, march, angles);
  EXPECT_EQ(end.status, maneuver::Status::simulated) << end.message;
  maneuver::Goal goal;
  for (std::size_t c = 0; c < 2; ++c) goal.move[c] = end.position.back()[static_cast<Eigen::Index>(c)];
  goal.rotation["front"] = lie::log(end.rotation.back()[0]);
  goal.rotation["rear"] = std::nullopt;
  return goal;
}

std::string beyond(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  return shape::beyond_single_angle(system, maneuver::make_maneuver(system, problem, 20), problem.limits, 20);
}

TEST(SingleAngle, reaches_where_its_joint_leads_and_nowhere_beside) {
  maneuver::Problem problem = two_halves();
  for (const double angle : {0.7, -1.1}) {
    problem.goal = led_by(problem, angle);
    EXPECT_EQ(beyond(problem), "") << angle;
    const model::System system(problem.swimmer);
    search::SolveOptions options;
    options.refinement = false;
    maneuver::Problem found = problem;  // one of the conditions leads to the others, but for what steps make of them
    found.goal->rotation["front"] = std::nullopt;
    found.goal->move[1] = std::nullopt;
    const study::Answer answer = study::answer(system, found, options);
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    *problem.goal->move[0] *= 1.02;
    EXPECT_NE(beyond(problem).find("scallop"), std::string::npos) << angle;
  }
  problem.goal = led_by(problem, 1.3);
  EXPECT_NE(beyond(problem).find("at none from -1.2 to 1.2 rad"), std::string::npos) << beyond(problem);
  problem.limits.angle["rear"] = {{-1.2, 1.35}};
  EXPECT_EQ(beyond(problem), "");
}

// Attitudes of more than half a turn are not met where their logarithm jumps, strokes within a piece of the curve are.
TEST(SingleAngle, is_followed_through_far_turns_and_small_strokes) {
  maneuver::Problem problem = two_halves();
  problem.limits.angle["rear"] = {{-3.0, 3.0}};
  problem.goal->rotation["front"] = Vector3d(0.0, 0.0, 2.6);
  EXPECT_NE(beyond(problem).find("the end attitude of front is missed by"), std::string::npos);
  for (const double angle : {0.0015, 0.0004, -0.01}) {
    problem.goal = led_by(problem, angle);
    EXPECT_EQ(beyond(problem), "") << angle;
    *problem.goal->move[1] *= 1.01;
    EXPECT_NE(beyond(problem), "") << angle;
  }
}

// Long steps let a search jump there; that is none of the swimmer's doing.
TEST(SingleAngle, is_told_of_goals_that_only_long_steps_would_reach) {
  maneuver::Problem problem = two_halves();
  problem.goal->move = {0.002, std::nullopt, std::nullopt};
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::infeasible);
  EXPECT_NE(answer.solution.message.find("goal.move along e₁ is missed by 0.002 m"), std::string::npos)
      << answer.solution.message;
}

// Of attitudes in the first shape whole turns reach one after the other, and none between.
TEST(SingleAngle, by_whole_turns_ends_where_each_of_them_leads) {
  maneuver::Problem problem = two_halves();
  problem.limits = {};
  for (const double stiffness : {0.0, 1e-9}) {
    problem.swimmer.joints[0].stiffness = stiffness;
    for (const int turns : {1, -2}) {
      maneuver::Goal goal = led_by(problem, 2.0 * M_PI * turns, 20000);
      goal.turn = goal.rotation["front"];
      goal.rotation.clear();
      problem.goal = goal;
      EXPECT_EQ(beyond(problem), "") << turns;
      *problem.goal->turn *= 1.05;
      EXPECT_NE(beyond(problem).find("no more than 10 either way"), std::string::npos) << beyond(problem);
      EXPECT_NE(beyond(problem).find("comes nearest by " + std::to_string(turns)), std::string::npos)
          << beyond(problem);
    }
  }
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::infeasible) << answer.solution.message;
}

// Two halves on one line turn about it, each against the other: what a march shows is within reach of as many steps, however few.
TEST(SingleAngle, by_whole_turns_gets_as_far_as_its_steps_show_both_halves_turn) {
  maneuver::Problem problem = two_halves();
  problem.limits = {};
  problem.swimmer.bodies[0].semi_axes = {0.12, 0.03, 0.05};
  problem.swimmer.bodies[1].semi_axes = {0.12, 0.03, 0.052};
  problem.swimmer.joints[0].axis = Vector3d::UnitX();
  const model::System system(problem.swimmer);
  const double front = system.body(0).inertia_matrix(0, 0), rear = system.body(1).inertia_matrix(0, 0);
  const auto ends_by = [&](int turns) {
    const double whole = -2.0 * M_PI * turns * rear / (front + rear);
    problem.goal->turn = Vector3d(std::remainder(whole, 2.0 * M_PI), 0.0, 0.0);
  };
  const auto words = [&](int steps) {
    return shape::beyond_single_angle(system, maneuver::make_maneuver(system, problem, steps), problem.limits, steps);
  };
  for (const int turns : {28, -26, 3}) {
    led_by(problem, 2.0 * M_PI * turns, 100);  // by more than a quarter turn in a step
    ends_by(turns);
    EXPECT_EQ(words(100), "") << turns;
  }
  ends_by(7);
  EXPECT_EQ(words(20), "");
  EXPECT_NE(words(12).find("12 steps show no more than 6 either way"), std::string::npos) << words(12);
}

// Many turns end as far beside as few, and next to one of them is beside it.
TEST(SingleAngle, by_many_whole_turns_keeps_its_attitude_a_rotation) {
  maneuver::Problem problem = two_halves();
  problem.limits = {};
  problem.goal->turn = Vector3d(0.0, 0.0, 5e-5);
  const model::System system(problem.swimmer);
  const auto words = [&] {
    return shape::beyond_single_angle(system, maneuver::make_maneuver(system, problem, 400), problem.limits, 400);
  };
  EXPECT_NE(words().find("no more than 200 either way"), std::string::npos) << words();
  const Vector3d whole = *led_by(problem, 2.0 * M_PI, 20000).rotation["front"];
  problem.goal->turn = whole + Vector3d(0.0, 0.0, 1e-4);
  EXPECT_NE(words().find("comes nearest by 1, after which"), std::string::npos) << words();
  problem.goal->turn = whole;
  EXPECT_EQ(words(), "");
}

// A gait closes by whole turns or goes back, whatever its first shape: what these turns lead to is all that there is.
TEST(SingleAngle, of_gaits_that_close_by_whole_turns_leads_where_these_do) {
  maneuver::Problem problem = two_halves();
  problem.limits = {};
  const Vector3d whole = *led_by(problem, 2.0 * M_PI, 20000).rotation["front"];
  problem.goal->periodic = true;
  problem.goal->move = {};
  for (const bool free_shape : {false, true}) {
    problem.start.free_shape = free_shape;
    problem.goal->turn = whole;
    EXPECT_EQ(beyond(problem), "");
    *problem.goal->turn *= 1.05;
    EXPECT_NE(beyond(problem).find("no more than 10 either way"), std::string::npos) << beyond(problem);
  }
  // halves alike turn by half a turn, so that two whole turns bring them back
  problem.swimmer.bodies[1].semi_axes = problem.swimmer.bodies[0].semi_axes;
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move = {0.05, std::nullopt, std::nullopt};
  EXPECT_NE(beyond(problem).find("no more than 10 either way"), std::string::npos) << beyond(problem);
  problem.goal->move = {};
  problem.cost_weights.displacement = {5.0, 0.0, 0.0};
  const model::System alike(problem.swimmer);
  const auto refuse = [&] {
    shape::refuse_price_of_no_whole_turn(alike, maneuver::make_maneuver(alike, problem, 20), problem.limits, 20);
  };
  EXPECT_THROW(refuse(), model::InputError);
  problem.goal->turn.reset();  // one turn leaves them turned, and elsewhere
  EXPECT_NO_THROW(refuse());
}

// Where no turn comes nearer than to stay, that is told.
TEST(SingleAngle, that_stays_nearer_than_any_turn_leads_says_so) {
  maneuver::Problem problem = two_halves();
  problem.limits = {};
  problem.goal->move = {0.01, std::nullopt, std::nullopt};
  problem.goal->turn = Vector3d::Zero();
  EXPECT_NE(beyond(problem).find("comes nearest without any, where goal.move along e₁ is missed by 0.01 m"),
            std::string::npos)
      << beyond(problem);
}

TEST(SingleAngle, says_nothing_of_what_can_turn_round_drift_or_has_more_joints) {
  maneuver::Problem problem = two_halves();
  problem.goal->move = {0.002, std::nullopt, std::nullopt};
  ASSERT_NE(beyond(problem), "");
  maneuver::Problem round = problem;
  round.limits = {};
  EXPECT_EQ(beyond(round), "");
  round.swimmer.joints[0].stiffness = 0.1;  // a spring pulls on beyond half a turn, and holds nothing
  EXPECT_EQ(beyond(round), "");
  maneuver::Problem drifting = problem;
  drifting.start.linear_velocity = {0.1, 0.0, 0.0};
  drifting.goal->rest = false;
  EXPECT_EQ(beyond(drifting), "");
  problem.swimmer.joints[0].kind = model::JointKind::ball;
  problem.swimmer.joints[0].axis.reset();
  problem.limits = {};
  problem.limits.swing["rear"] = 1.0;
  EXPECT_EQ(beyond(problem), "");
}

}  // namespace
}  // namespace lamprey::tests
