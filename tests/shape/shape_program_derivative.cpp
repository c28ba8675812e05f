#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "chains.hpp"
#include "difference_order.hpp"
#include "guess/passive_joints.hpp"
#include "shape/reach.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::ShapeCoordinates;
using optimizer::StageModel;
using optimizer::StageStep;
using shape::ShapeProgram;

enum class Swimmer { paper_chain, in_the_plane, any_joint, idle_joints };

struct ShapeSetting {
  std::string name;
  Swimmer swimmer;
  mechanics::DiscreteLagrangian lagrangian;
  bool rest = false;
  bool limited = false;
  bool free_duration = false;
  bool periodic = false;
  maneuver::CostWeights costs = {};
  bool of_leaves = false;  // the goal asks for all bodies but the root and its children
  unsigned seed = 23;
  bool turning = false;      // work's terms past where powers have any slope
  bool angle_rates = false;  // limits of angles' rates, too
  bool of_joints = false;    // the goal tells how joints end, and no attitude
  bool drifts = false;       // the start carries momentum
};

const maneuver::CostWeights of_power{.power = 3.0};
const maneuver::CostWeights of_smoothness{.smoothness = 0.01};
const maneuver::CostWeights of_work{.work = 40.0};
const maneuver::CostWeights of_transport{.transport = 30.0};
const maneuver::CostWeights of_angular_velocity{.angular_velocity = 5.0};
const maneuver::CostWeights of_all{20.0, 2.0, 0.02, 5.0, 20.0};
const maneuver::CostWeights of_displacement{.displacement = Vector3d(300.0, -200.0, 100.0)};
const maneuver::CostWeights of_worthy_displacement{.displacement = Vector3d(1e7, 0.0, 0.0)};
const maneuver::CostWeights of_worthy_displacement_back{.displacement = Vector3d(-1e7, 0.0, 0.0)};
const maneuver::CostWeights of_displacement_too{20.0, 2.0, 0.02, 5.0, 20.0, Vector3d(100.0, 200.0, -300.0)};

const maneuver::CostWeights of_all_but_smoothness{.work = 20.0,
                                                  .power = 2.0,
                                                  .angular_velocity = 20.0,
                                                  .transport = 5.0,
                                                  .displacement = Vector3d(100.0, 200.0, -300.0)};

// Every limit and two waypoints, about where random motions are.
maneuver::Problem limited_problem(const model::SwimmerDescription& swimmer, const ShapeSetting& setting) {
  maneuver::Problem problem;
  problem.swimmer = swimmer;
  problem.steps = 6;
  problem.duration.value = 0.6;
  problem.duration.free = setting.free_duration;
  problem.duration.min = 0.7;
  problem.duration.max = 0.5;
  problem.start.rotation.assign(swimmer.bodies.size(), Vector3d(0.1, 0.2, 0.3));
  if (!setting.limited) return problem;
  maneuver::Limits& limits = problem.limits;
  if (setting.swimmer == Swimmer::paper_chain ||
      setting.swimmer == Swimmer::in_the_plane) {  // a hinge's moment has a kink where it changes its sign
    limits.torque = 30.0;
    limits.torque_component = 20.0;
  }
  limits.angular_velocity = 1.0;
  limits.clearance = 0.5;
  limits.spheres = {{Vector3d(3.0, 2.0, -1.0), 2.0}};
  limits.half_spaces = {{Vector3d(0.2, 0.1, 0.0), Vector3d(1.0, 2.0, 0.5)}};
  for (const model::JointDescription& joint : swimmer.joints) {
    limits.swing[joint.name] = 0.1;
    limits.twist[joint.name] = 0.1;
    const bool angles = joint.kind == model::JointKind::hinge || joint.kind == model::JointKind::universal;
    if (setting.angle_rates && angles) limits.joint_angular_velocity_component[joint.name] = 0.6;
    if (joint.kind == model::JointKind::hinge) limits.angle[joint.name] = {{-0.05, 0.05}};
    if (joint.kind == model::JointKind::universal) limits.angle[joint.name] = {{-0.05, 0.05}, {-0.04, 0.06}};
  }
  problem.waypoints.push_back({0.2, {0.3, std::nullopt, 0.1}, std::nullopt, {}});
  problem.waypoints.push_back({0.4, {}, Vector3d(0.2, 0.1, 0.3), {}});
  return problem;
}

model::SwimmerDescription swimmer_of(Random& random, Swimmer kind) {
  const bool drawn = kind == Swimmer::any_joint || kind == Swimmer::idle_joints;
  model::SwimmerDescription swimmer = drawn ? random_swimmer(random, 5) : paper_chain();
  for (model::JointDescription& joint : swimmer.joints) {
    joint.actuated = kind != Swimmer::idle_joints || &joint != &swimmer.joints.back();
    if (kind == Swimmer::in_the_plane) joint.control_axes = {Vector3d::UnitZ()};
  }
  return swimmer;
}

