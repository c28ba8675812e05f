#include "optimizer/riccati.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <Eigen/Dense>

#include "random_stages.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using optimizer::Riccati;
using optimizer::Stage;
using optimizer::StageModel;
using optimizer::StageSizes;
using optimizer::StageStep;

constexpr StageSizes sizes{7, 5, 2, 3};
constexpr double penalty = 50.0;

// The model with the states put in terms of the inputs: ½ xᵀHx + g·x, and the end rows C x + c.
struct Condensed {
  MatrixXd H, C;
  VectorXd g, c;
};

Condensed condense(const StageModel& model, double shift) {
  const Eigen::Index inputs = sizes.stages * sizes.inputs;
  MatrixXd by_inputs = MatrixXd::Zero(sizes.states, inputs);
  VectorXd offset = VectorXd::Zero(sizes.states);
  Condensed all{MatrixXd::Zero(inputs, inputs), {}, VectorXd::Zero(inputs), {}};
  for (int k = 0; k < sizes.stages; ++k) {
    const Stage& stage = model.stage[static_cast<std::size_t>(k)];
    const MatrixXd Q = stage.Q + shift * stage.metric;
    MatrixXd pick = MatrixXd::Zero(sizes.inputs, inputs);
    pick.middleCols(k * sizes.inputs, sizes.inputs).setIdentity();
    all.H += by_inputs.transpose() * Q * by_inputs + pick.transpose() * stage.R * pick +
             pick.transpose() * stage.S * by_inputs + by_inputs.transpose() * stage.S.transpose() * pick;
    all.g += by_inputs.transpose() * (Q * offset + stage.q) + pick.transpose() * (stage.S * offset + stage.r);
    by_inputs = (stage.A * by_inputs + stage.B * pick).eval();
    offset = (stage.A * offset + stage.gap).eval();
  }
  const MatrixXd Q = model.Q_end + shift * model.metric_end;
  all.H += by_inputs.transpose() * Q * by_inputs;
  all.g += by_inputs.transpose() * (Q * offset + model.q_end);
  all.C = model.C * by_inputs;
  all.c = model.C * offset;
  return all;
}

VectorXd inputs_of(const StageStep& step) {
  const Eigen::Index inputs = step.input.front().size();
  VectorXd all(inputs * static_cast<Eigen::Index>(step.input.size()));
  for (std::size_t k = 0; k < step.input.size(); ++k)
    all.segment(static_cast<Eigen::Index>(k) * inputs, inputs) = step.input[k];
  return all;
}

TEST(Riccati, steps_are_those_of_the_whole_kkt_system) {
  for (unsigned seed : {1U, 2U, 3U, 4U}) {
    for (double share : {1.0, 0.3}) {
      const StageModel model = random_model(sizes, seed, 0.02);
      const Condensed whole = condense(model, 0.1);
      const Eigen::Index inputs = whole.g.size();
      MatrixXd kkt = MatrixXd::Zero(inputs + sizes.end_rows, inputs + sizes.end_rows);
      kkt.topLeftCorner(inputs, inputs) = whole.H;
      kkt.topRightCorner(inputs, sizes.end_rows) = whole.C.transpose();
      kkt.bottomLeftCorner(sizes.end_rows, inputs) = whole.C;
      VectorXd right(kkt.rows());
      right << -whole.g, -whole.c - share * model.c;
      const VectorXd expected = kkt.partialPivLu().solve(right);
      Riccati riccati(sizes);
      StageStep step(sizes);
      ASSERT_TRUE(riccati.factor(model, 0.1, penalty));
      riccati.solve(model, share, step);
      EXPECT_LE((inputs_of(step) - expected.head(inputs)).norm(), tolerance(1e-10) * expected.head(inputs).norm());
      EXPECT_LE((step.end_multiplier - expected.tail(sizes.end_rows)).norm(), tolerance(1e-10) * expected.norm());
      EXPECT_LE((model.C * step.state.back() + share * model.c).norm(), tolerance(1e-11) * model.c.norm());
      EXPECT_EQ(riccati.look_back(model, share), step.end_multiplier);
      const VectorXd left = riccati.look_back(model, 0.0);
      VectorXd response;
      riccati.end_response(model.c, response);
      EXPECT_LE((left + share * response - step.end_multiplier).norm(), tolerance(1e-10) * step.end_multiplier.norm());
    }
  }
}

