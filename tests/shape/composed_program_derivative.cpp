#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "integrator/march.hpp"
#include "maneuver/motion.hpp"
#include "mechanics/joint_moments.hpp"
#include "shape/composed_program.hpp"
#include "shape/reach.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::Scheme;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;
using optimizer::StageModel;
using optimizer::StageStep;
using shape::ComposedProgram;

enum class ComposedSwimmer { paper_chain, in_the_plane, any_joint, in_fours };

struct ComposedSetting {
  std::string name;
  ComposedSwimmer swimmer;
  Scheme scheme;
  bool rest;
  bool of_leaves = false;  // the goal asks for all bodies but the root and its children
  unsigned seed = 29;
  bool of_joints = false;  // it tells how joints end, and no attitude
};

// N m, of random moments: what the longer stages of order 6 still march.
double size_of(const ComposedSetting& setting) {
  if (setting.swimmer == ComposedSwimmer::any_joint || setting.swimmer == ComposedSwimmer::in_fours) return 2.0;
  return setting.scheme == Scheme::order6 ? 4.0 : 8.0;
}

// A march of three steps under random polynomials, and what is asked of it: just the end that it has.
class ComposedDerivatives : public ::testing::TestWithParam<ComposedSetting> {
 protected:
  static constexpr int steps = 3;