// A motion of small random steps and what is asked of it: just the end that it has.
class ShapeDerivatives : public ::testing::TestWithParam<ShapeSetting> {
 protected:
  static constexpr int steps = 6;

  ShapeDerivatives() : random_(GetParam().seed), swimmer_(swimmer_of(random_, GetParam().swimmer)), system_(swimmer_) {
    const bool planar = GetParam().swimmer == Swimmer::in_the_plane;
    maneuver_.start.rotation =
        planar ? mechanics::Rotations(3, Matrix3d::Identity()) : random_rotations(random_, system_);
    maneuver_.start.position = random_.vector();
    maneuver_.start.momentum = VectorXd::Zero(system_.velocity_count());
    if (GetParam().drifts) carry_momentum();
    maneuver_.end_rotation.assign(maneuver_.start.rotation.size(), std::nullopt);
    maneuver_.rest = GetParam().rest;
    maneuver_.lagrangian = GetParam().lagrangian;
    maneuver_.duration = 0.6;
    maneuver_.steps = steps;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.1, steps);
    NodePath path;
    path.rotation.push_back(maneuver_.start.rotation);
    path.position.assign(steps + 1, maneuver_.start.position);
    for (int k = 0; k < steps; ++k) {
      mechanics::Freedoms turn = random_freedoms(random_, system_, 0.1);
      if (planar)
        for (Vector3d& t : turn) t = t.z() * Vector3d::UnitZ();
      path.rotation.push_back(turned(system_, path.rotation.back(), turn));
    }
    ShapeProgram unasked(system_, maneuver_, ShapeCoordinates(system_), {});
    EXPECT_TRUE(unasked.go_to(path));
    path = unasked.path();
    if (GetParam().of_joints) {
      EXPECT_TRUE(std::any_of(system_.joints().begin(), system_.joints().end(), [](const model::Joint& joint) {
        return joint.free() && joint.parent > 0;
      })) << "no end that bends";
    }
    if (GetParam().of_joints)
      for (const model::Joint& joint : system_.joints())
        maneuver_.end_joint.emplace_back(mechanics::child_to_parent(path.rotation.back(), joint));
    for (int i = 0; i < system_.body_count() && !GetParam().of_joints; ++i)
      if (GetParam().of_leaves ? system_.body(i).parent > 0 : i == 0 || (i == 1 && system_.body(1).freedoms == 3))
        maneuver_.end_rotation[model::at(i)] = path.rotation.back()[model::at(i)];
    maneuver_.end_position = {1.0, std::nullopt, -0.5};
    const ShapeCoordinates coordinates = shape::reachable_coordinates(system_, maneuver_, path).value();
    if (planar) {
      EXPECT_EQ(coordinates.shape.cols(), 2);
      EXPECT_EQ(coordinates.pose.cols(), 3);
    }
    if (GetParam().swimmer == Swimmer::idle_joints && GetParam().costs.any()) {
      // costs beside effort see gaps in their model's slope: without gaps it is that of the Lagrangian
      const auto followed = guess::with_passive_joints(system_, maneuver_, coordinates, path);
      EXPECT_TRUE(followed);
      path = followed.value_or(path);
    }
    maneuver_.free_duration = GetParam().free_duration;
    maneuver_.periodic = maneuver_.free_shape = GetParam().periodic;
    maneuver_.time_weight = 20.0;
    maneuver_.cost_weights = GetParam().costs;
    const auto rows = maneuver::limit_rows(system_, limited_problem(swimmer_, GetParam()));
    program_ = std::make_unique<ShapeProgram>(system_, maneuver_, coordinates,
                                              maneuver::stated_end_rows(system_, maneuver_, {}), rows);
    shape::LimitMultipliers multipliers{Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows.size()), steps + 1), 20.0,
                                        3e17};  // a barrier that is felt
    for (double& multiplier : multipliers.value.reshaped()) multiplier = 1e3 * random_.uniform(0.5, 1.0);
    program_->take_limit_multipliers(multipliers);
    // a weight so much lighter than the first keeps kinks of the work away from these powers; one so heavy has passed them
    shape::WorkMultipliers signs;
    signs.set_zero(system_.drive_count(), steps + 1);
    signs.weight = GetParam().turning ? 1.0 : 1e-10;
    signs.largest_weight = 1.0;
    Random slopes(GetParam().seed);
    for (int k = 0; k <= steps; ++k)
      for (int d = 0; d < system_.drive_count();
           ++d) {  // second axes draw by themselves: nothing else changes with them
        const bool second = d > 0 && system_.drive(d).joint == system_.drive(d - 1).joint;
        signs.mean(d, k) = (second ? slopes : random_).uniform(-0.7, 0.7);
      }
    for (double& slope : signs.change.reshaped()) slope = slopes.uniform(-0.2, 0.2);
    program_->take_work_multipliers(signs);
    EXPECT_TRUE(program_->go_to(path));
    const optimizer::StageSizes sizes = program_->sizes();
    model_ = std::make_unique<StageModel>(sizes);
    step_ = std::make_unique<StageStep>(sizes);
    // some multipliers, and a direction that obeys the model
    program_->linearize(*model_);
    const auto stated = maneuver::stated_end_rows(system_, maneuver_, {});
    for (std::size_t r = 0; r < stated.size(); ++r)  // so that the goal counts; closure bends where the step leaves it
      if (stated[r].kind != maneuver::EndRow::Kind::closure)
        step_->end_multiplier[static_cast<Eigen::Index>(r)] = 1e3 * random_.normal();
    if (program_->takes_costates())
      for (VectorXd& costate : step_->costate)
        for (double& entry : costate) entry = 1e3 * random_.normal();
    // Barriers' stiffnesses hold estimates of what limits pull, which shrink by little a step.
    for (int round = 0; round < (GetParam().limited ? 12 : 1); ++round) {
      program_->take_multipliers(*step_, 1.0);
      program_->linearize(*model_);
    }
    double size = GetParam().periodic || GetParam().free_duration ? 0.01 : 0.3;
    if (GetParam().free_duration && GetParam().swimmer == Swimmer::any_joint) size = GetParam().limited ? 0.1 : 0.03;
    if (GetParam().periodic && GetParam().costs.any()) size = 0.002;
    if (GetParam().swimmer == Swimmer::idle_joints && GetParam().limited) size = 0.002;
    const bool of_the_chain = GetParam().swimmer == Swimmer::paper_chain && GetParam().limited;
    if (of_the_chain && (GetParam().free_duration || GetParam().periodic)) size = 0.002;
    if (model_->stage.back().placed > 0) size = GetParam().limited ? 0.0005 : 0.003;  // rad, not N m
    if (GetParam().drifts && !GetParam().limited && model_->stage.back().placed > 0) size = 0.002;
    if (GetParam().drifts && GetParam().free_duration && !GetParam().limited) size *= 3.0;  // else lost in round-off
    for (std::size_t n = 0; n < model_->stage.size(); ++n) {
      for (Eigen::Index c = 0; c < sizes.inputs; ++c)
        if (!model_->stage[n].B.col(c).isZero(0.0)) step_->input[n][c] = size * random_.normal();
      step_->state[n + 1] = model_->stage[n].A * step_->state[n] + model_->stage[n].B * step_->input[n];
    }
  }

  // About as much as what turns by 0.1 rad a step; in the plane that of the plane.
  void carry_momentum() {
    Random random(GetParam().seed + 1000);
    VectorXd velocity = VectorXd::NullaryExpr(system_.velocity_count(), [&] { return 0.3 * random.normal(); });
    if (GetParam().swimmer == Swimmer::in_the_plane) {
      const Eigen::Index bodies = velocity.size() / 3 - 1;
      for (Eigen::Index i = 0; i < bodies; ++i) velocity.segment<2>(3 * i).setZero();
      velocity[3 * bodies + 2] = 0.0;
    }
    maneuver_.start =
        integrator::state_of_velocity(system_, maneuver_.start.rotation, maneuver_.start.position, velocity);
    ASSERT_TRUE(maneuver::has_momentum(system_, maneuver_.start));
  }

  // Lagrangian and end rows at t along the direction.
  double lagrangian_at(double t) {
    const optimizer::Merit* merit = program_->try_step(*step_, t);
    EXPECT_NE(merit, nullptr);
    return merit ? merit->cost + step_->end_multiplier.dot(program_->trial_end_rows()) : NAN;
  }

  VectorXd end_rows_at(double t) {
    EXPECT_NE(program_->try_step(*step_, t), nullptr);
    return program_->trial_end_rows();
  }

  // A barrier's third derivative jumps where it ends, and motions that drift in free time bend more or less.
  static int scales() {
    if (GetParam().limited) return 5;
    return GetParam().drifts && GetParam().free_duration ? 3 : 1;
  }

  double slope() const {
    double rate = model_->q_end.dot(step_->state.back()) + step_->end_multiplier.dot(model_->C * step_->state.back());
    for (std::size_t k = 0; k < model_->stage.size(); ++k)
      rate += model_->stage[k].r.dot(step_->input[k]) + model_->stage[k].q.dot(step_->state[k]);
    return rate;
  }

  double curvature() const {
    const VectorXd& end = step_->state.back();
    double value = end.dot(model_->Q_end * end);
    for (std::size_t k = 0; k < model_->stage.size(); ++k) {
      const optimizer::Stage& stage = model_->stage[k];
      const VectorXd& s = step_->state[k];
      const VectorXd& v = step_->input[k];
      value += s.dot(stage.Q * s) + 2.0 * v.dot(stage.S * s) + v.dot(stage.R * v);
    }
    return value;
  }

  Random random_;
  model::SwimmerDescription swimmer_;
  model::System system_;
  Maneuver maneuver_;
  std::unique_ptr<ShapeProgram> program_;
  std::unique_ptr<StageModel> model_;
  std::unique_ptr<StageStep> step_;
};

