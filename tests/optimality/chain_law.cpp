#include "optimality/chain.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <limits>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using optimality::Chain;
using optimality::ChainSolver;
using optimality::ChainStage;
using optimality::Inputs;

constexpr int states = 4, inputs = 2, end_row_count = 3;

MatrixXd random_matrix(Random& random, int height, int width) {
  MatrixXd m(height, width);
  for (double& entry : m.reshaped()) entry = random.normal();
  return m;
}

MatrixXd random_symmetric(Random& random, int size) {
  const MatrixXd m = random_matrix(random, size, size);
  return 0.5 * (m + m.transpose());
}

// `growth`: by which a stage multiplies states, about.
Chain random_chain(unsigned seed, int stages, double growth) {
  Random random(seed);
  Chain chain;
  for (int k = 0; k < stages; ++k) {
    const MatrixXd R = random_symmetric(random, inputs);
    chain.stage.push_back({growth * (MatrixXd::Identity(states, states) + 0.2 * random_matrix(random, states, states)),
                           0.5 * random_matrix(random, states, inputs), 0.05 * random_symmetric(random, states),
                           0.1 * random_matrix(random, inputs, states), R + 2.0 * MatrixXd::Identity(inputs, inputs),
                           random.uniform(0.5, 2.0)});
  }
  chain.end_form = 0.2 * random_symmetric(random, states);
  const Eigen::HouseholderQR<MatrixXd> qr(random_matrix(random, states, end_row_count));
  chain.end_rows = MatrixXd(qr.householderQ() * MatrixXd::Identity(states, end_row_count)).transpose();
  return chain;
}

VectorXd stacked(const Inputs& parts) {
  VectorXd all(inputs * static_cast<int>(parts.size()));
  for (std::size_t k = 0; k < parts.size(); ++k) all.segment<inputs>(inputs * static_cast<int>(k)) = parts[k];
  return all;
}

// Form and metric by all inputs at once, and a basis of the inputs that keep the end rows.
struct Dense {
  MatrixXd form, metric, kept;
  std::vector<MatrixXd> state;  // [stages] at their beginnings, by all inputs
  explicit Dense(const Chain& chain) {
    const int stages = static_cast<int>(chain.stage.size()), size = inputs * stages;
    form = MatrixXd::Zero(size, size);
    metric = form;
    MatrixXd y = MatrixXd::Zero(states, size);
    for (int k = 0; k < stages; ++k) {
      const ChainStage& stage = chain.stage[static_cast<std::size_t>(k)];
      MatrixXd u = MatrixXd::Zero(inputs, size);
      u.middleCols<inputs>(inputs * k).setIdentity();
      const MatrixXd mixed = u.transpose() * stage.S * y;
      form += y.transpose() * stage.Q * y + mixed + mixed.transpose() + u.transpose() * stage.R * u;
      metric += stage.weight * u.transpose() * u;
      state.push_back(y);
      y = stage.A * y + stage.B * u;
    }
    form += y.transpose() * chain.end_form * y;
    MatrixXd rows = chain.end_rows * y;
    for (int k = 0; k < stages; ++k) {
      const optimality::KeptRows& own = chain.stage[static_cast<std::size_t>(k)].kept;
      if (own.by_state.rows() == 0) continue;
      rows.conservativeResize(rows.rows() + own.by_state.rows(), Eigen::NoChange);
      auto last = rows.bottomRows(own.by_state.rows());
      last = own.by_state * state[static_cast<std::size_t>(k)];
      last.middleCols<inputs>(inputs * k) += own.by_input;
    }
    Eigen::FullPivLU<MatrixXd> lu(rows);
    lu.setThreshold(1e-10);
    kept = lu.kernel();
  }
  VectorXd eigenvalues() const {
    return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(kept.transpose() * form * kept,
                                                              kept.transpose() * metric * kept, Eigen::EigenvaluesOnly)
        .eigenvalues();
  }
};