  ComposedDerivatives() : random_(GetParam().seed), system_(swimmer()), size_(size_of(GetParam())) {
    const bool planar = GetParam().swimmer == ComposedSwimmer::in_the_plane;
    maneuver_.start.rotation =
        planar ? mechanics::Rotations(3, Matrix3d::Identity()) : random_rotations(random_, system_);
    maneuver_.start.position = random_.vector();
    maneuver_.start.momentum = VectorXd::Zero(system_.velocity_count());
    maneuver_.end_rotation.assign(maneuver_.start.rotation.size(), std::nullopt);
    maneuver_.rest = GetParam().rest;
    maneuver_.duration = 0.3;
    maneuver_.steps = steps;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.1, steps);
    const NodePath path = marched();
    if (GetParam().of_joints)
      for (const model::Joint& joint : system_.joints())
        maneuver_.end_joint.emplace_back(mechanics::child_to_parent(path.rotation.back(), joint));
    for (int i = 0; i < system_.body_count() && !GetParam().of_joints; ++i)
      if (GetParam().of_leaves ? system_.body(i).parent > 0 : i == 0 || (i == 1 && system_.body(1).freedoms == 3))
        maneuver_.end_rotation[model::at(i)] = path.rotation.back()[model::at(i)];
    maneuver_.end_position = {1.0, std::nullopt, -0.5};
    ShapeCoordinates coordinates(system_);
    if (planar) {
      coordinates.shape = Eigen::MatrixXd::Zero(6, 2);
      coordinates.shape(2, 0) = coordinates.shape(5, 1) = 1.0;
      coordinates.pose = Eigen::MatrixXd::Zero(6, 3);
      coordinates.pose(2, 0) = coordinates.pose(3, 1) = coordinates.pose(4, 2) = 1.0;
    }
    program_ = std::make_unique<ComposedProgram>(system_, maneuver_, GetParam().scheme, coordinates,
                                                 maneuver::stated_end_rows(system_, maneuver_, {}));
    EXPECT_TRUE(GetParam().swimmer != ComposedSwimmer::in_fours ||
                shape::FourSteps::serves(system_, integrator::lagrangian_of(GetParam().scheme)));
    begin_at(path);
  }

  model::SwimmerDescription swimmer() {
    const bool fours = GetParam().swimmer == ComposedSwimmer::in_fours;
    model::SwimmerDescription described =
        GetParam().swimmer == ComposedSwimmer::any_joint || fours ? random_swimmer(random_, 5) : paper_chain();
    for (model::BodyDescription& body : described.bodies)
      if (fours) body.coupling_matrix.reset();
    for (model::JointDescription& joint : described.joints)
      if (fours && joint.kind == model::JointKind::ball) joint.stiffness = joint.damping = 0.0;
    for (model::JointDescription& joint : described.joints)
      if (GetParam().swimmer == ComposedSwimmer::in_the_plane) joint.control_axes = {Vector3d::UnitZ()};
    return described;
  }

  // From rest, so that no impulse is missing anywhere.
  NodePath marched() {
    const int terms = maneuver::polynomial_terms(GetParam().scheme);
    integrator::March march(system_, GetParam().scheme);
    integrator::State state = maneuver_.start;
    NodePath path;
    path.rotation.push_back(state.rotation);
    path.position.push_back(state.position);
    for (int k = 0; k < steps; ++k) {
      VectorXd coefficients(terms * system_.control_count());
      for (double& c : coefficients) c = size_ * random_.normal();
      path.polynomial.push_back(coefficients);
      std::vector<mechanics::Moments> moments;
      for (double node : march.nodes())
        moments.push_back(mechanics::joint_moments(system_, maneuver::moments_at(coefficients, node, terms)));
      const auto report = march.advance(
          0.1, [&](int node) -> const mechanics::Moments& { return moments[model::at(node)]; }, state,
          [&](const mechanics::Interval& interval, const integrator::State& reached) {
            path.rotation.push_back(reached.rotation);
            path.position.push_back(reached.position);
            path.cayley.push_back(interval.cayley);
          });
      EXPECT_TRUE(report.converged);
    }
    return path;
  }

  // Random multipliers that belong to each other.
  void begin_at(const NodePath& path) {
    EXPECT_TRUE(program_->go_to(path));
    const optimizer::StageSizes sizes = program_->sizes();
    model_ = std::make_unique<StageModel>(sizes);
    step_ = std::make_unique<StageStep>(sizes);
    program_->linearize(*model_);
    for (double& multiplier : step_->end_multiplier) multiplier = size_ * size_ * random_.normal();
    for (VectorXd& costate : step_->costate)
      for (double& entry : costate) entry = size_ * random_.normal();
    step_->costate.back() = model_->C.transpose() * step_->end_multiplier;
    program_->take_multipliers(*step_, 1.0);
    program_->linearize(*model_);
    for (VectorXd& input : step_->input)
      for (double& entry : input) entry = 0.1 * size_ * random_.normal();
  }

  // States along the inputs; `gaps` times what closes the gaps.
  std::vector<VectorXd> follow(double inputs, double gaps) const {
    std::vector<VectorXd> state = step_->state;
    for (std::size_t k = 0; k < model_->stage.size(); ++k)
      state[k + 1] =
          model_->stage[k].A * state[k] + inputs * model_->stage[k].B * step_->input[k] + gaps * model_->stage[k].gap;
    return state;
  }

  StageStep step_along(double inputs) const {
    StageStep step = *step_;
    step.state = follow(inputs, 1.0);
    for (VectorXd& input : step.input) input *= inputs;
    return step;
  }

  double lagrangian_at(const StageStep& step, double t) {
    const optimizer::Merit* merit = program_->try_step(step, t);
    EXPECT_NE(merit, nullptr);
    double value = program_->trial_cost() + step_->end_multiplier.dot(program_->trial_end_rows());
    for (std::size_t n = 0; n < program_->trial_gaps().size(); ++n)
      value += program_->gap_multipliers()[n].dot(program_->trial_gaps()[n]);
    return value;
  }

  VectorXd gaps_at(const StageStep& step, double t) {
    EXPECT_NE(program_->try_step(step, t), nullptr);
    const std::vector<VectorXd>& gaps = program_->trial_gaps();
    VectorXd all(static_cast<Eigen::Index>(gaps.size()) * gaps[0].size());
    for (std::size_t n = 0; n < gaps.size(); ++n)
      all.segment(static_cast<Eigen::Index>(n) * gaps[0].size(), gaps[0].size()) = gaps[n];
    return all;
  }

  // sᵀHs
  double curvature(const std::vector<VectorXd>& state) const {
    double value = state.back().dot(model_->Q_end * state.back());
    for (std::size_t k = 0; k < model_->stage.size(); ++k) {
      const optimizer::Stage& stage = model_->stage[k];
      const VectorXd& v = step_->input[k];
      value += state[k].dot(stage.Q * state[k]) + 2.0 * v.dot(stage.S * state[k]) + v.dot(stage.R * v);
    }
    return value;
  }

  // The same motion with other moments: impulses are missing.
  void leave_gaps() {
    NodePath path = program_->path();
    for (VectorXd& coefficients : path.polynomial)
      for (double& c : coefficients) c += 0.3 * size_ * random_.normal();
    begin_at(path);
    EXPECT_GT(program_->gap(), 1e-2);
  }

  double second_difference(const StageStep& step, double t) {
    return (lagrangian_at(step, t) + lagrangian_at(step, -t) - 2.0 * lagrangian_at(step, 0.0)) / (t * t);
  }

  static void expect_second_order(double coarse, double fine, double expected) {
    EXPECT_GT(std::abs(expected), 0.0);
    if (std::abs(coarse - expected) > 1e-7 * std::abs(expected)) {  // else as good as exact
      EXPECT_NEAR(std::log2(std::abs((coarse - expected) / (fine - expected))) / 2.0, 2.0, 0.25)
          << coarse << " and " << fine << " of " << expected;
    }
    EXPECT_LE(std::abs((16.0 * fine - coarse) / 15.0 - expected), tolerance(1e-4) * std::abs(expected));
  }

  Random random_;
  model::System system_;
  double size_;  // N m
  Maneuver maneuver_;
  std::unique_ptr<ComposedProgram> program_;
  std::unique_ptr<StageModel> model_;
  std::unique_ptr<StageStep> step_;
};

