// Costs of the joints' own rates: the cheapest way to an angle is even, whatever the swimmer is made of; both solvers' answers are one;
// and bodies so light that effort hardly feels them keep still.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "marched_answers.hpp"
#include "search/first_motion.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

study::Answer answer_of(const maneuver::Problem& problem) {
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

study::Answer answer_by_ipopt(const maneuver::Problem& problem, const maneuver::Solution& from) {
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.refinement = false;
  options.solver = search::Backend::ipopt;
  options.first = search::first_motion(system, problem, from);
  return study::answer(system, problem, options);
}

// Where joints have to end bent and nothing else is asked for.
maneuver::Problem bending(const maneuver::Problem& from, const std::map<std::string, std::vector<double>>& angles) {
  maneuver::Problem problem = from;
  problem.goal->move = {};
  problem.goal->turn.reset();
  problem.goal->angle = angles;
  problem.start.rotation.assign(problem.swimmer.bodies.size(), Vector3d::Zero());
  problem.steps = 40;
  problem.effort = 1e-14;
  problem.cost_weights.angular_velocity = 1.0;
  return problem;
}

TEST(AngularVelocity, alone_is_cheapest_where_each_joint_turns_evenly) {
  const maneuver::Problem balls = chain_problem(40, 1.0),
                          hinges = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  for (const maneuver::Problem& problem : {bending(balls, {{balls.swimmer.joints[0].name, {0.7, -0.4, 0.9}},
                                                           {balls.swimmer.joints[1].name, {-0.3, 1.1, 0.2}}}),
                                           bending(hinges, {{"b1", {1.1}}, {"b2", {-0.6}}})}) {
    const study::Answer answer = answer_of(problem);
    ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    const std::vector<maneuver::Vectors>& angle = answer.solution.joint_angle;
    double squares = 0.0;
    for (std::size_t j = 0; j < angle.front().size(); ++j) {
      const Vector3d way = angle.back()[j] - angle.front()[j];  // of ball joints from 0, about one axis
      EXPECT_GT(way.norm(), 0.5);
      squares += way.squaredNorm();
      for (std::size_t k = 0; k < angle.size(); ++k)
        EXPECT_LT((angle[k][j] - angle.front()[j] - static_cast<double>(k) / problem.steps * way).norm(), 1e-3) << k;
    }
    const double least = 0.5 * squares / problem.duration.value;
    EXPECT_NEAR(answer.solution.cost_parts->angular_velocity, least, tolerance(1e-6) * least);
  }
}

TEST(AngularVelocity, has_ipopt_stay_at_the_answers_of_newtons_method) {
  for (const bool free_duration : {false, true}) {
    maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/translation.toml");
    problem.steps = 60;
    problem.search.starts = 1;
    problem.cost_weights.angular_velocity = 3e3;
    if (free_duration) {
      problem.duration = {.free = true, .value = 1.0, .min = 0.5, .max = 3.0};
      problem.time_weight = 3e5;
    }
    const study::Answer ours = answer_of(problem), by_ipopt = answer_by_ipopt(problem, ours.solution);
    EXPECT_EQ(ours.certificate.verdict, certificate::Verdict::proved) << ours.solution.message;
    EXPECT_EQ(by_ipopt.certificate.verdict, certificate::Verdict::proved) << by_ipopt.solution.message;
    EXPECT_NEAR(by_ipopt.solution.cost / ours.solution.cost, 1.0, 1e-8);
    const maneuver::CostParts &one = *ours.solution.cost_parts, &other = *by_ipopt.solution.cost_parts;
    EXPECT_NEAR(other.angular_velocity / one.angular_velocity, 1.0, 1e-6);
    EXPECT_GT(3e3 * one.angular_velocity, 0.05 * ours.solution.cost) << "hardly weighs anything";
  }
}

// Effort alone has the fin of 40 g beside 15 kg whirl as fast as steps show.
TEST(AngularVelocity, ends_searches_that_light_bodies_keep_from_an_end) {
  const maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/light_fin.toml");
  const study::Answer answer = answer_of(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

}  // namespace
}  // namespace lamprey::tests
