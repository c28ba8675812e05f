#include <gtest/gtest.h>

#include <Eigen/SparseCore>

#include "chains.hpp"
#include "difference_order.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using maneuver::Maneuver;
using transcription::Transcription;

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

enum class Build { paper_chain, tree, any_joint };

struct Setting {
  std::string name;
  Build build;
  mechanics::DiscreteLagrangian lagrangian;
  bool moving = false;  // start with momentum, rest free
  int spline_points = 0;
  bool free_duration = false;
  bool periodic = false;
  bool limited = false;
  bool all_costs = false;
  bool of_joints = false;  // the goal tells how joints end, and no attitude
};

class TranscriptionDerivatives : public ::testing::TestWithParam<Setting> {
 protected:
  TranscriptionDerivatives()
      : random_(GetParam().build == Build::any_joint && GetParam().moving ? 19 : 17),  // away from such jumps
        system_(swimmer()),
        transcription_(system_, maneuver(), transcription::stated_goal_rows(system_, maneuver()), limits()) {
    point_ = VectorXd(transcription_.variable_count());
    for (double& v : point_) v = random_.normal();
    if (GetParam().all_costs) {
      point_ *= 0.5;                                      // costs fall with up to the fifth power of the stretch
      point_[transcription_.variable_count() - 1] = 3.0;  // a distance, that they are divided by
    }
    direction_ = VectorXd(transcription_.variable_count());
    for (double& v : direction_) v = random_.uniform(-1.0, 1.0);
  }

  // Joints of random rotations turn by up to half a turn over a step, where logarithms bend sharply and then jump.
  static double first_step() { return GetParam().all_costs ? 1e-3 : 0.02; }

  model::SwimmerDescription swimmer() {
    if (GetParam().build == Build::paper_chain) return paper_chain();
    if (GetParam().build == Build::tree) return random_tree(random_, 5);
    model::SwimmerDescription any = random_swimmer(random_, 7);  // of all kinds of joints
    for (model::BodyDescription& body : any.bodies) body.coupling_matrix.reset();
    for (model::JointDescription& joint : any.joints) {
      if (joint.kind == model::JointKind::ball) joint.stiffness = 2.0, joint.damping = 0.3;
      if (!GetParam().all_costs || joint.kind != model::JointKind::universal) continue;
      joint.kind = model::JointKind::hinge;
      joint.axes.reset();
      joint.axis = random_.vector();
    }
    return any;
  }

  const Maneuver& maneuver() {
    if (maneuver_.steps > 0) return maneuver_;
    VectorXd velocity = VectorXd::Zero(system_.velocity_count());
    if (GetParam().moving)
      for (double& v : velocity) v = random_.normal();
    maneuver_.start =
        integrator::state_of_velocity(system_, random_rotations(random_, system_), random_.vector(), velocity);
    maneuver_.total = mechanics::spatial_momentum(system_, maneuver_.start.rotation, maneuver_.start.position,
                                                  maneuver_.start.momentum);
    for (int i = 0; i < system_.body_count(); ++i) maneuver_.end_rotation.push_back(random_.rotation());
    if (GetParam().of_joints) {
      for (const model::Joint& joint : system_.joints()) {
        const auto &parent = maneuver_.end_rotation[model::at(joint.parent)],
                   &child = maneuver_.end_rotation[model::at(joint.child)];
        maneuver_.end_joint.emplace_back(parent->transpose() * *child);
      }
      maneuver_.end_rotation.assign(maneuver_.end_rotation.size(), std::nullopt);
    }
    maneuver_.end_position = {1.0, std::nullopt, -0.5};
    maneuver_.rest = !GetParam().moving;
    maneuver_.periodic = maneuver_.free_shape = GetParam().periodic;
    maneuver_.free_duration = GetParam().free_duration;
    maneuver_.time_weight = GetParam().free_duration ? 3000.0 : 0.0;
    if (GetParam().all_costs) maneuver_.cost_weights = {70.0, 0.04, 0.3, 2.0, 200.0, Vector3d(900.0, -700.0, 500.0)};
    maneuver_.lagrangian = GetParam().lagrangian;
    maneuver_.duration = 0.5;
    maneuver_.steps = 5;
    maneuver_.spline_points = GetParam().spline_points;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.1, 5);
    return maneuver_;
  }

  std::vector<maneuver::LimitRow> limits() {
    if (!GetParam().limited) return {};
    maneuver::Problem problem;
    maneuver::Limits& limits = problem.limits;
    limits.torque = 100.0;
    limits.torque_component = 200.0;
    limits.angular_velocity = 5.0;
    limits.clearance = 0.5;
    limits.spheres = {{Vector3d(30.0, 2.0, -1.0), 2.0}};
    limits.half_spaces = {{Vector3d(0.2, 0.1, 0.0), Vector3d(1.0, 2.0, 0.5)}};
    for (const model::Joint& joint : system_.joints()) {
      limits.swing[joint.name] = 0.4;
      limits.twist[joint.name] = 0.3;
      if (joint.kind == model::JointKind::hinge || joint.kind == model::JointKind::universal)
        limits.joint_angular_velocity_component[joint.name] = 4.0;
      if (joint.kind == model::JointKind::hinge) limits.angle[joint.name] = {{-0.5, 0.7}};
      if (joint.kind == model::JointKind::universal) limits.angle[joint.name] = {{-0.5, 0.7}, {-0.4, 0.6}};
    }
    problem.duration.free = GetParam().free_duration;
    problem.duration.min = 0.3;
    problem.duration.max = 0.8;
    maneuver::Waypoint waypoint;
    waypoint.time = 0.2;
    waypoint.move = {0.3, std::nullopt, 0.1};
    waypoint.rotation[system_.body(2).name] = Vector3d(0.2, 0.5, -0.3);
    problem.waypoints = {waypoint};
    return maneuver::limit_rows(system_, problem);
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
  expect_second_order_differences(along, VectorXd::Constant(1, gradient.dot(direction_)));
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
  expect_second_order_differences(along, jacobian * direction_, 1e-9, first_step());
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
  expect_second_order_differences(along, lower.selfadjointView<Eigen::Lower>() * direction_, 1e-9, first_step());
}

