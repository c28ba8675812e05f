#include <gtest/gtest.h>

#include <Eigen/SparseCore>

#include "chains.hpp"
#include "difference_order.hpp"
#include "maneuver/transcription.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using maneuver::Maneuver;
using maneuver::Transcription;

using Sparse = Eigen::SparseMatrix<double>;

Sparse assembled(const optimizer::SparsePattern& pattern, const VectorXd& values, int rows, int columns) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int e = 0; e < pattern.size(); ++e) {
    const auto n = static_cast<std::size_t>(e);
    entries.emplace_back(pattern.rows[n], pattern.columns[n], values[e]);
  }
  Sparse matrix(rows, columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

struct Setting {
  std::string name;
  int bodies;  // 0: the paper's chain
  mechanics::DiscreteLagrangian lagrangian;
  int spline_points;
  bool moving;  // start with momentum, rest free
};

class TranscriptionDerivatives : public ::testing::TestWithParam<Setting> {
 protected:
  TranscriptionDerivatives()
      : random_(17),
        system_(GetParam().bodies == 0 ? paper_chain() : random_tree(random_, GetParam().bodies)),
        transcription_(system_, maneuver(), maneuver::stated_goal_rows(system_, maneuver())) {
    point_ = VectorXd(transcription_.variable_count());
    for (double& v : point_) v = random_.normal();
    direction_ = VectorXd::Random(transcription_.variable_count());
  }

  const Maneuver& maneuver() {
    if (maneuver_.steps > 0) return maneuver_;
    VectorXd velocity = VectorXd::Zero(system_.velocity_count());
    if (GetParam().moving)
      for (double& v : velocity) v = random_.normal();
    mechanics::Rotations rotation;
    for (int i = 0; i < system_.body_count(); ++i) rotation.push_back(random_.rotation());
    maneuver_.start = integrator::state_of_velocity(system_, rotation, random_.vector(), velocity);
    maneuver_.total = mechanics::spatial_momentum(system_, maneuver_.start.rotation, maneuver_.start.position,
                                                  maneuver_.start.momentum);
    for (int i = 0; i < system_.body_count(); ++i) maneuver_.end_rotation.push_back(random_.rotation());
    maneuver_.end_position = {1.0, std::nullopt, -0.5};
    maneuver_.rest = !GetParam().moving;
    maneuver_.lagrangian = GetParam().lagrangian;
    maneuver_.duration = 0.5;
    maneuver_.steps = 5;
    maneuver_.spline_points = GetParam().spline_points;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.1, 5);
    return maneuver_;
  }

  Random random_;
  model::System system_;
  Maneuver maneuver_;
  Transcription transcription_;
  VectorXd point_, direction_;
};

TEST_P(TranscriptionDerivatives, gradient_matches_central_differences) {
  VectorXd gradient(point_.size());
  transcription_.gradient(point_, gradient);
  const auto along = [&](double t) { return VectorXd::Constant(1, transcription_.objective(point_ + t * direction_)); };
  EXPECT_NEAR((along(1e-3) - along(-1e-3))[0] / 2e-3, gradient.dot(direction_), 1e-10 * gradient.norm());
}

TEST_P(TranscriptionDerivatives, jacobian_matches_central_differences_at_second_order) {
  const auto along = [&](double t) {
    VectorXd c(transcription_.constraint_count());
    transcription_.constraints(point_ + t * direction_, c);
    return c;
  };
  VectorXd values;
  transcription_.jacobian(point_, values);
  const Sparse jacobian = assembled(transcription_.jacobian_pattern(), values, transcription_.constraint_count(),
                                    transcription_.variable_count());
  expect_second_order_differences(along, jacobian * direction_);
}

TEST_P(TranscriptionDerivatives, hessian_matches_central_differences_of_the_jacobian_at_second_order) {
  VectorXd multiplier(transcription_.constraint_count());
  for (double& v : multiplier) v = random_.normal();
  const double factor = 0.7;
  const auto along = [&](double t) {
    const VectorXd x = point_ + t * direction_;
    VectorXd values, gradient(x.size());
    transcription_.jacobian(x, values);
    transcription_.gradient(x, gradient);
    const Sparse jacobian = assembled(transcription_.jacobian_pattern(), values, transcription_.constraint_count(),
                                      transcription_.variable_count());
    return VectorXd(factor * gradient + jacobian.transpose() * multiplier);
  };
  VectorXd values;
  transcription_.hessian(point_, factor, multiplier, values);
  for (int r : transcription_.hessian_pattern().rows) ASSERT_LT(r, transcription_.variable_count());
  const Sparse lower = assembled(transcription_.hessian_pattern(), values, transcription_.variable_count(),
                                 transcription_.variable_count());
  for (int c = 0; c < lower.outerSize(); ++c)
    for (Sparse::InnerIterator entry(lower, c); entry; ++entry) ASSERT_GE(entry.row(), entry.col());
  expect_second_order_differences(along, lower.selfadjointView<Eigen::Lower>() * direction_);
}

TEST_P(TranscriptionDerivatives, a_packed_motion_comes_back) {
  const VectorXd x = point_;
  const maneuver::NodePath path = transcription_.unpack(x);
  const maneuver::NodePath again = transcription_.unpack(transcription_.pack(path));
  for (std::size_t k = 0; k < path.rotation.size(); ++k) {
    EXPECT_LE((path.control[k] - again.control[k]).norm(), 1e-12 * (1.0 + path.control[k].norm()));
    EXPECT_LE((path.position[k] - again.position[k]).norm(), 1e-14 * (1.0 + path.position[k].norm()));
    for (std::size_t i = 0; i < path.rotation[k].size(); ++i)
      EXPECT_LE((path.rotation[k][i] - again.rotation[k][i]).norm(), 1e-14);
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, TranscriptionDerivatives,
                         ::testing::Values(Setting{"paper_chain", 0, mechanics::DiscreteLagrangian::trapezoid, 0,
                                                   false},
                                           Setting{"paper_scheme", 0, mechanics::DiscreteLagrangian::paper, 0, false},
                                           Setting{"spline", 0, mechanics::DiscreteLagrangian::trapezoid, 4, false},
                                           Setting{"tree", 5, mechanics::DiscreteLagrangian::trapezoid, 0, false},
                                           Setting{"moving_tree", 4, mechanics::DiscreteLagrangian::paper, 0, true}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