TEST_P(ComposedDerivatives, a_march_leaves_no_gaps_and_no_total_momentum) {
  EXPECT_LE(program_->gap(), tolerance(1e-11));
  leave_gaps();
  const NodePath path = program_->path();
  maneuver::Solution solution;
  maneuver::describe_composed_motion(system_, GetParam().scheme, 0.1, path, solution);
  for (const auto* momentum : {&solution.linear_momentum, &solution.angular_momentum}) {
    double scale = 0.0;
    for (const Vector3d& p : momentum->bodies) scale = std::max(scale, p.norm());
    EXPECT_GT(scale, 1e-2);
    for (const Vector3d& p : momentum->total) EXPECT_LE(p.norm(), tolerance(1e-11) * scale);
  }
}

TEST_P(ComposedDerivatives, the_slope_of_the_lagrangian_matches_central_differences) {
  const StageStep step = step_along(1.0);
  double slope = step_->end_multiplier.dot(model_->C * step.state.back());
  for (std::size_t k = 0; k < model_->stage.size(); ++k) slope += model_->stage[k].r.dot(step.input[k]);
  expect_second_order_differences([&](double t) { return VectorXd::Constant(1, lagrangian_at(step, t)); },
                                  VectorXd::Constant(1, slope), 1e-8, 0.5);
}

TEST_P(ComposedDerivatives, the_end_rows_rates_match_central_differences) {
  const StageStep step = step_along(1.0);
  expect_second_order_differences(
      [&](double t) {
        EXPECT_NE(program_->try_step(step, t), nullptr);
        return program_->trial_end_rows();
      },
      model_->C * step.state.back(), 1e-8, 0.5);
}

TEST_P(ComposedDerivatives, a_step_of_the_model_closes_gaps_at_second_order) {
  leave_gaps();
  const StageStep step = step_along(1.0);
  const VectorXd here = gaps_at(step, 0.0);
  expect_second_order_differences([&](double t) { return gaps_at(step, t); }, -here, 1e-8, 0.5);
}

