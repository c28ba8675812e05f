// Searches that are made to stop end with what there is, or with the exception of who stops them.
#include <gtest/gtest.h>

#include <thread>

#include "file/problem_file.hpp"
#include "search/budget.hpp"
#include "search/method.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Problem;

Problem translation(int steps) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.steps = steps;
  problem.search.starts = 4;
  return problem;
}

TEST(StoppedSearch, ends_with_an_exception_of_its_threads_whatever_their_number) {
  const Problem problem = translation(20);
  const model::System system(problem.swimmer);
  for (int workers : {1, 2, 4}) {
    search::SolveOptions options;
    options.workers = workers;
    options.progress = [](const std::string&) { throw std::out_of_range("told"); };
    EXPECT_THROW(search::solve(system, problem, options), std::out_of_range) << workers << " workers";
  }
}

// Guesses that were not tried might have been motions: "stalled" would say that none is.
TEST(StoppedSearch, without_a_motion_says_what_ended_it) {
  const Problem problem = translation(20);
  for (const bool interrupted : {true, false}) {
    search::SolveOptions options;
    options.interrupted = [&] { return interrupted; };
    const search::Budget budget(problem, options);
    optimizer::Outcome outcome;
    budget.tell_what_ended(outcome);
    EXPECT_EQ(outcome.termination,
              interrupted ? optimizer::Termination::interrupted : optimizer::Termination::time_limit);
    EXPECT_NE(outcome.reason.find("before a motion was found"), std::string::npos);
    outcome.termination = optimizer::Termination::infeasible;
    budget.tell_what_ended(outcome);
    EXPECT_EQ(outcome.termination, optimizer::Termination::infeasible);
  }
}

// Few steps found something that all steps do not carry: that is no motion, nor is a first guess.
TEST(StoppedSearch, without_a_motion_shows_one_without_moments) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/u_turn_within_limits.toml");
  problem.search.time_limit.reset();
  int shown = 0;
  for (const int asked_before : {1000, 2000}) {
    int asked = 0;
    search::SolveOptions options;
    options.interrupted = [&] { return ++asked > asked_before; };
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.solution.status, maneuver::Status::interrupted);
    EXPECT_LE(answer.certificate.equation_residual, answer.certificate.equation_allowed()) << answer.solution.message;
    shown += answer.solution.message.find("what is shown has no moments") != std::string::npos;
  }
  EXPECT_GE(shown, 1);
}

// An answer whose search shall stop once it tells of a line, by interruption or because that takes all its time.
struct StoppedAt {
  std::vector<std::string> told;
  study::Answer answer;

  StoppedAt(const Problem& problem, const std::string& line, int workers = 1, double times_limit = 1.0) {
    bool stop = false;
    search::SolveOptions options;
    options.workers = workers;
    options.refinement = true;
    options.interrupted = [&] { return stop; };
    options.progress = [&](const std::string& said) {
      told.push_back(said);
      if (said != line) return;
      if (problem.search.time_limit)
        std::this_thread::sleep_for(std::chrono::duration<double>(times_limit * *problem.search.time_limit));
      else
        stop = true;
    };
    answer = study::answer(model::System(problem.swimmer), problem, options);
  }
  auto times(const std::string& line) const { return std::count(told.begin(), told.end(), line); }
  bool says(const std::string& words) const { return answer.solution.message.find(words) != std::string::npos; }
};

bool has_feedback(const study::Answer& answer) { return !answer.solution.feedback.gain.empty(); }

TEST(StoppedSearch, that_may_go_on_to_its_end_has_every_part) {
  const StoppedAt never(translation(40), "never");
  EXPECT_EQ(never.answer.solution.status, maneuver::Status::optimal);
  EXPECT_GE(never.times("certifying"), 2) << "another example is needed for these tests";
  EXPECT_TRUE(never.answer.certificate.second_order && never.answer.certificate.all_axes);
  EXPECT_TRUE(never.answer.certificate.refinement);
  EXPECT_TRUE(has_feedback(never.answer));
  EXPECT_FALSE(never.says("not computed"));
}

TEST(StoppedSearch, that_goes_on_to_its_end_has_the_same_parts_side_by_side) {
  const study::Answer alone = StoppedAt(translation(40), "never").answer;
  const study::Answer beside = StoppedAt(translation(40), "never", 3).answer;
  EXPECT_EQ(beside.solution.message, alone.solution.message);
  EXPECT_EQ(beside.certificate.second_order->smallest_eigenvalue, alone.certificate.second_order->smallest_eigenvalue);
  EXPECT_EQ(beside.certificate.replay->rotation_error, alone.certificate.replay->rotation_error);
  EXPECT_EQ(beside.certificate.replay->feedback_rotation_error, alone.certificate.replay->feedback_rotation_error);
  EXPECT_EQ(beside.certificate.refinement->cost_half_step, alone.certificate.refinement->cost_half_step);
  EXPECT_EQ(beside.solution.feedback.gain, alone.solution.feedback.gain);
}

