// Advice begins with what the answer's own numbers point at: turns of a quarter in a step, a limit that is broken.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "study/advice.hpp"
#include "study/faults.hpp"
#include "study/verdict.hpp"

namespace lamprey::tests {
namespace {

using certificate::Certificate;
using maneuver::Solution;

class Advice : public testing::Test {
 protected:
  Advice() {
    problem_.steps = 40;
    problem_.search.starts = 4;
    proof_.equation_residual = proof_.goal_error = proof_.rest_error = 0.0;
    proof_.start_error = proof_.control_error = proof_.time_error = proof_.velocity_error = proof_.cost_error = 0.0;
    proof_.momentum_drift = proof_.rotation_drift = 0.0;
    proof_.kkt = 0.1;
    turn(0.1);
  }

  void turn(double angle) {  // of the first body in every step
    solution_.time.clear();
    solution_.rotation.clear();
    for (int k = 0; k <= problem_.steps; ++k) {
      solution_.time.push_back(0.1 * k);
      solution_.rotation.emplace_back(problem_.swimmer.bodies.size(), Eigen::Matrix3d::Identity());
      solution_.rotation.back()[0] = lie::exp(Eigen::Vector3d(0.0, 0.0, angle * k));
    }
  }

  std::string message() {
    Solution judged = solution_;
    study::judge(problem_, proof_, judged);
    return judged.message;
  }
  bool tells(const std::string& words) { return message().find(words) != std::string::npos; }

  maneuver::Problem problem_ = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  Certificate proof_;
  Solution solution_;
};

// An optimiser leaves a share of the swimmer's own unit of length, 128 m here, of what it meets.
TEST_F(Advice, calls_nothing_out_of_reach_that_only_the_optimiser_left) {
  for (model::BodyDescription& body : problem_.swimmer.bodies) body.semi_axes = Eigen::Vector3d(1e3, 6e2, 4e2);
  solution_.status = maneuver::Status::optimal;
  proof_.goal_missed = "goal.move along e₁";
  proof_.goal_missed_by_turn = false;
  proof_.goal_error = 1e-7;
  EXPECT_FALSE(tells("Out of reach"));
  proof_.goal_error = 1e-3;
  EXPECT_TRUE(tells("Out of reach"));
  proof_.goal_error = 1e-7;
  proof_.goal_missed_by_turn = true;
  EXPECT_TRUE(tells("Out of reach"));
}

TEST_F(Advice, ranks_motions_by_what_they_miss_most) {
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.0);
  proof_.goal_error = 0.5 * evidence::goal_mark;
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.0);
  proof_.goal_error = 0.02;
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.02);
  proof_.limits.emplace();
  proof_.limits->violation = 0.3;
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.3);
  proof_.rest_error = 0.4;
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.4);
  problem_.goal->rest = false;
  EXPECT_EQ(study::missed_by(problem_, proof_), 0.3);
  proof_.goal_error = NAN;
  EXPECT_EQ(study::missed_by(problem_, proof_), INFINITY);
}

TEST_F(Advice, says_where_round_off_hides_the_curvature) {
  proof_.kkt = 1e-13;
  const auto words = [&](double smallest, std::optional<int> descent) {
    proof_.second_order = optimality::SecondOrder{smallest, false, descent};
    return study::curvature_words(problem_, proof_);
  };
  EXPECT_NE(words(-1e5, {}).find("round-off hides"), std::string::npos);
  EXPECT_EQ(words(-1e5, {}).find("e+05"), std::string::npos) << "a number that means nothing";
  EXPECT_NE(words(-1e5, 3).find("3 directions lower"), std::string::npos);
  EXPECT_NE(words(-1e-9, {}).find("smallest curvature -1e-09"), std::string::npos) << "flat, not lost";
  EXPECT_NE(words(-1e-9, {}).find("answers of equal cost may lie there"), std::string::npos);
  EXPECT_EQ(words(-1e-3, {}).find("answers of equal cost"), std::string::npos);
}

