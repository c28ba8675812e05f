// How far a search's steps go within limits that only angles have, where rows are as a step foresees them.
#include <gtest/gtest.h>

#include <memory>

#include "chains.hpp"
#include "shape/reach.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;
using optimizer::Promise;
using optimizer::StageModel;
using optimizer::StageStep;
using shape::ShapeProgram;

constexpr double angle_bound = 0.02;          // rad
constexpr double largest_turn_of_step = 0.1;  // rad, what a step turns a joint by

model::SwimmerDescription hinged_chain() {
  model::SwimmerDescription swimmer = paper_chain();
  for (model::JointDescription& joint : swimmer.joints) {
    joint.kind = model::JointKind::hinge;
    joint.axis = Vector3d::UnitZ();
  }
  return swimmer;
}

// A swimmer at rest, with and without limits, and a step that leaves them.
class StepsWithinLimits : public ::testing::TestWithParam<unsigned> {
 protected:
  static constexpr int count = 8;

  StepsWithinLimits() : swimmer_(hinged_chain()), system_(swimmer_), random_(GetParam()) {
    maneuver_.start.rotation.assign(3, Matrix3d::Identity());
    maneuver_.start.position.setZero();
    maneuver_.start.momentum = VectorXd::Zero(system_.velocity_count());
    maneuver_.end_rotation.assign(3, std::nullopt);
    maneuver_.duration = 1.0;
    maneuver_.steps = count;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 1.0 / count, count);
    maneuver::Problem problem;
    problem.swimmer = swimmer_;
    problem.steps = count;
    problem.start.rotation.assign(3, Vector3d::Zero());
    free_ = program({});
    for (const model::JointDescription& joint : swimmer_.joints)
      problem.limits.angle[joint.name] = {{-angle_bound, angle_bound}};
    limited_ = program(maneuver::limit_rows(system_, problem));
    free_model_ = std::make_unique<StageModel>(free_->sizes());
    model_ = std::make_unique<StageModel>(limited_->sizes());
    step_ = std::make_unique<StageStep>(limited_->sizes());
    free_->linearize(*free_model_);
    limited_->linearize(*model_);
    double turn = 0.0;
    for (std::size_t n = 0; n < model_->stage.size(); ++n) {
      for (double& entry : step_->input[n]) entry = random_.normal();
      step_->state[n + 1] = model_->stage[n].A * step_->state[n] + model_->stage[n].B * step_->input[n];
      turn = std::max(turn, step_->state[n + 1].segment(2, 2).lpNorm<Eigen::Infinity>());
    }
    for (VectorXd& input : step_->input) input *= largest_turn_of_step / turn;
    for (VectorXd& state : step_->state) state *= largest_turn_of_step / turn;
  }

  std::unique_ptr<ShapeProgram> program(const std::vector<maneuver::LimitRow>& rows) const {
    auto made = std::make_unique<ShapeProgram>(system_, maneuver_, ShapeCoordinates(system_),
                                               std::vector<maneuver::EndRow>(), rows);
    if (!rows.empty())
      made->take_limit_multipliers(
          {MatrixXd::Constant(static_cast<Eigen::Index>(rows.size()), count + 1, 1e3), 20.0, 3e17});
    NodePath still;
    still.rotation.assign(count + 1, maneuver_.start.rotation);
    still.position.assign(count + 1, maneuver_.start.position);
    EXPECT_TRUE(made->go_to(still));
    return made;
  }

  double cost_of_limits(double share) {
    return limited_->try_step(*step_, share)->cost - free_->try_step(*step_, share)->cost;
  }

  // What the model has of it.
  double modelled_cost_of_limits(double share) const {
    const auto along = [&](const StageModel& model, double& rate, double& bend) {
      rate += model.q_end.dot(step_->state.back());
      bend += step_->state.back().dot(model.Q_end * step_->state.back());
      for (std::size_t k = 0; k < model.stage.size(); ++k) {
        const optimizer::Stage& stage = model.stage[k];
        const VectorXd &s = step_->state[k], &v = step_->input[k];
        rate += stage.q.dot(s) + stage.r.dot(v);
        bend += s.dot(stage.Q * s) + 2.0 * v.dot(stage.S * s) + v.dot(stage.R * v);
      }
    };
    double rate = 0.0, bend = 0.0, free_rate = 0.0, free_bend = 0.0;
    along(*model_, rate, bend);
    along(*free_model_, free_rate, free_bend);
    return (rate - free_rate) * share + 0.5 * (bend - free_bend) * share * share;
  }

  // Of what is promised, what limits that are no parabolas leave.
  double left_of(const Promise& promise, double share) {
    const double beyond = cost_of_limits(share) - cost_of_limits(0.0) - modelled_cost_of_limits(share);
    return promise.rate * share - 0.5 * promise.bend * share * share - beyond;
  }

  model::SwimmerDescription swimmer_;
  model::System system_;
  Random random_;
  maneuver::Maneuver maneuver_;
  std::unique_ptr<ShapeProgram> free_, limited_;
  std::unique_ptr<StageModel> free_model_, model_;
  std::unique_ptr<StageStep> step_;
};

TEST_P(StepsWithinLimits, come_to_no_limit_without_a_promise) {
  const double share = limited_->longest(*step_, {});
  EXPECT_LT(share, angle_bound / largest_turn_of_step);
  EXPECT_GT(share, 0.5 * angle_bound / largest_turn_of_step);
}

TEST_P(StepsWithinLimits, go_on_while_limits_leave_something_of_the_promise) {
  const double within = limited_->longest(*step_, {});
  double longest = within;
  int between = 0;
  for (double rate = 1e-2; rate < 1e8; rate *= 3.0) {
    const Promise promise{rate, 0.5 * rate};
    const double share = limited_->longest(*step_, promise);
    EXPECT_GE(share, longest) << "a larger promise is a shorter step";
    longest = share;
    if (share <= within || share >= 1.0) continue;
    ++between;
    EXPECT_GE(left_of(promise, share), left_of(promise, 0.95 * share));
    EXPECT_GE(left_of(promise, 1.05 * share), left_of(promise, 1.1 * share));
  }
  EXPECT_GT(between, 2);
  EXPECT_EQ(longest, 1.0) << "no promise is worth the whole step";
}

TEST_P(StepsWithinLimits, break_none_by_much) {
  for (VectorXd& state : step_->state) state *= 10.0;
  for (VectorXd& input : step_->input) input *= 10.0;
  const double share = limited_->longest(*step_, {1e12, 0.0});
  EXPECT_LT(share * 10.0 * largest_turn_of_step, angle_bound + 0.1);
  EXPECT_GT(share * 10.0 * largest_turn_of_step, 0.9 * (angle_bound + 0.1));
}

INSTANTIATE_TEST_SUITE_P(Seeds, StepsWithinLimits, ::testing::Range(1u, 6u));

}  // namespace
}  // namespace lamprey::tests
