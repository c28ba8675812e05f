#include "search/workers.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace lamprey::tests {
namespace {

using Numbers = std::vector<double>;
using Results = std::vector<std::optional<Numbers>>;

// Task t gives t mod 4 numbers, of which some are not finite; tasks differ in how long they take.
Numbers numbers_of_task(int t) {
  if (t % 3 == 0) usleep(5000);
  Numbers numbers;
  for (int n = 0; n < t % 4; ++n) numbers.push_back(n == 2 ? INFINITY : std::sin(t + 0.1 * n));
  return numbers;
}

Results run(int count, int workers, const std::function<Numbers(int)>& task, std::vector<int>* told = nullptr) {
  return search::run_in_workers(count, workers, task, [told](int done, const auto&) {
    if (told) told->push_back(done);
  });
}

TEST(Workers, results_come_in_order_and_do_not_depend_on_the_number_of_workers) {
  constexpr int count = 13;
  for (int workers : {1, 2, 3, 13, 40}) {
    std::vector<int> told;
    const Results results = run(count, workers, numbers_of_task, &told);
    ASSERT_EQ(results.size(), 13U);
    for (int t = 0; t < count; ++t) {
      ASSERT_TRUE(results[static_cast<std::size_t>(t)]) << "task " << t << ", " << workers << " workers";
      EXPECT_EQ(*results[static_cast<std::size_t>(t)], numbers_of_task(t))
          << "task " << t << ", " << workers << " workers";
    }
    std::vector<int> expected;
    for (int done = 1; done <= count; ++done) expected.push_back(done);
    EXPECT_EQ(told, expected) << workers << " workers";
  }
}

TEST(Workers, each_result_is_told_once) {
  for (int workers : {1, 3}) {
    std::vector<double> told;
    search::run_in_workers(
        9, workers, [](int t) { return Numbers{static_cast<double>(t)}; },
        [&](int, const std::optional<Numbers>& numbers) { told.push_back(numbers.value().front()); });
    std::sort(told.begin(), told.end());
    EXPECT_EQ(told, Numbers({0, 1, 2, 3, 4, 5, 6, 7, 8})) << workers << " workers";
  }
}

TEST(Workers, long_results_arrive_whole) {
  const auto task = [](int t) { return Numbers(300000, t + 0.5); };  // longer than a pipe holds
  const Results results = run(5, 2, task);
  for (int t = 0; t < 5; ++t) EXPECT_EQ(results[static_cast<std::size_t>(t)], task(t)) << "task " << t;
}

TEST(Workers, no_task_gives_no_result) { EXPECT_TRUE(run(0, 4, numbers_of_task).empty()); }

TEST(Workers, begin_no_task_any_more_once_they_shall_stop) {
  for (int workers : {1, 3}) {
    bool stop = false;
    const Results results = search::run_in_workers(
        100, workers, numbers_of_task, [&](int done, const auto&) { stop = done >= 5; }, [&] { return stop; });
    ASSERT_EQ(results.size(), 100U);
    const auto found =
        std::count_if(results.begin(), results.end(), [](const auto& result) { return result.has_value(); });
    EXPECT_GE(found, 5) << workers << " workers";
    EXPECT_LT(found, 5 + workers) << workers << " workers";
    EXPECT_TRUE(results.front());
  }
}

TEST(Workers, work_happens_in_other_processes) {
  const double here = getpid();
  for (const auto& result : run(4, 2, [](int) { return Numbers{static_cast<double>(getpid())}; }))
    EXPECT_NE(result.value().front(), here);
}

void expect_only_missing(const Results& results, const std::vector<int>& missing) {
  for (int t = 0; t < static_cast<int>(results.size()); ++t) {
    const bool lost = std::find(missing.begin(), missing.end(), t) != missing.end();
    EXPECT_EQ(results[static_cast<std::size_t>(t)].has_value(), !lost) << "task " << t;
  }
}

TEST(Workers, a_task_whose_process_dies_gives_nothing_and_the_others_arrive) {
  for (int workers : {2, 3})
    expect_only_missing(run(8, workers,
                            [](int t) {
                              if (t == 1) raise(SIGKILL);
                              if (t == 4) _exit(0);
                              return Numbers{1.0};
                            }),
                        {1, 4});
}

TEST(Workers, tasks_that_all_die_leave_the_caller_alive_and_empty_handed) {
  expect_only_missing(run(2, 2,
                          [](int) -> Numbers {
                            raise(SIGKILL);
                            return {};
                          }),
                      {0, 1});
}

TEST(Workers, one_worker_works_in_the_callers_process) {
  EXPECT_EQ(run(2, 1, [](int) { return Numbers{static_cast<double>(getpid())}; })[1].value().front(), getpid());
}

struct Thrown {
  int task;
};

// The task whose exception went on; −1: none.
int thrown_by(const std::function<void()>& work) {
  try {
    work();
  } catch (const Thrown& thrown) {
    return thrown.task;
  }
  return -1;
}

TEST(Workers, what_the_first_of_the_tasks_throws_goes_on_whatever_the_number_of_workers) {
  for (int workers : {1, 2, 3, 40}) {
    const auto task = [](int t) {
      if (t == 2) usleep(20000);  // task 4 throws first
      if (t == 2 || t == 4) throw Thrown{t};
      return Numbers{1.0};
    };
    EXPECT_EQ(thrown_by([&] { run(8, workers, task); }), 2) << workers << " workers";
    EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a worker was left behind, " << workers << " workers";
  }
}

TEST(Workers, are_gone_when_telling_of_them_throws) {
  const auto told = [](int done, const auto&) {
    if (done == 2) throw Thrown{0};
  };
  EXPECT_EQ(thrown_by([&] { search::run_in_workers(8, 3, numbers_of_task, told); }), 0);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
}

TEST(Threads, do_every_task_once) {
  for (int workers : {1, 2, 7, 40}) {
    std::vector<std::atomic<int>> times(13);
    search::run_in_threads(13, workers, [&](int t) { ++times[static_cast<std::size_t>(t)]; });
    for (const auto& each : times) EXPECT_EQ(each, 1) << workers << " workers";
  }
  search::run_in_threads(0, 4, [](int) { FAIL() << "there is no task"; });
}

TEST(Threads, what_the_first_of_the_tasks_throws_goes_on_after_all_have_ended) {
  for (int workers : {1, 2, 3, 40}) {
    std::atomic<int> begun = 0, ended = 0;
    const auto task = [&](int t) {
      ++begun;
      if (t == 2) usleep(20000);  // task 4 throws first
      if (t == 2 || t == 4) {
        ++ended;
        throw Thrown{t};
      }
      usleep(t < 8 ? 100 : 2000);
      ++ended;
    };
    EXPECT_EQ(thrown_by([&] { search::run_in_threads(10000, workers, task); }), 2) << workers << " workers";
    EXPECT_EQ(begun, ended) << workers << " workers";
    EXPECT_LT(begun, 1000) << workers << " workers";
  }
}

}  // namespace
}  // namespace lamprey::tests