// What the certificate says is not said again with an optimiser's other digits; what steps cannot show is not infeasible for that.
TEST_F(Advice, says_once_what_is_missed_and_blames_long_steps_for_limits_they_break) {
  proof_.goal_missed = "goal.move along e₁";
  proof_.goal_missed_by_turn = false;
  proof_.goal_error = 0.16;
  maneuver::Solution stuck = solution_;
  stuck.status = maneuver::Status::infeasible;
  stuck.message = "no step makes progress; goal.move along e₁ is missed by 0.119 m";
  maneuver::Solution kept = stuck;
  study::judge(problem_, proof_, kept);
  EXPECT_EQ(kept.message.find("0.119"), std::string::npos) << kept.message;
  EXPECT_NE(kept.message.find("no step makes progress."), std::string::npos) << kept.message;
  EXPECT_EQ(kept.status, maneuver::Status::infeasible);
  for (std::size_t k = 0; k < stuck.rotation.size(); ++k)
    stuck.rotation[k][1] = lie::exp({0.0, 0.0, 1.57 * static_cast<double>(k)});
  study::judge(problem_, proof_, stuck);
  EXPECT_EQ(stuck.status, maneuver::Status::stalled);
}

TEST_F(Advice, speaks_of_neither_where_nothing_points_there) {
  EXPECT_TRUE(tells("try more starts, or another seed.")) << message();
  for (const char* other : {"[time] steps", "looser", "nearer goal", "control_axes", "tolerance ="})
    EXPECT_FALSE(tells(other)) << message();
}

TEST_F(Advice, is_a_looser_tolerance_where_that_is_all_that_is_missed) {
  proof_.kkt = 1.7e-7;
  EXPECT_TRUE(tells("where so much is enough, [search] tolerance = 2e-07 accepts it")) << message();
  problem_.search.tolerance = 2e-7;
  EXPECT_FALSE(tells("tolerance")) << message();
}

TEST_F(Advice, is_more_time_first_where_the_goal_is_met_and_the_time_was_over) {
  EXPECT_FALSE(tells("time_limit")) << message();
  solution_.status = maneuver::Status::time_limit;
  EXPECT_TRUE(tells("a longer search.time_limit, more starts")) << message();
}

TEST_F(Advice, does_not_call_it_curvature_where_limits_leave_no_direction) {
  proof_.kkt = 0.0;
  proof_.second_order = optimality::SecondOrder{0.4, true, 0};
  EXPECT_NE(study::curvature_words(problem_, proof_).find("smallest curvature 0.4"), std::string::npos);
  proof_.second_order->smallest_eigenvalue = 4.4e14;
  EXPECT_EQ(study::curvature_words(problem_, proof_).find("smallest curvature"), std::string::npos);
  EXPECT_NE(study::curvature_words(problem_, proof_).find("limits leave no direction open"), std::string::npos);
}

// Where the goal is missed while limits hold, these are named: one of them may be why.
TEST_F(Advice, comes_with_the_limits_that_a_motion_is_at) {
  proof_.goal_error = 1.5;
  problem_.limits.angular_velocity = 0.1;
  proof_.limits.emplace();
  proof_.limits->violation = proof_.limits->complementarity = proof_.limits->negative = 0.0;
  EXPECT_FALSE(tells("is at its limits")) << message();
  proof_.limits->reached = {{"limits.angular_velocity", 0.871}, {"limits.swing.front", 0.001}};
  EXPECT_TRUE(tells("is at its limits: of its nodes limits.angular_velocity at 87 %, limits.swing.front at 1 %."))
      << message();
}

TEST_F(Advice, is_more_time_where_moments_or_rates_are_limited_or_the_search_was) {
  proof_.goal_error = 0.1;
  problem_.limits.torque = 3.0;
  EXPECT_TRUE(tells("try a longer time.duration, ")) << message();
  problem_.waypoints.resize(2);
  EXPECT_TRUE(tells("try a longer time.duration, waypoints farther apart in time, or fewer, ")) << message();
  problem_.duration.free = true;
  problem_.duration.max = solution_.time.back();
  EXPECT_TRUE(tells("try a larger time.max, waypoints")) << message();
  problem_.duration.max = 10.0 * solution_.time.back();
  EXPECT_FALSE(tells("time.max")) << "there is time: " << message();
  problem_.duration.max = solution_.time.back();
  proof_.limits = evidence::LimitsKept{1.0, "time.max", 5.0, 0.0, 0.0};
  problem_.limits.joint_angular_velocity["front"] = 0.1;
  EXPECT_TRUE(tells("try a larger time.max, a looser limits.torque or limits.angular_velocity.front, ")) << message();
  solution_.status = maneuver::Status::time_limit;
  EXPECT_TRUE(tells("try a longer search.time_limit")) << message();
  EXPECT_FALSE(tells("time.max")) << message();
}