TEST_P(ShapeDerivatives, the_slope_of_the_lagrangian_matches_central_differences) {
  expect_second_order_differences([this](double t) { return VectorXd::Constant(1, lagrangian_at(t)); },
                                  VectorXd::Constant(1, slope()), 1e-8, 0.5, scales());
}

TEST_P(ShapeDerivatives, the_end_rows_rates_match_central_differences) {
  expect_second_order_differences([this](double t) { return end_rows_at(t); }, model_->C * step_->state.back(), 1e-8,
                                  0.5, scales());
}

// Of limits that pull, whatever they are of.
TEST_P(ShapeDerivatives, limits_change_as_foreseen_to_first_order) {
  const MatrixXd changes = program_->limit_changes(*step_);
  if (changes.rows() == 0) return;
  std::set<maneuver::LimitRow::Kind> kinds;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> pulling;
  for (Eigen::Index r = 0; r < changes.rows(); ++r)
    for (Eigen::Index k = 0; k < changes.cols(); ++k)
      if (changes(r, k) != 0.0) {
        pulling.emplace_back(r, k);
        kinds.insert(program_->limit_rows()[static_cast<std::size_t>(r)].kind);
      }
  EXPECT_GE(kinds.size(), GetParam().limited ? 4U : 1U);
  if (GetParam().limited && GetParam().periodic && GetParam().swimmer == Swimmer::paper_chain) {
    EXPECT_FALSE(changes.col(0).isZero(0.0)) << "moments at the beginning";
  }
  const auto pulling_of = [&](const MatrixXd& all) {
    VectorXd values_of(static_cast<Eigen::Index>(pulling.size()));
    for (std::size_t n = 0; n < pulling.size(); ++n)
      values_of[static_cast<Eigen::Index>(n)] = all(pulling[n].first, pulling[n].second);
    return values_of;
  };
  expect_second_order_differences(
      [&](double t) -> VectorXd {
        EXPECT_NE(program_->try_step(*step_, t), nullptr);
        return pulling_of(program_->trial_limit_values());
      },
      pulling_of(changes), 1e-8, 0.5, scales());
}