TEST(Riccati, costates_are_the_gradient_of_what_is_still_to_come) {
  const StageModel model = random_model(sizes, 5, 0.02);
  Riccati riccati(sizes);
  StageStep step(sizes);
  ASSERT_TRUE(riccati.factor(model, 0.0, penalty));
  riccati.solve(model, 1.0, step);
  riccati.find_costates(step);
  for (int k = sizes.stages - 1; k >= 0; --k) {
    const auto n = static_cast<std::size_t>(k);
    const Stage& stage = model.stage[n];
    const VectorXd behind = stage.A.transpose() * step.costate[n + 1] + stage.Q * step.state[n] +
                            stage.S.transpose() * step.input[n] + stage.q;
    EXPECT_LE((behind - step.costate[n]).norm(), tolerance(1e-10) * behind.norm()) << k;
    const VectorXd by_input =
        stage.B.transpose() * step.costate[n + 1] + stage.S * step.state[n] + stage.R * step.input[n] + stage.r;
    EXPECT_LE(by_input.norm(), tolerance(1e-10) * step.costate[n + 1].norm()) << k;
  }
}

TEST(Riccati, a_sweep_succeeds_where_the_hessian_with_the_penalty_is_positive_definite_and_only_there) {
  int definite = 0, indefinite = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const StageModel model = random_model(sizes, seed, 0.01 + 0.004 * seed);
    const Condensed whole = condense(model, 0.0);
    const MatrixXd H = whole.H + penalty * whole.C.transpose() * whole.C;
    const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(H).eigenvalues()[0];
    Riccati riccati(sizes);
    EXPECT_EQ(riccati.factor(model, 0.0, penalty), least > 0.0) << "seed " << seed << ", least eigenvalue " << least;
    ++(least > 0.0 ? definite : indefinite);
    if (least > 0.0) continue;
    ASSERT_TRUE(riccati.met_curvature());
    StageStep step(sizes);
    riccati.bend(model, 2.0, step);
    const VectorXd x = inputs_of(step);
    EXPECT_LT(x.dot(H * x), tolerance(1e-12) * x.squaredNorm()) << "seed " << seed;
  }
  EXPECT_GT(definite, 10);
  EXPECT_GT(indefinite, 10);
}

TEST(Riccati, end_rows_that_depend_on_each_other_are_no_curvature) {
  StageModel model = random_model(sizes, 3, 0.01);
  Riccati riccati(sizes);
  ASSERT_TRUE(riccati.factor(model, 0.0, penalty));
  model.C.row(1).setZero();  // which no input moves
  EXPECT_FALSE(riccati.factor(model, 0.0, penalty));
  EXPECT_FALSE(riccati.met_curvature());
}