// The message is one text for files, its parts are for people's lists.
TEST_F(Advice, comes_in_parts_that_are_the_message) {
  proof_.goal_error = 0.1;
  maneuver::Solution missed = solution_;
  missed.message = "no step makes progress";
  const maneuver::Failure failure = study::judge(problem_, proof_, missed);
  EXPECT_EQ(failure.text(), missed.message);
  EXPECT_EQ(failure.missed.rfind("Not solved: ", 0), 0U) << failure.missed;
  EXPECT_NE(failure.cause.find("The optimiser stopped: no step makes progress."), std::string::npos) << failure.cause;
  ASSERT_EQ(failure.remedies.size(), 3U);
  EXPECT_EQ(failure.remedies[1], "another seed");
  proof_.goal_error = 0.0;
  proof_.kkt = 0.0;
  const bool failed = study::judge(problem_, proof_, missed).any();
  EXPECT_EQ(failed, missed.status != maneuver::Status::optimal);
}

TEST_F(Advice, is_a_nearer_goal_where_it_is_missed) {
  proof_.goal_error = 0.1;
  EXPECT_TRUE(tells("try more starts, another seed, or a nearer goal; check that control_axes can reach it"))
      << message();
}

TEST_F(Advice, is_more_steps_where_a_body_turns_by_a_quarter_in_one) {
  turn(1.57);
  EXPECT_TRUE(tells("What may help: try [time] steps = 80, more starts")) << message();
}

TEST_F(Advice, is_the_limit_that_makes_it_a_minimum_where_joints_were_held_from_such_turns) {
  solution_.solver.held_joint_rate = 100.0;
  EXPECT_TRUE(tells("What may help: try limits.angular_velocity = 100, or [time] steps = 80.")) << message();
  EXPECT_FALSE(tells("more starts")) << message();
  solution_.status = maneuver::Status::time_limit;
  EXPECT_TRUE(tells("try limits.angular_velocity = 100, or a longer search.time_limit.")) << message();
}

// More steps only let them whirl faster.
TEST_F(Advice, is_what_motors_can_do_where_joints_were_held_and_bodies_whirl) {
  solution_.solver.held_joint_rate = 126.0;
  const mechanics::Vectors whirling(problem_.swimmer.bodies.size(), Eigen::Vector3d(0.0, 0.0, 100.0));
  solution_.angular_velocity.assign(solution_.time.size(), whirling);
  EXPECT_TRUE(
      tells("try a limits.angular_velocity that motors can do (at 126 rad/s steps cease to show turns), a little "
            "cost.angular_velocity, or [time] steps = 80."))
      << message();
}

TEST_F(Advice, is_a_looser_limit_where_that_is_broken) {
  proof_.limits = evidence::LimitsKept{0.01, "limits.angle.front", 2.0, 0.0, 0.0};
  EXPECT_TRUE(
      tells("What may help: try a looser limits.angle.front, a share of the way (what takes many strokes is a gait, "
            "goal.periodic, repeated), more starts"))
      << message();
  problem_.goal->periodic = true;
  EXPECT_TRUE(tells("What may help: try a looser limits.angle.front, more starts")) << message();
  proof_.limits->key = "goal.waypoint.0";
  EXPECT_FALSE(tells("looser")) << message();
  EXPECT_TRUE(tells("goal.waypoint.0 is broken by 0.01")) << message();
}

TEST_F(Advice, is_more_steps_where_stages_do_not_follow_from_the_moments) {
  proof_.equation_residual = std::nan("");
  EXPECT_FALSE(tells("[time] steps")) << message();
  problem_.scheme = maneuver::Scheme::order4;
  EXPECT_TRUE(tells("What may help: try [time] steps = 80, more starts")) << message();
}

// A search for the least work per distance may fade towards rest.
TEST_F(Advice, is_a_distance_where_a_motion_of_least_work_per_distance_shrank) {
  problem_.cost_weights.transport = 1.0;
  problem_.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  solution_.position.assign(solution_.time.size(), Eigen::Vector3d::Zero());
  solution_.position.back().x() = 1e-4;
  EXPECT_TRUE(tells("The motion shrank to a displacement of 0.0001 m, and next to rest work per distance"))
      << message();
  EXPECT_TRUE(tells("What may help: try a distance (goal.move), more starts")) << message();
  solution_.position.back().x() = 5.0;
  EXPECT_FALSE(tells("shrank")) << message();
  solution_.position.back().x() = 1e-4;
  problem_.cost_weights.transport = 0.0;
  EXPECT_FALSE(tells("shrank")) << message();
}

