// The stages of a step as one, against the stages one by one: random linear stages, no mechanics.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "maneuver/step_polynomial.hpp"
#include "shape/condensed_step.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using optimizer::Stage;
using optimizer::StageModel;
using shape::CondensedStep;
using shape::CondensingSpace;
using shape::StageForce;
using shape::StageLink;
using shape::StepCostate;
using shape::StepLayout;

MatrixXd random_matrix(Random& random, int rows, int columns) {
  MatrixXd m(rows, columns);
  for (double& entry : m.reshaped()) entry = random.normal();
  return m;
}

MatrixXd symmetric(const MatrixXd& m) { return m + m.transpose(); }

class Condensed : public ::testing::Test {
 protected:
  static constexpr int f = 3, m = 2, terms = 2, stages = 3;

  Condensed()
      : random_(5),
        layout_{f, m, terms, {0.3, -0.2, 0.4}, random_matrix(random_, 6, 6).householderQr().householderQ()},
        space_(layout_) {
    step_ = std::make_unique<CondensedStep>(layout_);
    for (StageLink& link : step_->link)
      link = {{random_matrix(random_, 6, 2 * f),
               random_matrix(random_, f, 2 * f) + 3.0 * MatrixXd::Identity(f, 2 * f).rowwise().reverse(),
               random_matrix(random_, f, 2 * f)},
              symmetric(random_matrix(random_, 2 * f + 3, 2 * f + 3)),
              random_.vector(),
              random_matrix(random_, f, 1)};
    for (StageForce& force : step_->force)
      force = {random_matrix(random_, f, m), random_matrix(random_, m, f), random_matrix(random_, terms, 1)};
    StageModel model({1, layout_.states(), layout_.inputs(), 0});
    stage_ = model.stage[0];
    EXPECT_TRUE(step_->condense(space_, stage_));
    state_ = random_matrix(random_, layout_.states(), 1);
    input_ = random_matrix(random_, layout_.inputs(), 1);
  }

  VectorXd moments(int node, const VectorXd& input) const {
    return input.reshaped(m, terms) * step_->force[model::at(node)].value;
  }

  struct Followed {
    std::vector<VectorXd> shape;
    VectorXd momentum;
    Eigen::Matrix<double, 6, 1> pose;
    double curvature = 0.0;  // ½ of the quadratic form of all stages
  };

  // One stage after another.
  Followed follow(const VectorXd& state, const VectorXd& input, double gaps) const {
    Followed now;
    now.shape.emplace_back(state.head(f));
    now.momentum = state.segment(f, f);
    now.pose = layout_.pose_basis * state.tail(6);
    const auto mix = [&](int node, double time) {
      now.curvature +=
          0.5 * time * moments(node, input).dot(step_->force[model::at(node)].control_by_shape * now.shape.back());
    };
    for (int s = 0; s < stages; ++s) {
      const StageLink& link = step_->link[model::at(s)];
      const double half = 0.5 * layout_.time[model::at(s)];
      const VectorXd left = now.shape.back();
      mix(s, 2.0 * half);
      const VectorXd missing = now.momentum - gaps * link.missing - link.tangent.minus.leftCols(f) * left +
                               half * step_->force[model::at(s)].impulse * moments(s, input);
      now.shape.push_back(link.tangent.minus.rightCols(f).fullPivLu().solve(missing));
      VectorXd ends(2 * f + 3);
      ends << left, now.shape.back(), Vector3d::Zero();
      mix(s + 1, 2.0 * half);
      now.momentum =
          link.tangent.plus * ends.head(2 * f) + half * step_->force[model::at(s + 1)].impulse * moments(s + 1, input);
      const Vector3d turn = now.pose.head<3>();
      now.pose += link.tangent.pose * ends.head(2 * f);
      now.pose.tail<3>() += turn.cross(link.displacement);
      ends.tail<3>() = now.pose.head<3>();
      now.curvature += 0.5 * ends.dot(link.hessian * ends);
    }
    return now;
  }