TEST(StoppedSearch, certifies_what_it_has_and_begins_nothing_more_once_it_is_interrupted) {
  const StoppedAt first(translation(40), "certifying");
  EXPECT_EQ(first.answer.solution.status, maneuver::Status::interrupted);
  EXPECT_LE(first.answer.certificate.goal_error, evidence::goal_mark);
  EXPECT_LE(first.answer.certificate.kkt, 1e-8);
  EXPECT_EQ(first.times("certifying"), 1);
  EXPECT_EQ(first.times("proving") + first.times("on other grids"), 0);
  EXPECT_FALSE(first.answer.certificate.second_order || first.answer.certificate.refinement);
  EXPECT_FALSE(has_feedback(first.answer));
  EXPECT_TRUE(
      first.says("Since it was interrupted, these were not computed: the certificate of another candidate, "
                 "whether it is a minimum, feedback, its cost on other grids."))
      << first.answer.solution.message;
}

// What one of several answers lacks is told of that one.
TEST(StoppedSearch, says_of_each_answer_what_it_lacks) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/rotation.toml");
  problem.steps = 100;
  problem.search.starts = 6;
  problem.search.keep = 3;
  bool stop = false, proving = false;
  search::SolveOptions options;
  options.refinement = false;
  options.workers = 1;
  options.interrupted = [&] { return stop; };
  options.progress = [&](const std::string& line) {
    stop = stop || (proving && line == "proving");  // the second answer's
    proving = proving || line == "proving";
  };
  const study::Answer best = study::answer(model::System(problem.swimmer), problem, options);
  const auto lacks = [](const study::Answer& answer) {
    return answer.solution.message.find("these were not computed") != std::string::npos;
  };
  ASSERT_TRUE(stop);
  ASSERT_FALSE(best.others.empty());
  EXPECT_FALSE(lacks(best)) << best.solution.message;
  EXPECT_EQ(best.solution.status, maneuver::Status::interrupted);
  EXPECT_TRUE(best.certificate.second_order && has_feedback(best));
  EXPECT_TRUE(lacks(best.others.front())) << best.others.front().solution.message;
  EXPECT_EQ(best.others.front().solution.status, maneuver::Status::interrupted);
  EXPECT_FALSE(has_feedback(best.others.front()));
}

