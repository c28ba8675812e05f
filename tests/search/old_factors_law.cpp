// Steps with a Newton step's old factors arrive where Newton steps do, at fewer second derivatives.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "guess/guess.hpp"
#include "optimizer/stage_newton.hpp"
#include "printed.hpp"
#include "search/grids.hpp"
#include "search/solve.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::tests {
namespace {

constexpr int coarse_nodes = 100, fine_nodes = 200;

// A program that counts second derivatives and can keep first ones by themselves to itself.
class CountedProgram : public shape::ShapeProgram {
 public:
  using ShapeProgram::ShapeProgram;
  bool gives_slopes = true;
  int models = 0, slopes = 0;
  void linearize(optimizer::StageModel& model) override {
    ++models;
    ShapeProgram::linearize(model);
  }
  bool differentiate(optimizer::StageSlopes& first) override {
    if (!gives_slopes) return false;
    ++slopes;
    return ShapeProgram::differentiate(first);
  }
};

class OldFactors : public testing::TestWithParam<const char*> {};

TEST_P(OldFactors, arrive_where_newton_steps_do_with_fewer_second_derivatives) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + GetParam() + ".toml");
  problem.steps = coarse_nodes;
  problem.search.starts = 1;
  problem.search.hops = 0;
  const model::System system(problem.swimmer);
  const maneuver::Solution coarse = search::solve(system, problem, search::SolveOptions()).front();
  ASSERT_EQ(coarse.status, maneuver::Status::optimal);
  maneuver::NodePath path;
  path.rotation = coarse.rotation;
  path.position = coarse.position;
  path.control.assign(path.position.size(), Eigen::VectorXd::Zero(system.control_count()));

  const search::Reached reached(system, problem);
  const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, fine_nodes);
  CountedProgram with(system, maneuver, reached.coordinates, reached.rows),
      without(system, maneuver, reached.coordinates, reached.rows);
  without.gives_slopes = false;
  optimizer::Options options;
  options.tolerance = 1e-7;
  for (CountedProgram* program : {&with, &without}) {
    ASSERT_TRUE(program->go_to(guess::refined(system, path, fine_nodes)));
    optimizer::StageNewton newton(program->sizes());
    const optimizer::Outcome outcome = newton.solve(*program, options);
    ASSERT_EQ(outcome.termination, optimizer::Termination::converged) << outcome.reason;
  }
  EXPECT_GT(with.slopes, 0);
  EXPECT_LT(with.models, without.models);
  EXPECT_NEAR(with.cost() / without.cost(), 1.0, 1e-12);
  const maneuver::NodePath one = with.path(), other = without.path();
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < one.control.size(); ++k) {
    largest = std::max(largest, other.control[k].norm());
    difference = std::max(difference, (one.control[k] - other.control[k]).norm());
  }
  EXPECT_LT(difference, 1e-9 * largest);
}

INSTANTIATE_TEST_SUITE_P(Examples, OldFactors, testing::Values("translation", "rotation"), named_by_value);

}  // namespace
}  // namespace lamprey::tests
