// Which minima are told apart.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "search/minima.hpp"
#include "search/solve.hpp"

namespace lamprey::tests {
namespace {

// A gait that begins some nodes later is the same one, as dear to a few digits.
TEST(Minima, of_gaits_do_not_depend_on_where_they_begin) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/gait.toml");
  problem.steps = 40;
  problem.search.starts = 1;
  const model::System system(problem.swimmer);
  const maneuver::Solution gait = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(gait.status, maneuver::Status::optimal) << gait.message;
  std::vector<mechanics::Rotations> later(gait.rotation.begin() + 7, gait.rotation.end());
  later.insert(later.end(), gait.rotation.begin() + 1, gait.rotation.begin() + 8);
  ASSERT_EQ(later.size(), gait.rotation.size());
  const search::Minimum one = search::minimum_of(system, problem, gait.cost, gait.rotation);
  const search::Minimum same = search::minimum_of(system, problem, gait.cost * (1.0 + 2e-5), later);
  EXPECT_TRUE(same_minimum(one, same));
  search::Minimum unknown = same;
  unknown.turning.resize(0);
  EXPECT_FALSE(same_minimum(one, unknown));
  search::Minimum other = same;
  other.turning[0] *= 1.01;
  EXPECT_FALSE(same_minimum(one, other)) << "as dear, but by other strokes";
  EXPECT_FALSE(same_minimum(one, search::minimum_of(system, problem, gait.cost * 1.001, later)));
  problem.goal->periodic = false;
  EXPECT_FALSE(same_minimum(search::minimum_of(system, problem, gait.cost, gait.rotation),
                            search::minimum_of(system, problem, gait.cost * (1.0 + 2e-5), later)))
      << "maneuvers begin where they are told to";
}

// What a given duration costs is the same for all.
TEST(Minima, are_told_apart_by_what_is_spent) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation.toml");
  problem.time_weight = 1e9;
  const model::System system(problem.swimmer);
  const double time = 1e9 * problem.duration.value;
  const auto minimum = [&](double spent) { return search::minimum_of(system, problem, time + spent, {}); };
  EXPECT_FALSE(same_minimum(minimum(100.0), minimum(101.0)));
  EXPECT_TRUE(same_minimum(minimum(100.0), minimum(100.0)));
  problem.duration.free = true;
  EXPECT_TRUE(same_minimum(minimum(100.0), minimum(101.0)));
}

}  // namespace
}  // namespace lamprey::tests