TEST(Chain, counts_the_negative_eigenvalues_of_the_dense_form_whatever_the_penalty) {
  int indefinite = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chain chain = random_chain(seed, 8, 1.0);
    const VectorXd values = Dense(chain).eigenvalues();
    for (double penalty : {0.0, 1.0, 1e4})
      for (Eigen::Index n = 0; n + 1 < values.size(); ++n) {
        ChainSolver solver(chain, penalty);
        const std::optional<int> negative = solver.factor(0.5 * (values[n] + values[n + 1]));
        ASSERT_TRUE(negative.has_value());
        EXPECT_EQ(*negative, n + 1) << seed << ", penalty " << penalty;
        indefinite += values[n] < 0.0;
      }
  }
  EXPECT_GT(indefinite, 20);
}

TEST(Chain, sets_an_eigenvector_aside_that_it_finds_from_inputs_beside_it) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chain chain = random_chain(seed, 8, 1.0);
    const Dense dense(chain);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> split(dense.kept.transpose() * dense.form * dense.kept,
                                                                   dense.kept.transpose() * dense.metric * dense.kept);
    const VectorXd smallest = dense.kept * split.eigenvectors().col(0);
    Random random(seed + 100);
    Inputs from;
    for (int k = 0; k < 8; ++k)
      from.emplace_back(smallest.segment<inputs>(inputs * k) + 0.02 * VectorXd(random_matrix(random, inputs, 1)));
    ChainSolver solver(chain, 1.0);
    const double shift = split.eigenvalues()[0] - 1e-3;
    const auto found = optimality::eigenvector_near(chain, solver, shift, from);
    ASSERT_TRUE(found) << seed;
    const VectorXd inputs_found = stacked(found->inputs);
    EXPECT_NEAR(std::abs(inputs_found.dot(dense.metric * smallest)), 1.0, 1e-6) << seed;
    const double length = std::sqrt(stacked(from).dot(dense.metric * stacked(from)));
    EXPECT_NEAR(found->cosine, inputs_found.dot(dense.metric * stacked(from)) / length, 1e-12);
    const optimality::SmallestEigenvalue next = smallest_eigenvalue(chain, solver, &found->inputs);
    EXPECT_NEAR(next.value, split.eigenvalues()[1], tolerance(1e-6) * std::abs(split.eigenvalues()[1])) << seed;
    EXPECT_LT(next.bound, next.value);
    EXPECT_FALSE(optimality::eigenvector_near(chain, solver, split.eigenvalues()[0] + 1e-3, from)) << "not below all";
  }
}

// Rows that one input can keep, that it takes the inputs before to keep, that say the same twice, and that the end rows imply.
Chain chain_with_rows(unsigned seed) {
  Chain chain = random_chain(seed, 10, 1.0);
  Random random(seed + 50);
  keep_rows(random_matrix(random, 1, states + inputs), chain.stage[2]);
  MatrixXd by_state = random_matrix(random, 2, states + inputs);
  by_state.rightCols<inputs>().setZero();
  keep_rows(by_state, chain.stage[5]);
  MatrixXd twice = random_matrix(random, 3, states + inputs);
  twice.row(2) = twice.row(0) - 3.0 * twice.row(1);
  keep_rows(twice, chain.stage[7]);
  MatrixXd at_end(1, states + inputs);
  at_end << chain.end_rows.row(0) * chain.stage[9].A, chain.end_rows.row(0) * chain.stage[9].B;
  if (seed % 2 == 0) keep_rows(at_end, chain.stage[9]);
  return chain;
}

TEST(Chain, keeps_the_rows_of_its_stages) {
  int indefinite = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chain chain = chain_with_rows(seed);
    const VectorXd values = Dense(chain).eigenvalues();
    ASSERT_EQ(values.size(), 20 - end_row_count - 5);
    for (double penalty : {0.0, 1.0, 1e4})
      for (Eigen::Index n = 0; n + 1 < values.size(); ++n) {
        ChainSolver solver(chain, penalty);
        EXPECT_EQ(solver.factor(0.5 * (values[n] + values[n + 1])), n + 1) << seed << ", penalty " << penalty;
        indefinite += values[n] < 0.0;
      }
    ChainSolver solver(chain, 1e3);
    const optimality::SmallestEigenvalue smallest = smallest_eigenvalue(chain, solver);
    EXPECT_NEAR(smallest.value, values[0], 2e-3 * std::max(1.0, std::abs(values[0]))) << seed;
  }
  EXPECT_GT(indefinite, 5);
}

