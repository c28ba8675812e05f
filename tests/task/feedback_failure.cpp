#include <gtest/gtest.h>

#include "chains.hpp"
#include "file/samples.hpp"
#include "model/input_error.hpp"
#include "result/followed_file.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "task/tasks.hpp"

namespace lamprey {
namespace {

using Eigen::MatrixXd;

// A maneuver of the paper's chain that lasts a second, with gains.
result::Results maneuver_of_chain() {
  result::Results results = tests::sample_results(4);
  maneuver::Problem problem;
  problem.swimmer = tests::paper_chain();
  problem.steps = 4;
  results.problem = result::resolve(model::System(problem.swimmer), problem);
  for (std::size_t k = 0; k < 5; ++k) results.solution.time[k] = 0.25 * static_cast<double>(k);
  results.solution.feedback.time = {0.0, 1.0};
  results.solution.feedback.gain.assign(2, MatrixXd::Ones(6, 24));
  return results;
}

std::string told(const std::string& folder, const model::SwimmerDescription& follower, double duration,
                 double from = 0.0) {
  try {
    result::require_followed(result::read_solution(folder), folder + "/solution.json", model::System(follower), from,
                             duration);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FollowedManeuver, is_taken_by_its_own_swimmer_whatever_that_weighs) {
  const tests::TemporaryFolder folder;
  result::write_solution(folder.path(), maneuver_of_chain());
  model::SwimmerDescription heavy = tests::paper_chain();
  *heavy.bodies[1].inertia_matrix *= 1.3;
  EXPECT_EQ(told(folder.path(), heavy, 1.0), "");
}

TEST(FollowedManeuver, says_in_one_line_what_does_not_fit_and_what_would) {
  const tests::TemporaryFolder folder;
  result::Results results = maneuver_of_chain();
  result::write_solution(folder.path(), results);
  const std::string place = folder / "solution.json: ";
  model::SwimmerDescription two = tests::paper_chain();
  two.bodies.resize(2);
  two.joints.resize(1);
  EXPECT_EQ(told(folder.path(), two, 1.0),
            place +
                "/problem/bodies: found 3 bodies; allowed: 2, as the problem's swimmer has; choose a "
                "motion of the same swimmer");
  model::SwimmerDescription hinged = tests::paper_chain();
  hinged.joints[1].kind = model::JointKind::hinge;
  hinged.joints[1].axis = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(told(folder.path(), hinged, 1.0),
            place +
                "/problem/joints/1: found a ball joint from body 0 to body 2; allowed: a hinge joint from body 0 to "
                "body 2, as the problem's swimmer has; choose a motion of the same swimmer");
  EXPECT_EQ(told(folder.path(), tests::paper_chain(), 1.5),
            place +
                "/problem/duration: found 1 s, where the march takes 1.5 s; allowed: a maneuver that does not end "
                "before the march; set a shorter --duration");
  EXPECT_EQ(told(folder.path(), tests::paper_chain(), 0.7, 0.25), "");
  EXPECT_EQ(told(folder.path(), tests::paper_chain(), 0.8, 0.25),
            place +
                "/problem/duration: found 1 s, where the march takes 0.8 s from 0.25 s on; allowed: a maneuver that "
                "does not end before the march; set a shorter --duration, or leave it out");
  results.problem.goal = maneuver::Goal();
  results.problem.goal->periodic = true;
  result::write_solution(folder.path(), results);
  EXPECT_EQ(told(folder.path(), tests::paper_chain(), 0.7, 0.25),
            place +
                "/problem/goal: found a gait, where the march begins at 0.25 s of it; allowed: a maneuver, since gaits "
                "begin where they close; leave --feedback-from out");
  results.solution.feedback = {};
  result::write_solution(folder.path(), results);
  EXPECT_EQ(
      told(folder.path(), tests::paper_chain(), 1.0),
      place +
          "/feedback: found no gains; allowed: those that lamprey solve stores with optimal maneuvers; solve "
          "the maneuver again to its end: a search that was interrupted, or ended by its time limit, may leave none");
}

TEST(FollowedManeuver, of_more_or_fewer_joints_is_refused) {
  const model::System swimmer(tests::paper_chain());
  const auto refused = [&](const result::Results& results) -> std::string {
    try {
      result::require_same_tree(results, "solution.json", swimmer, true);
    } catch (const model::InputError& error) {
      return error.what();
    }
    return "";
  };
  result::Results results = maneuver_of_chain();
  EXPECT_EQ(refused(results), "");
  results.problem.joints.push_back(results.problem.joints.back());
  EXPECT_NE(refused(results).find("found 3 joints; allowed: 2"), std::string::npos) << refused(results);
  results.problem.joints.resize(1);
  EXPECT_NE(refused(results).find("found 1 joints; allowed: 2"), std::string::npos) << refused(results);
}

// A gait of no nodes, which a file may hold, is nothing that could be repeated.
TEST(FollowedManeuver, without_a_motion_has_no_cycles) {
  result::Results empty = maneuver_of_chain();
  empty.problem.goal = maneuver::Goal();
  empty.problem.goal->periodic = true;
  empty.solution = maneuver::Solution();
  file::ProblemFile asked;
  asked.path = "p.toml";
  asked.problem.swimmer = tests::paper_chain();
  const task::MarchOptions options{.cycles = 2, .followed = empty, .followed_path = "gait/solution.json"};
  try {
    task::march_task(asked, options, "");
    FAIL() << "was marched";
  } catch (const model::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("found no motion in gait/solution.json"), std::string::npos)
        << error.what();
  }
}

TEST(FeedbackReader, tells_the_place_of_a_wrong_shape) {
  result::Results results = maneuver_of_chain();
  const auto refusal = [&] {
    try {
      result::parse_solution(result::solution_text(results), "solution.json");
    } catch (const model::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal(), "");
  results.problem.joints[1].control_axes.pop_back();
  EXPECT_THROW(result::solution_text(results), std::domain_error);
  results = maneuver_of_chain();
  results.solution.feedback.time = {0.5, 0.5};
  EXPECT_NE(refusal().find("solution.json: /feedback/time/1: found 0.5; allowed: times that rise (s)"),
            std::string::npos)
      << refusal();
  results = maneuver_of_chain();
  const std::string text = result::solution_text(results);
  const std::string key = "\"gain\": [\n      [[";
  const std::size_t at = text.find(key);
  ASSERT_NE(at, std::string::npos);
  std::string longer = text;
  longer.insert(at + key.size(), "7, ");
  try {
    result::parse_solution(longer, "solution.json");
    FAIL() << "a row of 25 was read";
  } catch (const model::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/feedback/gain/0/0"), std::string::npos) << error.what();
  }
  results.solution.feedback.gain[1](3, 5) = std::nan("");
  EXPECT_THROW(result::solution_text(results), std::domain_error);
}

}  // namespace
}  // namespace lamprey