// A motion on a coarse grid is no answer: the best that was found is carried on to all steps, however the search ends.
TEST(StoppedSearch, carries_the_best_motion_on_to_its_steps) {
  for (const search::Backend solver : {search::Backend::newton, search::Backend::ipopt})
    for (const std::optional<double> limit : {std::optional<double>(), std::optional(4.0)}) {
      Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
      problem.search.starts = 100'000;
      problem.search.time_limit = limit;
      problem.steps = solver == search::Backend::newton ? 1000 : 40;
      search::SolveOptions options;
      options.solver = solver;
      options.refinement = false;
      bool begun = false;  // whether a first guess has been solved
      options.progress = [&](const std::string& line) { begun = begun || line.starts_with("first guess "); };
      options.interrupted = [&] { return !limit && begun; };
      const study::Answer stopped = study::answer(model::System(problem.swimmer), problem, options);
      const std::string& message = stopped.solution.message;
      EXPECT_LE(stopped.certificate.kkt, 1e-8) << message;
      EXPECT_LE(stopped.certificate.goal_error, evidence::goal_mark) << message;
      EXPECT_EQ(stopped.solution.status, limit ? maneuver::Status::optimal : maneuver::Status::interrupted) << message;
      EXPECT_GE(stopped.solution.search.solved, 1);
      EXPECT_EQ(message.find("these were not tried: " + std::to_string(100'000 - stopped.solution.search.starts) +
                             " of 100000 first guesses") == std::string::npos,
                false)
          << message;
      if (limit) {  // within it, on slow machines too
        const bool untold = message.find("whether it is a minimum") == std::string::npos;
        if (solver == search::Backend::newton ||
            untold) {  // Ipopt may leave too little time for the proof, and says so
          EXPECT_EQ(stopped.certificate.verdict, certificate::Verdict::proved) << message;
        }
        EXPECT_LT(stopped.solution.solver.wall_seconds, *limit);
      }
    }
}

// A guess that runs when another one arrives has no more time than those that come after it.
TEST(StoppedSearch, ends_guesses_that_run_sooner_once_one_has_arrived) {
  Problem problem = translation(200);
  const search::SolveOptions options;
  search::Budget budget(problem, options);
  budget.enter(search::Budget::Stage::guessing);
  while (budget.seconds() < 0.3) continue;
  problem.search.time_limit = 1.4 * budget.seconds();  // of which more than two thirds are over
  const optimizer::Options running = budget.optimizer_options(100, 1e-8);
  EXPECT_FALSE(running.late(0.0));
  budget.arrived();
  EXPECT_TRUE(running.late(0.0));
}

// Moments on splines begin with moments free at each node: what looks for these is on the way to a first guess, too.
TEST(StoppedSearch, ends_what_a_guess_begins_with_when_the_guess_ends) {
  Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/chain_of_seven_turns.toml");
  problem.control = maneuver::ControlKind::spline;
  problem.points = 11;
  problem.search.hops = 1;
  problem.search.time_limit = 3.0;  // of which guesses have a third once one has arrived
  const model::System system(problem.swimmer);
  search::SolveOptions options;
  options.workers = 1;
  search::Budget budget(problem, options);
  const std::unique_ptr<search::Method> method = search::ipopt_method(system, problem, options, budget);
  budget.enter(search::Budget::Stage::guessing);
  budget.arrived();
  const search::Found found = method->solve_starts(0, 1).front();
  ASSERT_FALSE(found.converged()) << "another problem is needed for this test";
  EXPECT_LT(budget.seconds(), 2.0);
}

// What a search has when it ends may be no motion, and have no multipliers: its numbers are some all the same.
TEST(StoppedSearch, by_either_solver_and_for_any_cost_has_numbers_alone) {
  constexpr double seconds = 0.25;
  const auto is_number = [](const std::vector<double>& all) {
    return std::all_of(all.begin(), all.end(), [](double one) { return std::isfinite(one); });
  };
  const std::vector<std::pair<const char*, maneuver::CostWeights>> costs = {
      {"effort", {}},
      {"work", {.work = 1.0}},
      {"power", {.power = 1.0}},
      {"smoothness", {.smoothness = 1e-3}},
      {"angular velocity", {.angular_velocity = 1e-3}},
      {"transport", {.transport = 1.0}},
      {"displacement", {.displacement = {0.1, 0.0, 0.0}}}};
  int stopped = 0;
  for (const search::Backend solver : {search::Backend::newton, search::Backend::ipopt})
    for (const bool interrupted : {false, true})
      for (const auto& [cost, weights] : costs) {
        Problem problem =
            file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/gait_at_least_transport_50.toml");
        problem.search.starts = 1;
        problem.cost_weights = weights;
        if (weights.of_displacement()) problem.goal->move[0].reset();
        if (!interrupted) problem.search.time_limit = seconds;
        search::SolveOptions options;
        options.solver = solver;
        options.refinement = false;
        options.interrupted = [&, begin = std::chrono::steady_clock::now()] {
          return interrupted && std::chrono::steady_clock::now() - begin > std::chrono::duration<double>(seconds);
        };
        std::string told;
        options.progress = [&](const std::string& line) { told += line; };
        const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
        const std::string which = std::string(cost) +
                                  (solver == search::Backend::ipopt ? " by Ipopt " : " by Newton ") +
                                  answer.solution.message;
        EXPECT_TRUE(std::isfinite(answer.solution.cost)) << which;
        EXPECT_EQ(answer.solution.message.find("nan"), std::string::npos) << which;
        EXPECT_EQ(told.find("nan"), std::string::npos) << told;
        for (const auto& own : answer.solution.limit_multipliers) EXPECT_TRUE(is_number(own.multiplier)) << which;
        for (const auto& own : answer.solution.work_multipliers) EXPECT_TRUE(is_number(own)) << which;
        for (const auto& own : answer.solution.work_change_multipliers) EXPECT_TRUE(is_number(own)) << which;
        if (solver == search::Backend::newton) continue;  // which may have come to its end
        if (answer.certificate.goal_error <= evidence::goal_mark && answer.certificate.kkt <= 1e-8) continue;
        ++stopped;
        EXPECT_EQ(answer.solution.status, interrupted ? maneuver::Status::interrupted : maneuver::Status::time_limit)
            << which;
      }
  EXPECT_GT(stopped, 0) << "all were solved in time";
}

TEST(StoppedSearch, leaves_time_for_hops) {
  Problem problem = translation(200);
  problem.search.starts = 100'000;
  problem.search.hops = 100'000;
  problem.search.time_limit = 3.0;  // of which a third is for all steps and the proof, on slow machines too
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer stopped = study::answer(model::System(problem.swimmer), problem, options);
  EXPECT_GE(stopped.solution.search.hops, 8);
  EXPECT_NE(stopped.solution.message.find(" of 100000 hops"), std::string::npos) << stopped.solution.message;
  EXPECT_EQ(stopped.certificate.verdict, certificate::Verdict::proved) << stopped.solution.message;
}

// Within its starts: of those that began the one that came nearest, a motion in all cases.
TEST(StoppedSearch, has_the_best_motion_of_the_starts_that_began) {
  const StoppedAt second(translation(1000), "first guess 2 of 4");
  EXPECT_EQ(second.answer.solution.status, maneuver::Status::interrupted);
  EXPECT_EQ(second.answer.solution.search.starts, 2);
  EXPECT_EQ(second.answer.solution.search.solved, 2);
  for (const char* example : {"rotation_with_clearance", "rotation", "least_work"})
    for (const int allowed : {0, 3, 10, 30}) {
      Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + example + ".toml");
      problem.steps = 200;
      problem.search.starts = 8;
      problem.search.hops = 0;
      int asked = 0;
      search::SolveOptions options;
      options.interrupted = [&] { return asked++ >= allowed; };
      const study::Answer stopped = study::answer(model::System(problem.swimmer), problem, options);
      EXPECT_EQ(stopped.solution.status, maneuver::Status::interrupted) << example << " after " << allowed;
      EXPECT_LE(stopped.certificate.equation_residual, evidence::equation_mark) << example << " after " << allowed;
      EXPECT_GT(stopped.solution.cost, 0.0);
      for (const auto& own : stopped.solution.limit_multipliers) EXPECT_EQ(own.multiplier.size(), 201U);
      for (const auto& own : stopped.solution.work_multipliers) EXPECT_EQ(own.size(), 201U);
    }
}