TEST(Chain, with_rows_weighed_is_definite_only_where_it_is_with_rows_kept) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chain chain = chain_with_rows(seed);
    const double least = Dense(chain).eigenvalues()[0], near = 1e-3 * std::max(1.0, std::abs(least));
    double before = -std::numeric_limits<double>::infinity();
    for (const double weight : {1.0, 1e2, 1e4, 1e6}) {
      const Chain weighed = with_rows_weighed(chain, weight);
      EXPECT_FALSE(keeps_rows(weighed));
      const double value = Dense(weighed).eigenvalues()[0];
      EXPECT_GT(value, before - near);
      EXPECT_LT(value, least + near);
      before = value;
    }
    EXPECT_NEAR(before, least, near) << seed;
  }
}

// A row on states that an input hardly reaches: to keep it moves that input far, and what that does to later rows the next ones
// farther.
TEST(Chain, with_rows_weighed_is_right_where_inputs_that_keep_rows_swing) {
  int lost = 0;
  for (unsigned seed = 1; seed <= 6; ++seed)
    for (const double reach : {1e-2, 1e-3, 1e-4}) {
      Chain chain = random_chain(seed, 30, 1.0);
      Random random(seed + 9);
      for (std::size_t k = 0; k < 29; ++k) {
        MatrixXd row = random_matrix(random, 1, states + inputs);
        row(0, states) *= reach;
        row(0, states + 1) = 0.0;
        if (k % 5 != 0) keep_rows(row, chain.stage[k]);
      }
      const double least = Dense(chain).eigenvalues()[0];
      const auto smallest_of = [](const Chain& any) {
        ChainSolver solver(any, 1e3);
        return smallest_eigenvalue(any, solver).value;
      };
      EXPECT_NEAR(smallest_of(with_rows_weighed(chain, 1e6)), least, 1e-3 * std::max(1.0, std::abs(least)))
          << seed << " " << reach;
      lost += !(std::abs(smallest_of(chain) - least) < 0.1) ? 1 : 0;
    }
  EXPECT_GT(lost, 6) << "kept rows would do";
}

// Inertia of the whole system of inputs, states and multipliers, which instability does not spoil.
int negative_of_the_whole_system(const Chain& chain, double shift) {
  const int stages = static_cast<int>(chain.stage.size()), stride = inputs + states;
  const int free = stages * stride, all = free + stages * states + end_row_count;
  MatrixXd whole = MatrixXd::Zero(all, all);
  for (int k = 0; k < stages; ++k) {
    const ChainStage& stage = chain.stage[static_cast<std::size_t>(k)];
    const int u = k * stride, y = u - states, next = u + inputs, tie = free + k * states;
    whole.block<inputs, inputs>(u, u) = stage.R - shift * stage.weight * MatrixXd::Identity(inputs, inputs);
    whole.block<states, inputs>(tie, u) = stage.B;
    whole.block<states, states>(tie, next) = -MatrixXd::Identity(states, states);
    if (k == 0) continue;
    whole.block<states, states>(y, y) = stage.Q;
    whole.block<inputs, states>(u, y) = stage.S;
    whole.block<states, inputs>(y, u) = stage.S.transpose();
    whole.block<states, states>(tie, y) = stage.A;
  }
  whole.block<states, states>(free - states, free - states) = chain.end_form;
  whole.block<end_row_count, states>(all - end_row_count, free - states) = chain.end_rows;
  whole.topRightCorner(free, all - free) = whole.bottomLeftCorner(all - free, free).transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> split(whole, Eigen::EigenvaluesOnly);
  return static_cast<int>((split.eigenvalues().array() < 0.0).count()) - (all - free);
}