// What is told of the states makes no difference to what a sweep finds, step, correction or bend.
void expect_no_difference(const StageSizes& z, int shifted, bool placed, bool with_costates) {
  int definite_ones = 0, indefinite_ones = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    StageModel plain = random_model(z, seed, seed < 10 ? 0.2 / (z.states * z.states) : 1.0);
    if (!with_costates)
      for (Stage& stage : plain.stage) stage.gap.setZero();
    StageModel said = plain;
    place(plain, shifted, placed, false);
    place(said, shifted, placed, true);
    Riccati told(z), untold(z);
    told.want_costates(with_costates);
    StageStep step(z), expected(z);
    const double shift = seed % 2 == 0 ? 0.1 : 0.0;
    const bool definite = untold.factor(plain, shift, penalty);
    ASSERT_EQ(told.factor(said, shift, penalty), definite);
    ++(definite ? definite_ones : indefinite_ones);
    if (definite) {
      told.solve(said, 0.7, step);
      untold.solve(plain, 0.7, expected);
      untold.find_costates(expected);
      if (with_costates) {
        told.find_costates(step);
        EXPECT_LE((step.costate.front() - expected.costate.front()).norm(),
                  tolerance(1e-11) * expected.costate.front().norm());
      }
      for (int k = 0; k < z.stages; ++k)
        EXPECT_LE((told.feedback(k) - untold.feedback(k)).norm(), tolerance(1e-11) * untold.feedback(k).norm()) << k;
      EXPECT_LE((step.end_multiplier - expected.end_multiplier).norm(),
                tolerance(1e-11) * expected.end_multiplier.norm());
      told.correct(said, plain.c, step);
      untold.correct(plain, plain.c, expected);
    } else {
      told.bend(said, 1.0, step);
      untold.bend(plain, 1.0, expected);
    }
    EXPECT_LE((inputs_of(step) - inputs_of(expected)).norm(), tolerance(1e-11) * inputs_of(expected).norm());
    if (definite) {
      EXPECT_NE(inputs_of(step), inputs_of(expected)) << "two roads, not one";
    }
  }
  EXPECT_GE(definite_ones, 5);
  EXPECT_GE(indefinite_ones, 5);
}

// The first states of each node are the next ones of the node before: told so, the sweep does the same with less work.
TEST(Riccati, states_that_only_move_on_make_no_difference) { expect_no_difference(sizes, 2, false, true); }

// And where the next ones are the inputs themselves.
TEST(Riccati, states_that_are_inputs_make_no_difference) { expect_no_difference(sizes, 2, true, true); }

// Sizes that the compiler knows have a sweep of their own, for any number of end rows.
TEST(Riccati, sweeps_of_known_sizes_make_no_difference) {
  for (const auto& [shape, rest] : {std::pair(2, 3), std::pair(3, 6), std::pair(6, 6)})
    for (int end_rows : {0, 1, 4, shape + rest}) {
      SCOPED_TRACE(testing::Message() << shape << " shapes, " << end_rows << " end rows");
      expect_no_difference({6, 2 * shape + rest, shape, end_rows}, shape, true, false);
    }
}

TEST(Riccati, a_model_that_is_not_finite_leaves_no_trace) {
  const StageSizes z{6, 7, 2, 3};
  StageModel model = random_model(z, 1, 0.005);
  for (Stage& stage : model.stage) stage.gap.setZero();
  place(model, 2, true, true);
  StageModel broken = model;
  broken.stage[3].A(5, 3) = std::numeric_limits<double>::infinity();
  for (bool with_costates : {true, false}) {
    Riccati used(z), fresh(z);
    used.want_costates(with_costates);
    fresh.want_costates(with_costates);
    StageStep step(z), expected(z);
    EXPECT_FALSE(used.factor(broken, 0.0, penalty));
    ASSERT_TRUE(used.factor(model, 0.0, penalty));
    ASSERT_TRUE(fresh.factor(model, 0.0, penalty));
    used.solve(model, 1.0, step);
    fresh.solve(model, 1.0, expected);
    EXPECT_EQ(inputs_of(step), inputs_of(expected));
  }
}

TEST(Riccati, a_correction_moves_the_end_rows_as_asked_and_is_least_in_the_hessian) {
  const StageModel model = random_model(sizes, 7, 0.02);
  Riccati riccati(sizes);
  StageStep step(sizes);
  ASSERT_TRUE(riccati.factor(model, 0.0, penalty));
  const VectorXd missed = VectorXd::LinSpaced(sizes.end_rows, 1.0, 2.0);
  riccati.correct(model, missed, step);
  EXPECT_LE((model.C * step.state.back() + missed).norm(), tolerance(1e-11));
  const Condensed whole = condense(model, 0.0);
  const VectorXd expected = -whole.H.llt().solve(
      whole.C.transpose() * (whole.C * whole.H.llt().solve(whole.C.transpose())).inverse() * missed);
  EXPECT_LE((inputs_of(step) - expected).norm(), tolerance(1e-10) * expected.norm());
}

}  // namespace
}  // namespace lamprey::tests
