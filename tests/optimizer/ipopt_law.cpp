#include "optimizer/ipopt.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "small_programs.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector2d;
using optimizer::Options;
using optimizer::Outcome;
using optimizer::solve_with_ipopt;
using optimizer::Termination;

const VectorXd from_afar = Vector2d(-1.2, 1.0);
const VectorXd right_of_the_valley = Vector2d(2.0, 0.5);

TEST(Ipopt, finds_the_nearest_point_of_a_plane_and_its_multiplier) {
  const VectorXd a = VectorXd::LinSpaced(6, -2.0, 5.0);
  DenseProgram program = nearest_on_a_plane(a);
  const Outcome outcome = solve_with_ipopt(program, {}, VectorXd::Zero(6));
  const double lambda = (a.sum() - 1.0) / 6.0;
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE((outcome.point - (a - VectorXd::Constant(6, lambda))).norm(), tolerance(1e-10));
  EXPECT_NEAR(outcome.multipliers[0], lambda, tolerance(1e-10));
  EXPECT_NEAR(outcome.objective, 3.0 * lambda * lambda, tolerance(1e-10));
  EXPECT_LE(outcome.infeasibility, tolerance(1e-12));
}

TEST(Ipopt, finds_the_bottom_of_the_valley_on_a_circle_through_it) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  const Outcome outcome = solve_with_ipopt(program, {}, right_of_the_valley);
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE((outcome.point - Vector2d(1.0, 1.0)).norm(), tolerance(1e-8));
  EXPECT_GT(program.hessians, 0);
}

// Where the valley lies outside the disc its rim is met, with a multiplier of the sign of an upper bound.
TEST(Ipopt, stops_at_the_rim_of_a_disc_that_the_valley_leaves) {
  DenseProgram disc = rosenbrock(-2e19, 1.0);
  DenseProgram circle = rosenbrock(1.0, 1.0);
  const Outcome inside = solve_with_ipopt(disc, {}, from_afar);
  const Outcome on = solve_with_ipopt(circle, {}, VectorXd(Vector2d(1.0, 0.0)));
  EXPECT_EQ(inside.termination, Termination::converged) << inside.reason;
  EXPECT_EQ(on.termination, Termination::converged) << on.reason;
  EXPECT_LE((inside.point - on.point).norm(), tolerance(1e-6));
  EXPECT_GT(inside.multipliers[0], 0.05);
  VectorXd g, c;
  disc.gradient(inside.point, g);
  EXPECT_LE((g + 2.0 * inside.multipliers[0] * inside.point).norm(), tolerance(1e-6));
}

TEST(Ipopt, does_without_second_derivatives) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  program.curvature = nullptr;
  const Outcome outcome = solve_with_ipopt(program, {}, right_of_the_valley);
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE((outcome.point - Vector2d(1.0, 1.0)).norm(), tolerance(1e-6));
  EXPECT_EQ(program.hessians, 0);
}

TEST(Ipopt, tells_each_iteration) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  const Outcome outcome = solve_with_ipopt(program, {}, from_afar);
  ASSERT_EQ(outcome.history.size(), static_cast<std::size_t>(outcome.iterations) + 1);
  for (std::size_t n = 0; n < outcome.history.size(); ++n) EXPECT_EQ(outcome.history[n].iteration, static_cast<int>(n));
  EXPECT_NEAR(outcome.history.front().objective, program.objective(from_afar), 1e-12);
  EXPECT_NEAR(outcome.history.back().goal_error, std::sqrt(2.0), 1e-6);  // on the circle, wherever
  EXPECT_GT(outcome.evaluations, outcome.iterations);
}

TEST(Ipopt, goes_on_quickly_from_an_answer_and_its_multipliers) {
  DenseProgram program = rosenbrock(1.0, 1.0);
  const Outcome cold = solve_with_ipopt(program, {}, from_afar);
  const Outcome warm = solve_with_ipopt(program, {}, cold.point, cold.multipliers);
  EXPECT_EQ(warm.termination, Termination::converged) << warm.reason;
  EXPECT_LE((warm.point - cold.point).norm(), tolerance(1e-8));
  EXPECT_LE(warm.iterations, 5);
  EXPECT_GT(cold.iterations, warm.iterations);
}

TEST(Ipopt, gives_the_same_bits_twice) {
  DenseProgram program = rosenbrock(1.0, 1.0);
  const Outcome first = solve_with_ipopt(program, {}, from_afar);
  const Outcome second = solve_with_ipopt(program, {}, from_afar);
  EXPECT_TRUE(first.point == second.point && first.multipliers == second.multipliers);
}

TEST(Ipopt, stops_when_interrupted_and_returns_the_point_so_far) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  Options options;
  int asked = 0;
  options.interrupted = [&asked] { return ++asked == 4; };
  const Outcome outcome = solve_with_ipopt(program, options, from_afar);
  EXPECT_EQ(outcome.termination, Termination::interrupted);
  EXPECT_EQ(outcome.iterations, 3);
  ASSERT_EQ(outcome.point.size(), 2);
  EXPECT_TRUE(outcome.point.allFinite());
  EXPECT_FALSE(outcome.reason.empty());
}

TEST(Ipopt, stops_at_its_time_limit) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  Options options;
  options.time_limit = 0.0;
  const Outcome outcome = solve_with_ipopt(program, options, from_afar);
  EXPECT_EQ(outcome.termination, Termination::time_limit);
  EXPECT_EQ(outcome.iterations, 0);
  EXPECT_EQ(outcome.point.size(), 2);
}

TEST(Ipopt, stops_at_its_iteration_limit) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  Options options;
  options.max_iterations = 3;
  const Outcome outcome = solve_with_ipopt(program, options, from_afar);
  EXPECT_EQ(outcome.termination, Termination::stalled);
  EXPECT_EQ(outcome.iterations, 3);
  EXPECT_NE(outcome.reason.find("iteration"), std::string::npos) << outcome.reason;
}

TEST(Ipopt, says_why_when_constraints_contradict_each_other) {
  DenseProgram program = rosenbrock(-1.0, -1.0);  // x² + y² = −1
  const Outcome outcome = solve_with_ipopt(program, {}, from_afar);
  EXPECT_EQ(outcome.termination, Termination::infeasible) << outcome.reason;
  EXPECT_FALSE(outcome.reason.empty());
  EXPECT_GT(outcome.infeasibility, 0.9);
  EXPECT_EQ(outcome.point.size(), 2);
}

TEST(Ipopt, says_why_when_a_start_has_no_value) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  const Outcome outcome = solve_with_ipopt(program, {}, VectorXd(Vector2d(std::nan(""), 0.0)));
  EXPECT_EQ(outcome.termination, Termination::stalled);
  EXPECT_FALSE(outcome.reason.empty());
  EXPECT_EQ(outcome.point.size(), 2);
}

TEST(Ipopt, steps_around_points_without_a_value) {
  DenseProgram program = rosenbrock(2.0, 2.0);
  const auto known = program.c;
  int refused = 0;
  program.c = [&refused, known](const VectorXd& x) {  // nothing is known beyond y = 1.1
    if (x[1] > 1.1) ++refused;
    return x[1] > 1.1 ? VectorXd(VectorXd::Constant(1, std::nan(""))) : known(x);
  };
  const Outcome outcome = solve_with_ipopt(program, {}, right_of_the_valley);
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_LE((outcome.point - Vector2d(1.0, 1.0)).norm(), tolerance(1e-8));
  EXPECT_GT(refused, 0) << "the region was never tried";
}

}  // namespace
}  // namespace lamprey::tests