// Else no shift of the Hessian would make it positive: where the cost is less than nothing, too.
TEST_P(ShapeDerivatives, what_a_shift_adds_is_nowhere_negative) {
  const auto expect_no_less_than_nothing = [](const MatrixXd& metric) {
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(metric, Eigen::EigenvaluesOnly).eigenvalues();
    EXPECT_GE(values.minCoeff(), -1e-12 * values.cwiseAbs().maxCoeff());
  };
  for (const optimizer::Stage& stage : model_->stage) {
    const Eigen::Index n = stage.metric.rows(), m = stage.metric_input.rows();
    MatrixXd whole = MatrixXd::Zero(n + m, n + m);
    whole.topLeftCorner(n, n) = stage.metric;
    if (m > 0) {
      whole.bottomLeftCorner(m, n) = stage.metric_mixed;
      whole.topRightCorner(n, m) = stage.metric_mixed.transpose();
      whole.bottomRightCorner(m, m) = stage.metric_input;
    }
    expect_no_less_than_nothing(whole);
  }
  expect_no_less_than_nothing(model_->metric_end);
}

// First derivatives by themselves are those of the whole model; where the cost has more than effort there are none.
TEST_P(ShapeDerivatives, first_derivatives_alone_are_those_of_the_model) {
  const ShapeSetting& setting = GetParam();
  const bool plain = !setting.limited && !setting.free_duration && !setting.periodic && !setting.costs.any() &&
                     setting.swimmer != Swimmer::idle_joints && !setting.drifts;
  optimizer::StageSlopes slopes(program_->sizes());
  ASSERT_EQ(program_->differentiate(slopes), plain);
  if (!plain) return;
  ASSERT_EQ(slopes.stage.size(), model_->stage.size());
  EXPECT_EQ(model_->stage.back().placed, program_->sizes().inputs) << "moments that reach all shapes are led by them";
  for (std::size_t k = 0; k < slopes.stage.size(); ++k) {
    EXPECT_TRUE(slopes.stage[k].A.isApprox(model_->stage[k].A, 1e-12)) << k;
    EXPECT_TRUE(slopes.stage[k].B.isApprox(model_->stage[k].B, 1e-12)) << k;
    EXPECT_TRUE(slopes.stage[k].r.isApprox(model_->stage[k].r, 1e-12)) << k;
    EXPECT_LE((slopes.stage[k].q - model_->stage[k].q).norm(), 1e-12 * model_->stage[k].q.norm()) << k;
  }
  EXPECT_LE((slopes.q_end - model_->q_end).norm(), 1e-12 * model_->q_end.norm());
  EXPECT_EQ(slopes.C, model_->C);
  EXPECT_EQ(slopes.c, model_->c);
}

