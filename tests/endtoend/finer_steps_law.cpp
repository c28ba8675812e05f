// What is said of an answer whose search on more steps could not be finished.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include <fmt/format.h>

#include "program.hpp"
#include "search/budget.hpp"
#include "task/finer_steps.hpp"

namespace lamprey::tests {
namespace {

// The problem on few steps, without a look at other grids.
file::ProblemFile few_steps(const Folder& folder) {
  file::ProblemFile file =
      file::read_problem_file(varied_example(folder, "rotation", {{"steps", "60"}, {"starts", "4"}}));
  file.problem.search.hops = file.problem.search.whole_turns = 0;
  return file;
}

// Once a line of progress holds `word` it happens, before the next line.
struct Once {
  std::string word;
  std::function<void()> happens;
  void operator()(const std::string& line) {
    if (line.find(word) != std::string::npos && happens) std::exchange(happens, {})();
  }
};

// s: several times what the first look takes here.
double limit_of(const file::ProblemFile& file) {
  const auto begin = std::chrono::steady_clock::now();
  search::SolveOptions options;
  options.refinement = false;
  task::solve_task(file, options, "test");
  return std::ceil(3.0 + 5.0 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
}

// Also the time by which the best motion is refined late.
void wait_until_over(double limit) {
  std::this_thread::sleep_for(std::chrono::duration<double>(1.1 * search::late_share * limit));
}

result::Results resolved(const file::ProblemFile& file, const std::function<void(const std::string&)>& progress,
                         const std::function<bool()>& interrupted = {}) {
  search::SolveOptions options;
  options.refinement = false;
  options.progress = progress;
  options.interrupted = interrupted;
  return task::resolve_task(file, options, "test");
}

void expect_first_look(const result::Results& results, const file::ProblemFile& file, const std::string& words,
                       maneuver::Status status = maneuver::Status::optimal) {
  EXPECT_EQ(results.problem.steps, file.problem.steps);
  EXPECT_EQ(results.solution.status, status);
  EXPECT_NE(results.solution.message.find(words), std::string::npos) << results.solution.message;
}

TEST(FinerSteps, that_time_left_no_room_for_are_named) {
  const Folder folder;
  file::ProblemFile file = few_steps(folder);
  const double limit = limit_of(file);
  file.problem.search.time_limit = limit;
  const result::Results before = resolved(file, Once{"not all of it is resolved", [limit] { wait_until_over(limit); }});
  expect_first_look(before, file, " steps were not tried: the time was over (search.time_limit).");
  const auto within = [limit, begun = false](const std::string& line) mutable {
    if (begun && line.find("first guess 1") != std::string::npos) wait_until_over(limit);
    begun = begun || line.find("not all of it is resolved") != std::string::npos;
  };
  expect_first_look(resolved(file, within), file,
                    fmt::format(" steps arrived: give it more than {:.0f} s (search.time_limit).", limit));
}

TEST(FinerSteps, that_an_interruption_left_undone_are_named_without_a_time_limit) {
  const Folder folder;
  const file::ProblemFile file = few_steps(folder);
  bool stop = false;
  const result::Results before =
      resolved(file, Once{"not all of it is resolved", [&stop] { stop = true; }}, [&stop] { return stop; });
  expect_first_look(before, file, " steps were not tried: it was interrupted.", maneuver::Status::interrupted);
  stop = false;
  bool begun = false;
  const auto within = [&](const std::string& line) {
    stop = stop || (begun && line.find("first guess 1") != std::string::npos);
    begun = begun || line.find("not all of it is resolved") != std::string::npos;
  };
  expect_first_look(resolved(file, within, [&stop] { return stop; }), file, " It was interrupted before the search on ",
                    maneuver::Status::interrupted);
}

// It is dropped where one minimum is asked for, but not in silence.
TEST(FinerSteps, that_a_cheaper_motion_needs_are_told_with_the_answer) {
  const file::ProblemFile file =
      file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/furthest_of_two_arms.toml");
  for (const std::string word : {"not all of it is resolved", "refined"}) {
    bool stop = false, begun = false;
    const auto progress = [&](const std::string& line) {
      begun = begun || line.find("not all of it is resolved") != std::string::npos;
      stop = stop || (begun && line.find(word) != std::string::npos);
    };
    const result::Results results = resolved(file, progress, [&stop] { return stop; });
    ASSERT_TRUE(stop);
    EXPECT_EQ(results.problem.steps, file.problem.steps);
    const std::string& message = results.solution.message;
    const std::size_t found = message.find(" A cheaper motion (cost ");
    ASSERT_NE(found, std::string::npos) << message;
    EXPECT_NE(message.find("interrupted", found), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace lamprey::tests