// Half a turn one way is half a turn the other, and people asked for one.
TEST(WayRound, is_told_where_the_root_goes_another_one_than_asked) {
  maneuver::Problem problem;
  problem.swimmer.bodies.resize(1);
  problem.swimmer.bodies[0].name = "middle";
  problem.goal.emplace();
  problem.goal->turn = Eigen::Vector3d(0.0, 0.0, M_PI);
  const auto turned = [&](double by, double beside = 0.0) {
    maneuver::Solution solution;
    for (int k = 0; k <= 20; ++k)
      solution.rotation.push_back(
          {lie::exp({beside * std::sin(M_PI * k / 20.0), 0.0, 0.0}) * lie::exp({0.0, 0.0, by * k / 20.0})});
    return study::way_round(problem, solution);
  };
  EXPECT_EQ(turned(M_PI), "");
  EXPECT_EQ(turned(-M_PI),
            " On its way middle turns by -3.142 rad, not by 3.142: whole turns lead to the same attitude.");
  EXPECT_NE(turned(3.0 * M_PI), "");
  EXPECT_EQ(turned(-M_PI, 1.0), "") << "in space there is no one way round";
  problem.goal->turn = Eigen::Vector3d::Zero();
  EXPECT_EQ(turned(2.0 * M_PI), "") << "asked for nothing";
}

// A goal counts no whole turns of joints, and people may have meant them.
TEST(WayRound, is_told_where_joints_end_whole_turns_beside_what_is_asked) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/hinge_fins.toml");
  const model::System system(problem.swimmer);
  const model::Joint& joint = system.joint(0);
  ASSERT_EQ(joint.kind, model::JointKind::hinge);
  problem.goal.emplace();
  const auto told = [&](double asked, double end) {
    problem.goal->angle[joint.name] = {asked};
    maneuver::Solution solution;
    for (int k = 0; k <= 20; ++k) {
      solution.rotation.emplace_back(problem.swimmer.bodies.size(), Eigen::Matrix3d::Identity());
      solution.rotation.back()[static_cast<std::size_t>(joint.child)] =
          mechanics::rotation_at_turn(joint, Eigen::Vector3d(end * k / 20.0, 0.0, 0.0));
    }
    return study::ways_of_joints(problem, solution);
  };
  EXPECT_EQ(told(6.0, 6.0), "");
  EXPECT_EQ(told(6.0, 6.0 - 2.0 * M_PI),
            " Joint " + joint.name + " ends at -0.2832 rad, not at 6: whole turns lead to the same attitude.");
  EXPECT_NE(told(0.5, 0.5 + 2.0 * M_PI), "");
  EXPECT_EQ(told(6.0, -0.5), "") << "misses the goal";
}

// What limits of angular velocity leave is no cure; nor is a gait for what begins in motion, which momentum takes there by itself.
TEST(AdviceOnMore, of_long_steps_and_of_drifts_is_what_helps) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.steps = 2;
  problem.limits.angular_velocity = 100.0;
  maneuver::Solution solution;
  for (int k = 0; k <= 2; ++k) {
    solution.time.push_back(0.5 * k);
    solution.position.emplace_back(0.0, 0.0, 0.0);
    solution.rotation.push_back(
        {Eigen::Matrix3d::Identity(), lie::exp({0.0, 0.0, 1.57 * k}), Eigen::Matrix3d::Identity()});
  }
  EXPECT_NE(study::far_turn(problem, solution).find("may be too few for what limits.angular_velocity leaves"),
            std::string::npos)
      << study::far_turn(problem, solution);
  problem.limits = {};
  EXPECT_NE(study::far_turn(problem, solution).find("; a limits.angular_velocity keeps"), std::string::npos);
  for (auto& rotations : solution.rotation) rotations[1].setIdentity();
  maneuver::Problem drifting = problem;
  drifting.steps = 200;
  drifting.start.linear_velocity = {1.0, 0.0, 0.0};
  drifting.goal->rest = false;
  drifting.goal->move = {4.0, std::nullopt, std::nullopt};
  drifting.duration.value = 1.0;
  solution.position.back().x() = 4.0;
  certificate::Certificate proof;
  proof.goal_error = 0.0;
  proof.limits.emplace();
  proof.limits->key = "limits.swing.front";
  proof.limits->violation = 0.5;
  const maneuver::Failure failure{"Not solved.", "", study::advice(drifting, proof, solution)};
  const std::string words = failure.text();
  EXPECT_NE(words.find("a time.duration nearer to the 4 s in which its momentum alone takes it there"),
            std::string::npos)
      << words;
  EXPECT_EQ(words.find("goal.periodic"), std::string::npos) << words;
}

}  // namespace
}  // namespace lamprey::tests