TEST(StoppedSearch, leaves_out_what_follows_the_part_at_which_it_is_interrupted) {
  const StoppedAt proving(translation(40), "proving");
  EXPECT_EQ(proving.answer.solution.status, maneuver::Status::interrupted);
  EXPECT_TRUE(proving.answer.certificate.second_order);
  EXPECT_FALSE(proving.answer.certificate.all_axes || proving.answer.certificate.refinement);
  EXPECT_FALSE(has_feedback(proving.answer));
  const StoppedAt refining(translation(40), "on other grids");
  EXPECT_EQ(refining.answer.solution.status, maneuver::Status::interrupted);
  EXPECT_TRUE(refining.answer.certificate.all_axes);
  EXPECT_FALSE(refining.answer.certificate.refinement);
  EXPECT_TRUE(has_feedback(refining.answer));
  EXPECT_TRUE(refining.says("these were not computed: its cost on other grids.")) << refining.answer.solution.message;
}

TEST(StoppedSearch, proves_the_best_and_finds_its_feedback_for_a_while_after_its_time) {
  Problem problem = translation(40);
  problem.search.time_limit = 2.0;
  const StoppedAt late(problem, "certifying");
  EXPECT_EQ(late.answer.solution.status, maneuver::Status::optimal);
  EXPECT_EQ(late.times("certifying"), 1);
  EXPECT_EQ(late.answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_TRUE(has_feedback(late.answer));
  EXPECT_FALSE(late.answer.certificate.refinement);
  EXPECT_TRUE(late.says("Since the time limit was reached")) << late.answer.solution.message;
}

TEST(StoppedSearch, stays_optimal_without_the_parts_that_its_time_does_not_reach) {
  Problem problem = translation(40);
  problem.search.time_limit = 0.7;
  const StoppedAt late(problem, "certifying", 1, 2.0);
  EXPECT_EQ(late.answer.solution.status, maneuver::Status::optimal);
  EXPECT_EQ(late.times("certifying"), 1);
  EXPECT_FALSE(late.answer.certificate.second_order || late.answer.certificate.refinement);
  EXPECT_EQ(late.answer.certificate.verdict, certificate::Verdict::stationary);
  EXPECT_FALSE(has_feedback(late.answer));
  EXPECT_TRUE(late.says("Since the time limit was reached")) << late.answer.solution.message;
}

}  // namespace
}  // namespace lamprey::tests
