// Numbers of a stored answer that do not follow from its others are told.
#include "task/stored_statements.hpp"

#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "evidence/clearance.hpp"
#include "file/problem_file.hpp"
#include "file/samples.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "task/tasks.hpp"

namespace lamprey::tests {
namespace {

using result::Results;

// A hinged swimmer's gait with its gains.
const Results& solved() {
  static const Results results = [] {
    file::ProblemFile file =
        file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/gait_within_limits.toml");
    file.problem.steps = 40;
    file.problem.search.starts = 1;
    for (model::JointDescription& joint : file.problem.swimmer.joints) {
      joint.kind = model::JointKind::hinge;
      joint.axis = {0.0, 0.0, 1.0};
      joint.control_axes.reset();
    }
    file.problem.limits = {};
    search::SolveOptions options;
    options.refinement = false;
    return task::solve_task(file, options, "");
  }();
  return results;
}

std::string false_field(const std::function<void(Results&)>& change) {
  Results stored = solved();
  change(stored);
  const auto claims = task::false_statements(stored, solved(), true);
  return claims.empty() ? "" : claims.front().field;
}

TEST(StoredStatements, of_an_answer_as_it_was_found_are_true) {
  ASSERT_EQ(solved().solution.status, maneuver::Status::optimal) << solved().solution.message;
  ASSERT_FALSE(solved().solution.feedback.gain.empty());
  EXPECT_EQ(false_field([](Results&) {}), "");
}

// No file shows the solver's way again; but an optimal answer does not tell of momentum that leaked there.
TEST(StoredStatements, of_momentum_that_leaked_on_the_way_refute_an_optimal_answer) {
  const auto verified = [](double in_history, double in_certificate, maneuver::Status status) {
    const TemporaryFolder folder;
    Results stored = solved();
    stored.solution.status = status;
    if (in_history > 0.0) stored.solution.solver.history.at(1).momentum = in_history;
    if (in_certificate > 0.0) stored.certificate->iterates_momentum = in_certificate;
    result::write_solution(folder.path(), stored);
    return task::verify_task(folder.path(), {});
  };
  constexpr auto optimal = maneuver::Status::optimal;
  EXPECT_TRUE(verified(0.0, 0.0, optimal).holds());
  for (const auto& [in_history, in_certificate] : {std::pair(5.0, 5.0), std::pair(5.0, 0.0), std::pair(0.0, 5.0)}) {
    const task::Verification leaking = verified(in_history, in_certificate, optimal);
    EXPECT_FALSE(leaking.status_holds);
    EXPECT_NE(leaking.fault.find("total momentum up to 5 of its scale, allowed 1e-11"), std::string::npos)
        << leaking.fault;
  }
  EXPECT_TRUE(verified(5.0, 5.0, maneuver::Status::feasible).holds());
}

// A march that was interrupted before its first step.
TEST(StoredStatements, of_a_single_node_are_true) {
  Results one = solved();
  one.solution = {};
  one.solution.status = maneuver::Status::interrupted;
  one.solution.time = {0.0};
  one.problem.steps = 0;
  one.problem.duration = one.problem.time_step = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(task::false_statements(one, one, false).empty());
}

TEST(StoredStatements, that_follow_from_the_problem_are_told_where_they_do_not) {
  EXPECT_EQ(false_field([](Results& r) {
              r.problem.joints[0].control_axes[0] = {0.6, 0.8, 0.0};
            }),
            "problem.joints[0].control_axes[0][0]");
  EXPECT_EQ(false_field([](Results& r) { r.problem.time_step *= 1.5; }), "problem.time_step");
}

// Ellipsoids and ellipses; of matrices that somebody may have given nothing is known.
TEST(StoredStatements, of_the_density_are_told_where_the_matrices_of_all_bodies_have_another) {
  for (const char* name : {"/examples/ellipses.toml", "/bench/problems/three_hinges.toml"}) {
    task::MarchOptions options;
    options.steps = 4;
    const Results marched =
        task::march_task(file::read_problem_file(LAMPREY_SOURCE_DIR + std::string(name)), options, "");
    const auto claims = [&](double times, const std::function<void(Results&)>& change) {
      Results stored = marched;
      *stored.problem.density *= times;
      change(stored);
      return task::false_statements(stored, marched, false);
    };
    EXPECT_TRUE(claims(1.0, [](Results&) {}).empty()) << name;
    for (const double times : {0.9, 1.0 + 1e-6, 20.0}) {
      const auto told = claims(times, [](Results&) {});
      ASSERT_EQ(told.size(), 1U) << name;
      EXPECT_EQ(told[0].field, "problem.density");
      EXPECT_NEAR(told[0].found, *marched.problem.density, 1e-9 * *marched.problem.density);
    }
    const auto given = [](Results& r) { r.problem.bodies[1].mass_matrix *= 1.001; };
    EXPECT_TRUE(claims(0.9, given).empty()) << "the matrices may all be given";
  }
}

TEST(StoredStatements, of_feedback_are_told_where_its_times_or_gains_are_others) {
  EXPECT_EQ(false_field([](Results& r) { r.solution.feedback.time.back() *= 2.0; }), "feedback.time[40]");
  EXPECT_EQ(false_field([](Results& r) { r.solution.feedback.gain[3] *= 1.01; }).substr(0, 16), "feedback.gain[3]");
  // by each of its units, however small its numbers are beside the others: turns, ways, rates
  const auto half = solved().solution.feedback.gain[3].cols() / 2;
  for (const auto& [first, count] : {std::pair(Eigen::Index{0}, half - 3), {half - 3, Eigen::Index{3}}, {half, half}})
    EXPECT_EQ(false_field([first, count](Results& r) {
                r.solution.feedback.gain[3].middleCols(first, count) *= 1.01;
              }).substr(0, 16),
              "feedback.gain[3]")
        << first;
}

TEST(StoredStatements, of_a_search_are_told_where_they_contradict_each_other) {
  const auto& minima = solved().solution.search.minima;
  ASSERT_FALSE(minima.empty());
  EXPECT_EQ(false_field([](Results& r) { r.solution.search.minima[0].cost *= -1.0; }), "search.minima[0].cost");
  EXPECT_EQ(false_field([](Results& r) { r.solution.search.minima[0].cost = 0.0; }), "search.minima[0].cost");
  EXPECT_EQ(false_field([&](Results& r) {
              r.solution.search.minima.push_back({0.5 * minima.back().cost, 1});
            }),
            "search.minima[" + std::to_string(minima.size()) + "].cost");
  EXPECT_EQ(false_field([](Results& r) {
              r.solution.search.set_aside = {1.1 * r.solution.cost, {}};
            }),
            "search.set_aside.cost");
  EXPECT_EQ(false_field([](Results& r) { r.solution.search.set_aside = {0.9 * r.solution.cost, {}}; }), "");
  const auto grids = [](std::vector<certificate::GridCost> told) {
    return false_field([&](Results& r) {
      r.certificate->refinement.emplace();
      r.certificate->refinement->grids = std::move(told);
    });
  };
  EXPECT_EQ(grids({{20, 1.0}, {40, 1.0}, {80, 1.0}, {160, 1.0}}), "");
  EXPECT_EQ(grids({{20, 1.0}, {40, 1.0}, {81, 1.0}}), "refinement.grids[2].steps");
}

// Of equal gaps the other one is as true.
TEST(StoredStatements, of_where_bodies_come_nearest_are_told_unless_their_gap_is_there) {
  ASSERT_TRUE(solved().certificate->clearance);
  const evidence::Clearance is = *solved().certificate->clearance;
  const auto told = [](evidence::Clearance place) {
    return false_field([&](Results& r) { r.certificate->clearance = place; });
  };
  EXPECT_EQ(told(is), "");
  evidence::Clearance later = is;
  later.time += later.time > 0.5 * solved().solution.time.back() ? -0.3 : 0.3;
  EXPECT_EQ(told(later), "clearance.time");
  evidence::Clearance beyond = is;
  beyond.time = 2.0 * solved().solution.time.back();
  EXPECT_EQ(told(beyond), "clearance.time");
  evidence::Clearance ends = is;
  ends.first = 1, ends.second = 2;
  EXPECT_EQ(told(ends), is.first == 0 ? "clearance.bodies[0]" : "clearance.bodies[1]");
  // the end of a gait's cycle bends as its beginning does
  evidence::Clearance begun = is;
  begun.time = 0.0;
  const maneuver::Problem problem = result::problem_of(solved());
  const model::System system(problem.swimmer);
  const evidence::StoredMotion motion(system, problem, solved().solution);
  begun.gap = evidence::gap_at(motion, begun);
  evidence::Clearance ended = begun;
  ended.time = solved().solution.time.back();
  EXPECT_NEAR(evidence::gap_at(motion, ended), begun.gap, 1e-9);
  EXPECT_EQ(told(ended), "");
}

TEST(StoredStatements, of_which_limit_is_broken_most_are_told_unless_it_is) {
  file::ProblemFile file =
      file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/gait_within_limits.toml");
  file.problem.steps = 40;
  file.problem.search.starts = 1;
  file.problem.limits.torque = 1e9;
  search::SolveOptions options;
  options.refinement = false;
  const Results within = task::solve_task(file, options, "");
  ASSERT_TRUE(within.certificate && within.certificate->limits) << within.solution.message;
  const auto told = [&](const std::string& key, double time) {
    Results stored = within;
    stored.certificate->limits->violation = std::max(stored.certificate->limits->violation, 1e-12);
    stored.certificate->limits->key = key;
    stored.certificate->limits->time = time;
    const auto claims = task::false_statements(stored, within, false);
    return claims.empty() ? "" : claims.front().field;
  };
  const evidence::LimitsKept is = *within.certificate->limits;
  const double step = within.problem.time_step;
  EXPECT_EQ(told("limits.torque", 3.0 * step), "limits.key") << "far from its bound";
  EXPECT_EQ(told("limits.swing.nosuch", 3.0 * step), "limits.key");
  // what a limit is worth where it asks for nothing
  Results idle = within;
  ASSERT_FALSE(idle.solution.limit_multipliers.empty());
  EXPECT_TRUE(task::false_statements(idle, within, false).empty());
  const auto& pulls = idle.solution.limit_multipliers;
  const auto of_states = std::find_if(pulls.begin(), pulls.end(),
                                      [](const auto& own) { return own.key.find("torque") == std::string::npos; });
  ASSERT_NE(of_states, pulls.end());
  const auto place = static_cast<std::size_t>(of_states - pulls.begin());
  idle.solution.limit_multipliers[place].multiplier[0] = -1e12;
  const auto claims = task::false_statements(idle, within, false);
  ASSERT_FALSE(claims.empty());
  EXPECT_EQ(claims.front().field, "limit_multipliers[" + std::to_string(place) + "].multiplier[0]");
  ASSERT_FALSE(is.key.empty()) << "limits to round-off, some a little broken";
  EXPECT_EQ(told(is.key, is.time), "");
  EXPECT_EQ(told(is.key, is.time + 0.5 * step), "limits.time") << "between two nodes";
}

}  // namespace
}  // namespace lamprey::tests