// Entries have their places whatever the factor: Ipopt asks for constraints alone where it restores feasibility.
TEST_P(TranscriptionDerivatives, hessian_is_that_of_the_cost_and_that_of_the_constraints) {
  VectorXd multiplier(transcription_.constraint_count());
  for (double& v : multiplier) v = random_.normal();
  VectorXd whole, cost, constraints;
  transcription_.hessian(point_, 0.7, multiplier, whole);
  transcription_.hessian(point_, 0.0, multiplier, constraints);
  transcription_.hessian(point_, 0.7, VectorXd::Zero(multiplier.size()), cost);
  ASSERT_EQ(whole.size(), constraints.size());
  EXPECT_LE((cost + constraints - whole).norm(), 1e-12 * whole.norm());
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

using mechanics::DiscreteLagrangian;

INSTANTIATE_TEST_SUITE_P(
    Programs, TranscriptionDerivatives,
    ::testing::Values(
        Setting{"paper_chain", Build::paper_chain, DiscreteLagrangian::trapezoid},
        Setting{"paper_scheme", Build::paper_chain, DiscreteLagrangian::paper},
        Setting{"spline", Build::paper_chain, DiscreteLagrangian::trapezoid, false, 4},
        Setting{"tree", Build::tree, DiscreteLagrangian::trapezoid},
        Setting{.name = "joints_of_a_tree",
                .build = Build::tree,
                .lagrangian = DiscreteLagrangian::trapezoid,
                .of_joints = true},
        Setting{.name = "joints_of_any_joint",
                .build = Build::any_joint,
                .lagrangian = DiscreteLagrangian::trapezoid,
                .of_joints = true},
        Setting{"moving_tree", Build::tree, DiscreteLagrangian::paper, true},
        Setting{"any_joint", Build::any_joint, DiscreteLagrangian::trapezoid},
        Setting{"any_joint_moving_for_a_free_duration", Build::any_joint, DiscreteLagrangian::trapezoid, true, 0, true},
        Setting{"periodic", Build::paper_chain, DiscreteLagrangian::trapezoid, false, 0, false, true},
        Setting{"periodic_of_any_joint_for_a_free_duration", Build::any_joint, DiscreteLagrangian::trapezoid, false, 0,
                true, true},
        Setting{"within_limits", Build::paper_chain, DiscreteLagrangian::trapezoid, false, 0, false, false, true},
        Setting{"free_duration_within_limits", Build::paper_chain, DiscreteLagrangian::paper, false, 0, true, false,
                true},
        Setting{"periodic_of_any_joint_for_a_free_duration_within_limits", Build::any_joint,
                DiscreteLagrangian::trapezoid, false, 0, true, true, true},
        Setting{"all_costs", Build::paper_chain, DiscreteLagrangian::trapezoid, false, 0, false, false, false, true},
        Setting{"all_costs_of_any_joint_moving_for_a_free_duration", Build::any_joint, DiscreteLagrangian::trapezoid,
                true, 0, true, false, false, true},
        Setting{"all_costs_periodic_for_a_free_duration_within_limits", Build::paper_chain,
                DiscreteLagrangian::trapezoid, false, 0, true, true, true, true}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