  Random random_;
  StepLayout layout_;
  CondensingSpace space_;
  std::unique_ptr<CondensedStep> step_;
  Stage stage_;
  VectorXd state_, input_;
};

TEST_F(Condensed, ends_where_its_stages_end_one_after_another) {
  const Followed end = follow(state_, input_, 1.0);
  VectorXd expected(layout_.states());
  expected << end.shape.back(), end.momentum, layout_.pose_basis.transpose() * end.pose;
  const VectorXd found = stage_.A * state_ + stage_.B * input_ + stage_.gap;
  EXPECT_LE((found - expected).norm(), tolerance(1e-12) * expected.norm());
  VectorXd all, shape(f);
  step_->pack(state_, input_, all);
  for (int node = 1; node <= stages; ++node) {
    step_->shape_along(node, all, shape);
    EXPECT_LE((shape - end.shape[model::at(node)]).norm(), tolerance(1e-12) * expected.norm());
  }
}

TEST_F(Condensed, has_the_curvature_of_its_stages) {
  const auto quadratic = [&](const VectorXd& s, const VectorXd& v) {
    return 0.5 * s.dot(stage_.Q * s) + v.dot(stage_.S * s) + 0.5 * v.dot(stage_.R * v) + stage_.q.dot(s) +
           stage_.r.dot(v);
  };
  const double constant = follow(VectorXd::Zero(state_.size()), VectorXd::Zero(input_.size()), 1.0).curvature;
  const double expected = follow(state_, input_, 1.0).curvature - constant;
  EXPECT_NEAR(quadratic(state_, input_), expected, tolerance(1e-11) * std::abs(expected));
}

// Costates inside a step are those of a stage as a whole: by its beginning the gradient of all that comes.
TEST_F(Condensed, carries_the_costate_at_its_end_back_to_its_beginning) {
  const VectorXd next = random_matrix(random_, layout_.states(), 1);
  const VectorXd expected = stage_.Q * state_ + stage_.S.transpose() * input_ + stage_.q + stage_.A.transpose() * next;
  std::vector<StepCostate> costate(stages, {VectorXd(f), VectorXd(f), {}});
  step_->carry_back(state_, input_, {next.head(f), next.segment(f, f), layout_.pose_basis * next.tail(6)}, costate);
  EXPECT_LE((costate[0].shape - expected.head(f)).norm(), tolerance(1e-11) * expected.norm());
  EXPECT_LE((costate[0].momentum - expected.segment(f, f)).norm(), tolerance(1e-11) * expected.norm());
  EXPECT_LE((layout_.pose_basis.transpose() * costate[0].pose - expected.tail(6)).norm(),
            tolerance(1e-11) * expected.norm());
}

// What is missing at an inner node counts with minus its momentum's costate.
TEST_F(Condensed, has_multipliers_of_what_is_missing_inside) {
  const VectorXd next = random_matrix(random_, layout_.states(), 1);
  std::vector<StepCostate> costate(stages, {VectorXd(f), VectorXd(f), {}});
  step_->carry_back(state_, input_, {next.head(f), next.segment(f, f), layout_.pose_basis * next.tail(6)}, costate);
  const auto value = [&]() {
    const Followed end = follow(state_, input_, 1.0);
    VectorXd reached(layout_.states());
    reached << end.shape.back(), end.momentum, layout_.pose_basis.transpose() * end.pose;
    return end.curvature + next.dot(reached);
  };
  for (int s = 0; s < stages; ++s)
    for (int c = 0; c < f; ++c) {  // the value is quadratic: central differences are exact
      double& missing = step_->link[model::at(s)].missing[c];
      missing += 0.5;
      const double more = value();
      missing -= 1.0;
      const double less = value();
      missing += 0.5;
      EXPECT_NEAR(more - less, -costate[model::at(s)].momentum[c], tolerance(1e-9) * (1.0 + std::abs(more)));
    }
}

TEST_F(Condensed, says_where_a_stage_is_singular) {
  step_->link[1].tangent.minus.rightCols(f).setZero();
  EXPECT_FALSE(step_->condense(space_, stage_));
}

}  // namespace
}  // namespace lamprey::tests