TEST(Chain, counts_them_along_a_chain_that_multiplies_errors_by_a_thousand_billions) {
  int counted = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Chain chain = random_chain(seed, 40, 2.0);
    for (double shift : {-200.0, -20.0, -2.0, 0.0, 1.0}) {
      ChainSolver solver(chain, 1e3);
      const int expected = negative_of_the_whole_system(chain, shift);
      EXPECT_EQ(solver.factor(shift), expected) << seed << ", shift " << shift;
      counted += expected;
    }
  }
  EXPECT_GT(counted, 10);
}

TEST(Chain, solves_what_the_dense_form_says) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Chain chain = seed <= 5 ? random_chain(seed, 8, 1.0) : chain_with_rows(seed);
    const Dense dense(chain);
    Random random(seed + 100);
    optimality::ChainGradient gradient;
    VectorXd dense_gradient = VectorXd::Zero(dense.form.rows());
    for (std::size_t k = 0; k < chain.stage.size(); ++k) {
      gradient.by_input.push_back(random_matrix(random, inputs, 1));
      gradient.by_state.push_back(random_matrix(random, states, 1));
      dense_gradient += dense.state[k].transpose() * gradient.by_state[k];
    }
    dense_gradient += stacked(gradient.by_input);
    const double shift = dense.eigenvalues()[0] - 0.5;
    const MatrixXd& Z = dense.kept;
    const MatrixXd shifted = dense.form - shift * dense.metric;
    const VectorXd expected = -Z * (Z.transpose() * shifted * Z).ldlt().solve(Z.transpose() * dense_gradient);
    for (double penalty : {0.0, 1e3}) {
      ChainSolver solver(chain, penalty);
      ASSERT_TRUE(solver.factor(shift).has_value());
      const Inputs solution = solver.solve(gradient);
      EXPECT_LE((stacked(solution) - expected).norm(), tolerance(1e-10) * expected.norm());

      // each stage is stationary with its costate, and costates obey the plain recursion, where no stage keeps rows
      if (seed > 5) continue;
      const std::vector<VectorXd> costate = solver.costates(gradient, solution);
      VectorXd y = VectorXd::Zero(states);
      for (std::size_t k = 0; k < chain.stage.size(); ++k) {
        const ChainStage& stage = chain.stage[k];
        const VectorXd& u = solution[k];
        EXPECT_LE((gradient.by_input[k] + stage.R * u - shift * stage.weight * u + stage.S * y +
                   stage.B.transpose() * costate[k + 1])
                      .norm(),
                  tolerance(1e-8));
        EXPECT_LE((gradient.by_state[k] + stage.Q * y + stage.S.transpose() * u + stage.A.transpose() * costate[k + 1] -
                   costate[k])
                      .norm(),
                  tolerance(1e-8));
        y = stage.A * y + stage.B * u;
      }
      EXPECT_LE((chain.end_rows * y).norm(), tolerance(1e-10));
    }
  }
}

TEST(Chain, smallest_eigenvalue_is_that_of_the_dense_form) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Chain chain = random_chain(seed, 8, 1.0);
    const double expected = Dense(chain).eigenvalues()[0];
    ChainSolver solver(chain, 10.0);
    const auto found = optimality::smallest_eigenvalue(chain, solver);
    EXPECT_NEAR(found.value, expected, tolerance(1e-8) * std::abs(expected)) << seed;
    EXPECT_LT(found.bound, expected);
    EXPECT_GE(found.bound, expected - std::max(1e-6, 1e-3 * std::abs(expected)) * (1.0 + 1e-6));
  }
}

TEST(Chain, without_rows_or_with_as_many_rows_as_inputs_is_told_apart) {
  Chain chain = random_chain(1, 8, 1.0);
  chain.end_rows.resize(0, states);
  ChainSolver free(chain, 1.0);
  const Dense dense_free = [&] {
    Dense dense(random_chain(1, 8, 1.0));
    dense.kept = MatrixXd::Identity(dense.form.rows(), dense.form.rows());
    return dense;
  }();
  EXPECT_NEAR(optimality::smallest_eigenvalue(chain, free).value, dense_free.eigenvalues()[0], tolerance(1e-8));
}

}  // namespace
}  // namespace lamprey::tests