// A step's cost is judged with what its gaps are worth: without that, what the model promises does not come true to second order.
TEST_P(ComposedDerivatives, the_cost_that_a_step_is_judged_by_falls_by_what_its_gaps_are_worth) {
  leave_gaps();
  const StageStep step = step_along(1.0);
  double of_polynomials = 0.0;
  for (std::size_t k = 0; k < model_->stage.size(); ++k)
    of_polynomials += model_->stage[k].weight * program_->path().polynomial[k].dot(step.input[k]);
  const double worth = program_->merit().gaps;
  EXPECT_GT(std::abs(worth), 1e-3 * program_->cost());
  EXPECT_NEAR(program_->merit().cost, program_->cost() + worth, tolerance(1e-12) * program_->merit().cost);
  expect_second_order_differences(
      [&](double t) {
        const optimizer::Merit* merit = program_->try_step(step, t);
        EXPECT_NE(merit, nullptr);
        return VectorXd::Constant(1, merit->cost);
      },
      VectorXd::Constant(1, of_polynomials - worth), 1e-8, 0.5);
}

// (L(t) + L(−t) − 2 L(0))/t² against sᵀHs: the error falls with t².
TEST_P(ComposedDerivatives, the_curvature_of_the_lagrangian_matches_second_differences) {
  const StageStep step = step_along(1.0);
  expect_second_order(second_difference(step, 1.0), second_difference(step, 0.25), curvature(step.state));
}

// With gaps, the model's gradient holds what their closing makes of it: the part of the curvature that is odd in the inputs.
TEST_P(ComposedDerivatives, gaps_bend_the_lagrangian_as_the_model_says) {
  leave_gaps();
  const StageStep forth = step_along(1.0), back = step_along(-1.0);
  const std::vector<VectorXd> inputs_alone = follow(1.0, 0.0), gaps_alone = follow(0.0, 1.0);
  double expected = 4.0 * inputs_alone.back().dot(model_->Q_end * gaps_alone.back());
  const double weight = model_->stage[0].weight;
  for (std::size_t k = 0; k < model_->stage.size(); ++k) {
    const optimizer::Stage& stage = model_->stage[k];
    expected +=
        4.0 * (inputs_alone[k].dot(stage.Q * gaps_alone[k] + stage.q) +
               step_->input[k].dot(stage.S * gaps_alone[k] + stage.r - weight * program_->path().polynomial[k]));
  }
  const auto odd = [&](double t) { return second_difference(forth, t) - second_difference(back, t); };
  expect_second_order(odd(1.0), odd(0.25), expected);
}

INSTANTIATE_TEST_SUITE_P(
    Swimmers, ComposedDerivatives,
    ::testing::Values(ComposedSetting{"paper_chain_by_order4", ComposedSwimmer::paper_chain, Scheme::order4, true},
                      ComposedSetting{"paper_chain_by_order6_with_a_free_end", ComposedSwimmer::paper_chain,
                                      Scheme::order6, false},
                      ComposedSetting{"in_the_plane", ComposedSwimmer::in_the_plane, Scheme::order4, true},
                      ComposedSetting{"any_joint_by_order4", ComposedSwimmer::any_joint, Scheme::order4, true},
                      ComposedSetting{.name = "ends_of_any_joint",
                                      .swimmer = ComposedSwimmer::any_joint,
                                      .scheme = Scheme::order4,
                                      .rest = true,
                                      .of_joints = true},
                      ComposedSetting{"any_joint_by_order6", ComposedSwimmer::any_joint, Scheme::order6, true},
                      ComposedSetting{"leaves_of_any_joint", ComposedSwimmer::any_joint, Scheme::order4, true, true},
                      ComposedSetting{"in_fours_by_order4", ComposedSwimmer::in_fours, Scheme::order4, true, false, 4},
                      ComposedSetting{"in_fours_by_order6", ComposedSwimmer::in_fours, Scheme::order6, true, false, 5}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