// (L(t) + L(−t) − 2 L(0))/t² against sᵀHs: the error falls with t².
TEST_P(ShapeDerivatives, the_curvature_of_the_lagrangian_matches_second_differences) {
  expect_second_order_curvature([this](double t) { return lagrangian_at(t); }, curvature());
}

// A step takes idle moments off to second order, one that is bent after its trial to third.
TEST_P(ShapeDerivatives, bent_gaps_take_idle_moments_off_at_third_order) {
  if (GetParam().swimmer != Swimmer::idle_joints || GetParam().costs.any()) return;
  const auto follow = [&] {
    for (std::size_t n = 0; n < model_->stage.size(); ++n)
      step_->state[n + 1] =
          model_->stage[n].A * step_->state[n] + model_->stage[n].B * step_->input[n] + model_->stage[n].gap;
  };
  const int controls = system_.control_count();
  const auto idle_moments = [&](double t) {
    EXPECT_NE(program_->try_step(*step_, t), nullptr);
    std::vector<double> values;
    const auto& moments = program_->trial_moments();
    for (std::size_t k = GetParam().periodic ? 1 : 0; k + 1 < moments.size(); ++k)
      for (Eigen::Index c = controls; c < moments[k].size(); ++c) values.push_back(moments[k][c]);
    return VectorXd(VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  follow();
  const VectorXd here = idle_moments(0.0);
  ASSERT_GT(here.size(), 0);
  ASSERT_GT(here.norm(), 0.0);
  const auto left = [&](double t) { return (idle_moments(t) - (1.0 - t) * here).norm(); };
  const auto left_when_bent = [&](double t) {
    follow();
    idle_moments(t);
    program_->bend_gaps(t, *model_);
    follow();
    program_->unbend_gaps(*model_);
    return left(t);
  };
  const double coarse = 0.02, fine = 0.01;
  const double plain_order = std::log2(left(coarse) / left(fine));
  const double bent_order = std::log2(left_when_bent(coarse) / left_when_bent(fine));
  EXPECT_NEAR(plain_order, 2.0, 0.2);
  EXPECT_NEAR(bent_order, 3.0, 0.3);
}

INSTANTIATE_TEST_SUITE_P(
    Swimmers, ShapeDerivatives,
    ::testing::Values(
        ShapeSetting{"paper_chain_by_the_trapezoid", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid,
                     true},
        ShapeSetting{"paper_chain_by_the_papers_scheme", Swimmer::paper_chain, mechanics::DiscreteLagrangian::paper,
                     true},
        ShapeSetting{"in_the_plane", Swimmer::in_the_plane, mechanics::DiscreteLagrangian::trapezoid, true},
        ShapeSetting{"any_joint_by_the_midpoint", Swimmer::any_joint, mechanics::DiscreteLagrangian::midpoint, true},
        ShapeSetting{"any_joint_with_a_free_end", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, false},
        ShapeSetting{"leaves_of_any_joint",
                     Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::trapezoid,
                     true,
                     false,
                     false,
                     false,
                     {},
                     true},
        ShapeSetting{"leaves_of_any_joint_with_a_free_end",
                     Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::midpoint,
                     false,
                     false,
                     false,
                     false,
                     {},
                     true},
        ShapeSetting{.name = "ends_of_any_joint",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                     .rest = true,
                     .seed = 24,
                     .of_joints = true},
        ShapeSetting{.name = "ends_of_any_joint_in_free_time",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                     .rest = false,
                     .free_duration = true,
                     .seed = 24,
                     .of_joints = true},
        ShapeSetting{"paper_chain_within_limits", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true,
                     true},
        ShapeSetting{.name = "any_joint_within_limits",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                     .rest = true,
                     .limited = true},
        ShapeSetting{"in_the_plane_within_limits", Swimmer::in_the_plane, mechanics::DiscreteLagrangian::trapezoid,
                     false, true},
        ShapeSetting{"free_duration", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true, false,
                     true},
        ShapeSetting{"free_duration_within_limits", Swimmer::paper_chain, mechanics::DiscreteLagrangian::paper, true,
                     true, true},
        ShapeSetting{"periodic", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, false, false, false,
                     true},
        ShapeSetting{"periodic_of_any_joint_within_limits",
                     Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::trapezoid,
                     false,
                     true,
                     false,
                     true,
                     {},
                     false},
        ShapeSetting{"periodic_within_limits", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, false,
                     true, false, true},
        ShapeSetting{"periodic_of_free_duration", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, false,
                     false, true, true},
        ShapeSetting{"free_duration_of_any_joint", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, true,
                     false, true},
        ShapeSetting{"free_duration_of_any_joint_with_a_free_end", Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::midpoint, false, false, true},
        ShapeSetting{.name = "free_duration_of_any_joint_within_limits",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                     .rest = true,
                     .limited = true,
                     .free_duration = true},
        ShapeSetting{"periodic_of_any_joint_in_free_time", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid,
                     false, false, true, true},
        ShapeSetting{"all_costs_of_any_joint_in_free_time", Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::trapezoid, true, false, true, false, of_all},
        ShapeSetting{"all_costs_of_a_periodic_motion_of_any_joint_in_free_time", Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::trapezoid, false, false, true, true, of_all},
        ShapeSetting{"worthy_displacement_in_free_time", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid,
                     true, false, true, false, of_worthy_displacement},
        ShapeSetting{"worthy_displacement_back_in_free_time", Swimmer::paper_chain,
                     mechanics::DiscreteLagrangian::trapezoid, true, false, true, false, of_worthy_displacement_back},
        ShapeSetting{"squared_power", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true, false,
                     false, false, of_power},
        ShapeSetting{"squared_power_of_any_joint", Swimmer::any_joint, mechanics::DiscreteLagrangian::midpoint, true,
                     false, false, false, of_power},
        ShapeSetting{"smoothness_of_any_joint", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, true,
                     false, false, false, of_smoothness},
        ShapeSetting{"angular_velocity", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true, false,
                     false, false, of_angular_velocity},
        ShapeSetting{"angular_velocity_of_a_periodic_motion_of_any_joint_in_free_time", Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::midpoint, false, false, true, true, of_angular_velocity},
        ShapeSetting{"work_of_any_joint", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, true, false,
                     false, false, of_work},
        ShapeSetting{"work_with_a_free_end", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, false, false,
                     false, false, of_work},
        ShapeSetting{"transport", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true, false, false,
                     false, of_transport},
        ShapeSetting{"displacement_of_any_joint", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid, true,
                     false, false, false, of_displacement},
        ShapeSetting{"displacement_of_a_periodic_motion_in_free_time", Swimmer::paper_chain,
                     mechanics::DiscreteLagrangian::midpoint, false, false, true, true, of_displacement},
        ShapeSetting{"displacement_in_the_plane_and_all_costs", Swimmer::in_the_plane,
                     mechanics::DiscreteLagrangian::trapezoid, true, true, false, false, of_displacement_too, false},
        ShapeSetting{"idle_joints", Swimmer::idle_joints, mechanics::DiscreteLagrangian::trapezoid, true},
        ShapeSetting{"idle_joints_with_a_free_end", Swimmer::idle_joints, mechanics::DiscreteLagrangian::midpoint,
                     false},
        ShapeSetting{"idle_joints_in_free_time", Swimmer::idle_joints, mechanics::DiscreteLagrangian::paper, true,
                     false, true},
        ShapeSetting{"periodic_of_idle_joints", Swimmer::idle_joints, mechanics::DiscreteLagrangian::trapezoid, false,
                     false, false, true},
        ShapeSetting{"periodic_of_idle_joints_in_free_time_within_limits",
                     Swimmer::idle_joints,
                     mechanics::DiscreteLagrangian::trapezoid,
                     false,
                     true,
                     true,
                     true,
                     {},
                     false},
        ShapeSetting{"all_costs_of_idle_joints", Swimmer::idle_joints, mechanics::DiscreteLagrangian::trapezoid, true,
                     false, false, false, of_all},
        ShapeSetting{"all_costs_in_free_time", Swimmer::paper_chain, mechanics::DiscreteLagrangian::trapezoid, true,
                     false, true, false, of_all},
        ShapeSetting{"all_costs_of_any_joint_within_limits", Swimmer::any_joint,
                     mechanics::DiscreteLagrangian::trapezoid, true, true, false, false, of_all, false},
        ShapeSetting{"all_costs_in_the_plane", Swimmer::in_the_plane, mechanics::DiscreteLagrangian::midpoint, true,
                     false, false, false, of_all},
        ShapeSetting{"all_costs_of_a_periodic_motion", Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid,
                     false, false, false, true, of_all},
        ShapeSetting{
            .name = "all_costs_of_a_periodic_motion_of_free_duration",
            .swimmer = Swimmer::paper_chain,
            .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
            .rest = false,
            .free_duration = true,
            .periodic = true,
            .costs = of_all,
        },
        ShapeSetting{.name = "any_joint_within_angle_rates",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                     .rest = true,
                     .limited = true,
                     .angle_rates = true},
        ShapeSetting{.name = "free_duration_of_any_joint_within_angle_rates",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                     .rest = true,
                     .limited = true,
                     .free_duration = true,
                     .angle_rates = true},
        ShapeSetting{.name = "work_of_joints_that_turn_back",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                     .rest = true,
                     .costs = of_work,
                     .seed = 34,
                     .turning = true},
        ShapeSetting{.name = "all_costs_of_joints_that_turn_back_in_free_time",
                     .swimmer = Swimmer::paper_chain,
                     .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                     .rest = true,
                     .free_duration = true,
                     .costs = of_all,
                     .turning = true},
        ShapeSetting{.name = "all_costs_of_joints_that_turn_back_again_and_again",
                     .swimmer = Swimmer::any_joint,
                     .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                     .rest = false,
                     .free_duration = true,
                     .periodic = true,
                     .costs = of_all,
                     .turning = true}),
    [](const auto& instance) { return instance.param.name; });

// Trees of other shapes, joints, springs and dampers.
std::vector<ShapeSetting> other_trees(bool free_duration, unsigned last, bool drifts = false, bool to_rest = false) {
  std::vector<ShapeSetting> settings;
  for (unsigned seed = 1; seed <= last; ++seed) {
    Random random(seed);
    if (maneuver::shape_size(model::System(swimmer_of(random, Swimmer::any_joint))) == 0) continue;  // all joints fixed
    ShapeSetting setting{"seed_" + std::to_string(seed), Swimmer::any_joint, mechanics::DiscreteLagrangian::trapezoid,
                         seed % 2 == 0};
    if (seed % 3 == 0) setting.lagrangian = mechanics::DiscreteLagrangian::paper;
    setting.of_leaves = seed % 5 == 0;
    setting.free_duration = free_duration;
    setting.drifts = drifts;
    setting.rest = to_rest || (setting.rest && !drifts);
    setting.seed = seed;
    settings.push_back(setting);
  }
  return settings;
}

INSTANTIATE_TEST_SUITE_P(Drifting, ShapeDerivatives,
                         ::testing::Values(ShapeSetting{.name = "paper_chain",
                                                        .swimmer = Swimmer::paper_chain,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .drifts = true},
                                           ShapeSetting{.name = "paper_chain_by_the_papers_scheme",
                                                        .swimmer = Swimmer::paper_chain,
                                                        .lagrangian = mechanics::DiscreteLagrangian::paper,
                                                        .drifts = true},
                                           ShapeSetting{.name = "any_joint_by_the_midpoint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                                                        .drifts = true},
                                           ShapeSetting{.name = "in_the_plane",
                                                        .swimmer = Swimmer::in_the_plane,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .drifts = true},
                                           ShapeSetting{.name = "paper_chain_within_limits",
                                                        .swimmer = Swimmer::paper_chain,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .limited = true,
                                                        .drifts = true},
                                           ShapeSetting{.name = "any_joint_within_limits",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::midpoint,
                                                        .limited = true,
                                                        .drifts = true},
                                           ShapeSetting{.name = "all_costs_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_all_but_smoothness,
                                                        .drifts = true},
                                           ShapeSetting{.name = "power_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_power,
                                                        .drifts = true},
                                           ShapeSetting{.name = "work_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_work,
                                                        .drifts = true},
                                           ShapeSetting{.name = "transport_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_transport,
                                                        .drifts = true},
                                           ShapeSetting{.name = "angular_velocity_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_angular_velocity,
                                                        .drifts = true},
                                           ShapeSetting{.name = "displacement_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .costs = of_displacement,
                                                        .drifts = true},
                                           ShapeSetting{.name = "idle_joints",
                                                        .swimmer = Swimmer::idle_joints,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .drifts = true},
                                           ShapeSetting{.name = "ends_of_any_joint",
                                                        .swimmer = Swimmer::any_joint,
                                                        .lagrangian = mechanics::DiscreteLagrangian::trapezoid,
                                                        .seed = 24,
                                                        .of_joints = true,
                                                        .drifts = true}),
                         [](const auto& instance) { return instance.param.name; });

// A setting and others that differ from it in a swimmer and by some change.
struct Variant {
  const char* name;
  Swimmer swimmer;
  void (*change)(ShapeSetting&);
};

std::vector<ShapeSetting> variants_of(const ShapeSetting& first, std::initializer_list<Variant> variants) {
  std::vector<ShapeSetting> settings{first};
  for (const Variant& variant : variants) {
    settings.push_back(first);
    settings.back().name = variant.name;
    settings.back().swimmer = variant.swimmer;
    variant.change(settings.back());
  }
  return settings;
}

// Joints that end at rest on a whole that drifts: what the last moments leave them depends on the last shape and pose.
std::vector<ShapeSetting> drifting_to_rest() {
  using enum mechanics::DiscreteLagrangian;
  const ShapeSetting to_rest{
      .name = "paper_chain", .swimmer = Swimmer::paper_chain, .lagrangian = trapezoid, .rest = true, .drifts = true};
  return variants_of(
      to_rest, {
                   {"by_the_papers_scheme", Swimmer::paper_chain, [](ShapeSetting& s) { s.lagrangian = paper; }},
                   {"any_joint_by_the_midpoint", Swimmer::any_joint, [](ShapeSetting& s) { s.lagrangian = midpoint; }},
                   {"in_the_plane", Swimmer::in_the_plane, [](ShapeSetting&) {}},
                   {"idle_joints", Swimmer::idle_joints, [](ShapeSetting&) {}},
                   {"paper_chain_within_limits", Swimmer::paper_chain, [](ShapeSetting& s) { s.limited = true; }},
                   {"any_joint_within_limits", Swimmer::any_joint, [](ShapeSetting& s) { s.limited = true; }},
                   {"all_costs_of_any_joint", Swimmer::any_joint, [](ShapeSetting& s) { s.costs = of_all; }},
                   {"work_of_any_joint", Swimmer::any_joint, [](ShapeSetting& s) { s.costs = of_work; }},
                   {"smoothness_of_any_joint", Swimmer::any_joint, [](ShapeSetting& s) { s.costs = of_smoothness; }},
                   {"joints_told", Swimmer::any_joint, [](ShapeSetting& s) { s.of_joints = true, s.seed = 24; }},
               });
}

// Where time is free the root's motion answers to how much is carried over a step.
std::vector<ShapeSetting> drifting_in_free_time() {
  using enum mechanics::DiscreteLagrangian;
  const ShapeSetting chain{.name = "paper_chain",
                           .swimmer = Swimmer::paper_chain,
                           .lagrangian = trapezoid,
                           .free_duration = true,
                           .drifts = true};
  return variants_of(
      chain,
      {
          {"by_the_papers_scheme", Swimmer::paper_chain, [](ShapeSetting& s) { s.lagrangian = paper; }},
          {"any_joint_by_the_midpoint", Swimmer::any_joint, [](ShapeSetting& s) { s.lagrangian = midpoint; }},
          {"in_the_plane", Swimmer::in_the_plane, [](ShapeSetting&) {}},
          {"idle_joints", Swimmer::idle_joints, [](ShapeSetting&) {}},
          {"paper_chain_within_limits", Swimmer::paper_chain, [](ShapeSetting& s) { s.limited = true; }},
          {"any_joint_within_angle_rates", Swimmer::any_joint,
           [](ShapeSetting& s) { s.limited = s.angle_rates = true; }},
          {"all_costs_of_any_joint", Swimmer::any_joint, [](ShapeSetting& s) { s.costs = of_all_but_smoothness; }},
          {"joints_told", Swimmer::any_joint, [](ShapeSetting& s) { s.of_joints = true, s.seed = 24; }},
          {"to_rest", Swimmer::paper_chain, [](ShapeSetting& s) { s.rest = true; }},
          {"any_joint_to_rest_by_the_midpoint", Swimmer::any_joint,
           [](ShapeSetting& s) { s.rest = true, s.lagrangian = midpoint; }},
          {"to_rest_in_the_plane", Swimmer::in_the_plane, [](ShapeSetting& s) { s.rest = true; }},
          {"to_rest_of_idle_joints", Swimmer::idle_joints, [](ShapeSetting& s) { s.rest = true; }},
          {"to_rest_within_limits", Swimmer::any_joint, [](ShapeSetting& s) { s.rest = s.limited = true; }},
          {"to_rest_at_all_costs", Swimmer::any_joint, [](ShapeSetting& s) { s.rest = true, s.costs = of_all; }},
      });
}

INSTANTIATE_TEST_SUITE_P(DriftingInFreeTime, ShapeDerivatives, ::testing::ValuesIn(drifting_in_free_time()),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(DriftingTreesInFreeTime, ShapeDerivatives, ::testing::ValuesIn(other_trees(true, 40, true)),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(DriftingTreesToRestInFreeTime, ShapeDerivatives,
                         ::testing::ValuesIn(other_trees(true, 40, true, true)),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(DriftingToRest, ShapeDerivatives, ::testing::ValuesIn(drifting_to_rest()),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(DriftingTreesToRest, ShapeDerivatives, ::testing::ValuesIn(other_trees(false, 40, true, true)),
                         [](const auto& instance) { return instance.param.name; });
INSTANTIATE_TEST_SUITE_P(DriftingTrees, ShapeDerivatives, ::testing::ValuesIn(other_trees(false, 40, true)),
                         [](const auto& instance) { return instance.param.name; });

INSTANTIATE_TEST_SUITE_P(Trees, ShapeDerivatives, ::testing::ValuesIn(other_trees(false, 40)),
                         [](const auto& instance) { return instance.param.name; });

std::vector<ShapeSetting> within_limits(std::vector<ShapeSetting> settings) {
  for (ShapeSetting& setting : settings) setting.limited = true;
  return settings;
}

INSTANTIATE_TEST_SUITE_P(TreesWithinLimits, ShapeDerivatives,
                         ::testing::ValuesIn(within_limits(other_trees(false, 25))),
                         [](const auto& instance) { return instance.param.name; });

INSTANTIATE_TEST_SUITE_P(TreesInFreeTime, ShapeDerivatives, ::testing::ValuesIn(other_trees(true, 25)),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
