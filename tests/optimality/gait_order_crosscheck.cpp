// The test of second order of gaits against dense linear algebra on second differences of the Lagrangian's value, which take
// nothing but marches from perturbed starts under perturbed moments.
#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <functional>

#include "certificate/certify.hpp"
#include "evidence/balance.hpp"
#include "evidence/control_space.hpp"
#include "evidence/cost_check.hpp"
#include "evidence/goal_check.hpp"
#include "integrator/step_derivatives.hpp"
#include "marched_answers.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/first_order.hpp"
#include "optimality/gait_phase.hpp"
#include "optimality/second_order.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using evidence::StoredMotion;
using model::at;
using optimality::SecondOrder;

// Unknowns are the logarithm of the duration, the first shape, its momenta, and the moments at all nodes, in units of order
// one; impulses h²u and h μ are held where the duration changes.
class DenseMotion {
 public:
  DenseMotion(const maneuver::Problem& problem, const maneuver::Solution& solution)
      : system_(problem.swimmer),
        problem_(problem),
        motion_(system_, problem_, solution),
        scale_(evidence::check_balance(motion_).scale),
        states_(evidence::node_states(motion_)),
        start_rate_(evidence::powers_of(motion_).start),
        value_(evidence::control_space(motion_).value),
        freedoms_(system_.velocity_count() - 6),
        inertia_(mechanics::generalized_inertia(system_, states_.front().rotation).inverse().diagonal().cwiseInverse()),
        unit_(inertia_.segment(3, freedoms_) / (motion_.time_step * motion_.steps)) {
    const VectorXd weights = optimality::node_weights(motion_);
    moment_ = moment_units();
    effort_ = 0.0;
    metric_ = VectorXd::Zero(size());
    for (Eigen::Index c = 0; c < value_.size(); ++c) {
      const double weight = weights[c / system_.control_count()];
      effort_ += 0.5 * weight * value_[c] * value_[c];
      metric_[first_moment() + c] = weight * moment_[c] * moment_[c];
    }
    metric_.head(first_moment()).setConstant(2e-3 * effort_);
    if (problem.duration.free) metric_[0] = 8.0 * effort_;
    if (problem.cost_weights.work + problem.cost_weights.transport > 0.0) hold_powers();
    for (const maneuver::LimitMultiplier& own : solution.limit_multipliers)
      for (int k = 0; k <= motion_.steps; ++k) {
        const bool torque = own.key == "limits.torque", end = k == 0 || k == motion_.steps;
        const double pull = own.multiplier[at(k)] * motion_.time_step * (torque && end ? 0.5 : 1.0);
        if (pull > 0.0 && (torque || k > 0)) held_.push_back({k, own.joint, torque, own.upper, pull});
      }
  }

  std::size_t held(bool torque) const {
    return static_cast<std::size_t>(std::count_if(
        held_.begin(), held_.end(), [&](const Held& own) { return own.power == 0 && own.torque == torque; }));
  }

  SecondOrder certified() const {
    const double kkt = optimality::kkt_residual(motion_, evidence::control_space(motion_), scale_);
    return optimality::second_order(motion_, scale_, kkt).value_or(SecondOrder());
  }

  // All eigenvalues by the definition.
  VectorXd eigenvalues(double step = 2e-3) {
    EXPECT_LE(evaluate(VectorXd::Zero(size())).second.norm(), 1e-6) << "the march is another motion";
    const MatrixXd J = jacobian(1e-3);
    const Eigen::Index asked = J.rows() - static_cast<Eigen::Index>(held_.size());
    multipliers_.resize(J.rows());
    for (std::size_t r = 0; r < held_.size(); ++r) multipliers_[asked + static_cast<Eigen::Index>(r)] = -held_[r].pull;
    const VectorXd slope =
        cost_slope(1e-3) + J.bottomRows(J.rows() - asked).transpose() * multipliers_.tail(J.rows() - asked);
    Eigen::JacobiSVD<MatrixXd> ranked(J.topRows(asked).transpose(), Eigen::ComputeThinU | Eigen::ComputeThinV);
    ranked.setThreshold(1e-8);
    multipliers_.head(asked) = ranked.solve(-slope);
    EXPECT_LE((slope + J.topRows(asked).transpose() * multipliers_.head(asked)).norm(), 1e-5 * slope.norm());
    Eigen::FullPivLU<MatrixXd> lu(J);
    lu.setThreshold(1e-8);
    const MatrixXd Z = lu.kernel();
    const MatrixXd coarse = Z.transpose() * hessian(step) * Z, fine = Z.transpose() * hessian(0.5 * step) * Z;
    const MatrixXd finest = Z.transpose() * hessian(0.25 * step) * Z;
    EXPECT_NEAR(std::log2((coarse - fine).norm() / (fine - finest).norm()), 2.0, 0.3) << "order of the differences";
    const MatrixXd reduced = (64.0 * finest - 20.0 * fine + coarse) / 45.0;
    return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(reduced, Z.transpose() * metric_.asDiagonal() * Z,
                                                              Eigen::EigenvaluesOnly)
        .eigenvalues();
  }

 private:
  // A limit of a hinge that pulls: its angle, or its moment.
  struct Held {
    int node, joint;
    bool torque, upper;
    double pull;
    int power = 0;  // 1, 2: mean and change of that drive's (in the place of a joint) at the node, which have to vanish
  };

  // The only moment of a hinge's or universal joint's drive, as the joint's moments are counted.
  Vector3d axis_of(const model::Drive& drive) const {
    const model::Joint& joint = system_.joint(drive.joint);
    return joint.actuation.col(drive.first_control - joint.first_control);
  }

  // Powers of hinges and universal joints that must not leave 0: what multipliers are worth along a moment, or along rates, is less than the work.
  void hold_powers() {
    const evidence::Powers powers = evidence::powers_of(motion_);
    const double vanishing = 1e-5 * powers.value.cwiseAbs().maxCoeff();
    turning_.setConstant(system_.drive_count(), motion_.steps + 1, false);
    for (int d = 0; d < system_.drive_count(); ++d)
      for (int k = gait() ? 1 : 0; k <= motion_.steps; ++k) {
        const model::Drive& drive = system_.drive(d);
        if (drive.controls == 0) continue;
        const double mean = powers.value(d, k), change = powers.change(d, k);
        if (std::max(std::abs(mean), std::abs(change)) > vanishing) {
          turning_(d, k) = std::abs(mean) < std::abs(change);
          continue;
        }
        const double S = motion_.solution.work_multipliers[at(d)][at(k)];
        const double D = motion_.solution.work_change_multipliers[at(d)][at(k)];
        const Vector3d axis = axis_of(drive);
        const std::size_t j = at(drive.joint);
        const double rate = axis.dot(powers.rate[at(k)][j]), swing = axis.dot(powers.swing[at(k)][j]);
        const bool acts = std::abs(axis.dot(motion_.control[at(k)][j])) > 1e-5 * value_.lpNorm<Eigen::Infinity>();
        const double most =
            std::abs(rate) > std::abs(swing) ? std::abs(rate) : (rate * rate + swing * swing) / (2.0 * std::abs(swing));
        if (acts ? S * S + 2.0 * std::abs(D) > 1.0 - 2e-5 : std::abs(S * rate + D * swing) > (1.0 - 1e-5) * most)
          continue;
        held_.push_back({k, d, false, false, 0.0, 1});
        if (acts) held_.push_back({k, d, false, false, 0.0, 2});
      }
  }

  double power_unit() const {
    return problem_.cost_weights.any() ? effort_ / (motion_.time_step * motion_.steps) : 1.0;
  }

  // Chapter 13 with slopes by powers as their multipliers have them, but where a power changes its sign over its node: no
  // more than the cost, and equal to it here. Returns the powers and what they change by, [N + 1][drives][2].
  VectorXd add_other_costs(const std::vector<mechanics::Rotations>& rotation, double distance,
                           const NodeMoments& control, const VectorXd& moments, double h, double& cost) const {
    const maneuver::CostWeights& weights = problem_.cost_weights;
    const int N = motion_.steps, drives = system_.drive_count();
    VectorXd powers = VectorXd::Zero(2 * drives * (N + 1));
    if (!weights.any()) return powers;
    const auto turn = [&](int k, const model::Joint& joint) {
      const Matrix3d Q = mechanics::child_to_parent(rotation[at(k)], joint);
      const Matrix3d Q_next = mechanics::child_to_parent(rotation[at(k + 1)], joint);
      if (joint.free()) return Vector3d(lie::log(Q_next * Q.transpose()));
      return Vector3d(mechanics::joint_angles(joint, Q_next) - mechanics::joint_angles(joint, Q));
    };
    double work = 0.0;
    for (int k = gait() ? 1 : 0; k <= N; ++k)
      for (int d = 0; d < drives; ++d) {
        const model::Drive& drive = system_.drive(d);
        const model::Joint& joint = system_.joint(drive.joint);
        Vector3d u = control[at(k)][at(drive.joint)];
        if (joint.kind == model::JointKind::universal) u = axis_of(drive).dot(u) * axis_of(drive);
        const Vector3d before = k > 0 ? turn(k - 1, joint) : Vector3d(h * start_rate_[at(drive.joint)]);
        const Vector3d after = k < N ? turn(k, joint) : gait() ? turn(0, joint) : Vector3d::Zero();
        const double mean = -u.dot(after + before) / (2.0 * h);
        const double change = -u.dot(after - before) / (2.0 * h);
        const double time = !gait() && (k == 0 || k == N) ? 0.5 * h : h;
        if (turning_.size() > 0 && turning_(d, k))
          work += time * 0.5 * (mean * mean + change * change) / std::abs(change);
        else if (turning_.size() > 0)
          work += time * (mean * motion_.solution.work_multipliers[at(d)][at(k)] +
                          change * motion_.solution.work_change_multipliers[at(d)][at(k)]);
        cost += time * weights.power * (mean * mean + change * change / 3.0);
        powers.segment<2>(2 * (k * drives + d)) = Eigen::Vector2d(mean, change);
      }
    const Eigen::Index controls = system_.control_count(), later = moments.size() - controls;
    cost += (weights.work + weights.transport / distance) * work +
            0.5 * weights.smoothness / h * (moments.tail(later) - moments.head(later)).squaredNorm();
    for (int k = 0; k < N; ++k)
      for (const model::Joint& joint : system_.joints())
        cost += 0.5 * weights.angular_velocity / h * (joint.actuation.transpose() * turn(k, joint)).squaredNorm();
    return powers;
  }

  Eigen::Index first_shape() const { return problem_.duration.free ? 1 : 0; }
  bool gait() const { return problem_.goal->periodic; }
  Eigen::Index first_momentum() const { return first_shape() + (problem_.start.free_shape ? freedoms_ : 0); }
  Eigen::Index first_moment() const { return first_momentum() + (gait() ? freedoms_ : 0); }
  Eigen::Index size() const { return first_moment() + value_.size(); }

  // Moments are alike where they turn slender bodies alike, whatever the axis.
  VectorXd moment_units() const {
    VectorXd share(system_.control_count());
    Eigen::Index first = 0;
    for (const model::Joint& joint : system_.joints())
      for (Eigen::Index c = 0; c < joint.actuation.cols(); ++c, ++first) {
        const model::Body& child = system_.body(joint.child);
        share[first] = joint.actuation.cols() == child.freedoms ? inertia_[child.velocity_offset + c]
                                                                : inertia_[child.velocity_offset + 2];
      }
    share *= value_.lpNorm<Eigen::Infinity>() / share.maxCoeff();
    return share.replicate(motion_.steps + 1, 1);
  }

  // Cost and what has to vanish: goal and closure.
  std::pair<double, VectorXd> evaluate(const VectorXd& x) const {
    const double tau = problem_.duration.free ? x[0] : 0.0, h = motion_.time_step * std::exp(tau);
    integrator::State state = states_.front();
    const integrator::StateLayout layout{system_};
    mechanics::Freedoms turn(state.rotation.size(), Vector3d::Zero());
    Eigen::Index entry = 0;
    for (int i = 1; i < system_.body_count() && gait(); ++i)
      for (int f = 0; f < system_.body(i).freedoms; ++f, ++entry) {
        if (problem_.start.free_shape) turn[at(i)][f] = x[first_shape() + entry];
        state.momentum[layout.freedom(i) + f] += unit_[entry] * x[first_momentum() + entry];
      }
    state.rotation = turned(system_, state.rotation, turn);
    Vector3d root = Vector3d::Zero();
    for (int i = 1; i < system_.body_count(); ++i)
      if (system_.body(i).freedoms == 3)
        root -= state.rotation[0].transpose() * state.rotation[at(i)] * state.momentum.segment<3>(layout.freedom(i));
    state.momentum.segment<3>(layout.freedom(0)) = root;
    if (gait()) state.momentum *= std::exp(-tau);  // that of a start is given
    const integrator::State start = state;

    const VectorXd moments = std::exp(-2.0 * tau) * (value_ + moment_.cwiseProduct(x.tail(value_.size())));
    const NodeMoments control = moments_along_joints(system_, moments, motion_.steps);
    integrator::StepWorkspace work(system_);
    work.sought_residual = 0.0;
    std::vector<mechanics::Rotations> rotation = {state.rotation};
    for (int k = 0; k < motion_.steps; ++k) {
      evidence::read_interval(motion_, k, work.interval);  // next to which the step is: bodies may turn far in it
      work.begun = true;
      EXPECT_TRUE(integrator::advance(system_, motion_.lagrangian, h, control[at(k)], control[at(k + 1)], state, work)
                      .converged);
      rotation.push_back(state.rotation);
    }
    double cost = problem_.time_weight * h * motion_.steps;
    const VectorXd weights = std::exp(tau) * optimality::node_weights(motion_);
    for (Eigen::Index c = 0; c < moments.size(); ++c)
      cost += 0.5 * weights[c / system_.control_count()] * moments[c] * moments[c];

    std::vector<double> rows;
    const auto push = [&](const Vector3d& v, int count) { rows.insert(rows.end(), v.data(), v.data() + count); };
    const auto asked = evidence::asked_rotations(system_, problem_);
    for (std::size_t i = 0; i < asked.size(); ++i)
      if (asked[i]) push(lie::log(asked[i]->transpose() * state.rotation[i]), 3);
    for (int c = 0; c < 3; ++c)
      if (problem_.goal->move[at(c)])
        rows.push_back(state.position[c] - start.position[c] - *problem_.goal->move[at(c)]);
    const Matrix3d back = start.rotation[0] * state.rotation[0].transpose();  // the whole turned as at the start
    mechanics::Rotations seen = state.rotation;
    for (Matrix3d& R : seen) R = back * R;
    const mechanics::Freedoms off = turns_between(system_, start.rotation, seen);
    entry = 0;
    for (int i = 1; i < system_.body_count(); ++i) {
      if (gait()) push(off[at(i)], system_.body(i).freedoms);
      for (int f = 0; f < system_.body(i).freedoms; ++f, ++entry) {
        const double asked_for = gait() ? start.momentum[layout.freedom(i) + f] : 0.0;
        rows.push_back(std::exp(tau) * (state.momentum[layout.freedom(i) + f] - asked_for) / unit_[entry]);
      }
    }
    if (gait() && problem_.cost_weights.any())
      for (Eigen::Index c = 0; c < system_.control_count(); ++c)
        rows.push_back((moments[c] - moments[moments.size() - system_.control_count() + c]) / moment_[c]);
    cost -= problem_.cost_weights.displacement.dot(state.position - start.position);
    const VectorXd powers =
        add_other_costs(rotation, (state.position - start.position).norm(), control, moments, h, cost);
    for (const Held& own : held_) {
      const model::Joint& joint = system_.joint(own.power > 0 ? 0 : own.joint);
      const auto angle = [&] {
        return mechanics::joint_angles(joint, mechanics::child_to_parent(rotation[at(own.node)], joint))[0];
      };
      if (own.power > 0)
        rows.push_back(powers[2 * (own.node * system_.drive_count() + own.joint) + own.power - 1] / power_unit());
      else if (own.torque)
        rows.push_back(*problem_.limits.torque - control[at(own.node)][at(own.joint)].norm());
      else
        rows.push_back(own.upper ? problem_.limits.angle.at(joint.name)[0][1] - angle()
                                 : angle() - problem_.limits.angle.at(joint.name)[0][0]);
    }
    return {cost, Eigen::Map<VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size()))};
  }

  double lagrangian(const VectorXd& x) const {
    const auto [cost, rows] = evaluate(x);
    return cost + multipliers_.dot(rows);
  }

  MatrixXd jacobian(double step) const {
    MatrixXd result(evaluate(VectorXd::Zero(size())).second.size(), size());
    for (Eigen::Index c = 0; c < size(); ++c) {
      const auto row = [&](double e) { return evaluate(e * VectorXd::Unit(size(), c)).second; };
      result.col(c) = (8.0 * (row(step) - row(-step)) - (row(2.0 * step) - row(-2.0 * step))) / (12.0 * step);
    }
    return result;
  }

  VectorXd cost_slope(double step) const {
    VectorXd result(size());
    for (Eigen::Index c = 0; c < size(); ++c) {
      const auto cost = [&](double e) { return evaluate(e * VectorXd::Unit(size(), c)).first; };
      result[c] = (8.0 * (cost(step) - cost(-step)) - (cost(2.0 * step) - cost(-2.0 * step))) / (12.0 * step);
    }
    return result;
  }

  MatrixXd hessian(double step) const {
    const double here = lagrangian(VectorXd::Zero(size()));
    MatrixXd result(size(), size());
    const auto along = [&](const VectorXd& direction) {
      return (lagrangian(step * direction) + lagrangian(-step * direction) - 2.0 * here) / (step * step);
    };
    for (Eigen::Index a = 0; a < size(); ++a) result(a, a) = along(VectorXd::Unit(size(), a));
    for (Eigen::Index a = 0; a < size(); ++a)
      for (Eigen::Index b = 0; b < a; ++b) {
        const double both = along(VectorXd::Unit(size(), a) + VectorXd::Unit(size(), b));
        result(a, b) = result(b, a) = 0.5 * (both - result(a, a) - result(b, b));
      }
    return result;
  }

  model::System system_;
  maneuver::Problem problem_;
  StoredMotion motion_;
  double scale_;
  std::vector<integrator::State> states_;
  mechanics::Vectors start_rate_;  // [joints] rad/s
  VectorXd value_;
  Eigen::Index freedoms_;
  VectorXd inertia_;  // of each freedom when all others are free to follow
  VectorXd unit_;     // momenta that alone turn by 1 rad in the whole time
  double effort_ = 0.0;
  std::vector<Held> held_;
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>
      turning_;  // [drives][N + 1] powers that change their sign over the node
  VectorXd moment_, metric_, multipliers_;
};

maneuver::Solution solved_gait(const maneuver::Problem& problem) {
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  return answer.solution;
}

void expect_eigenvalues_of_gait(const maneuver::Problem& problem, const maneuver::Solution& solution, bool positive,
                                double accuracy = 1e-4) {
  DenseMotion dense(problem, solution);
  const VectorXd values = dense.eigenvalues();
  const SecondOrder found = dense.certified();
  EXPECT_NEAR(found.smallest_eigenvalue, values[0], tolerance(accuracy) * std::max(1e-1, std::abs(values[0])));
  EXPECT_NE(found.smallest_eigenvalue, values[0]);
  EXPECT_EQ(found.negative_eigenvalues.value_or(-1), (values.array() < 0.0).count());
  EXPECT_EQ(found.positive, values[0] > 1e-6);
  EXPECT_EQ(found.positive, positive);
}

maneuver::Problem gait_in_the_plane(int count) {
  maneuver::Problem problem = chain_problem(count, 1.0);
  problem.start.free_shape = true;
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move = {0.3, std::nullopt, std::nullopt};
  problem.goal->periodic = true;
  problem.goal->rest = false;
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  problem.search.starts = 4;
  return problem;
}

TEST(GaitOrder, in_the_plane_is_that_of_second_differences) {
  const maneuver::Problem problem = gait_in_the_plane(16);
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

maneuver::Problem turning_gait(int count, double turn) {
  maneuver::Problem problem = gait_in_the_plane(count);
  problem.goal->move[0].reset();
  problem.goal->turn = Vector3d(0, 0, turn);
  return problem;
}

// A turn about the plane's normal is the same wherever along itself the gait begins.
TEST(GaitOrder, of_a_gait_that_turns_is_that_of_second_differences_but_for_its_phase) {
  const maneuver::Problem problem = turning_gait(14, 0.02);
  const maneuver::Solution solution = solved_gait(problem);
  DenseMotion dense(problem, solution);
  const VectorXd values = dense.eigenvalues();
  const SecondOrder found = dense.certified();
  ASSERT_TRUE(found.along_phase);
  EXPECT_LE(std::abs(*found.along_phase), optimality::curvature_mark);
  EXPECT_NEAR(*found.along_phase, values[0], 1e-5) << "what differences leave of nothing";
  EXPECT_NEAR(found.smallest_eigenvalue, values[1], tolerance(1e-4) * values[1]);
  EXPECT_TRUE(found.positive);
  EXPECT_EQ(found.negative_eigenvalues, 0);
}

// How much the nodes tell one phase from another falls faster than any power of their number; what is proved beside it stays.
TEST(GaitOrder, of_the_phase_fades_with_more_steps_as_those_of_smooth_periods_do) {
  std::vector<double> along, beside;
  for (const int count : {8, 11, 14, 17}) {
    const maneuver::Problem problem = turning_gait(count, 0.02);
    const maneuver::Solution solution = solved_gait(problem);
    const SecondOrder found = DenseMotion(problem, solution).certified();
    along.push_back(std::abs(found.along_phase.value_or(found.smallest_eigenvalue)));
    if (found.along_phase) beside.push_back(found.smallest_eigenvalue);
  }
  EXPECT_LT(along[1], 1e-2 * along[0]);
  EXPECT_LT(along[2], 1e-2 * along[1]);
  ASSERT_EQ(beside.size(), 2u);
  EXPECT_NEAR(beside[1], beside[0], 0.05 * beside[0]);
}

// Along the linearised motion the phase moves what it began with, to where the period closes.
TEST(GaitPhase, leads_back_to_its_beginning_to_second_order_in_the_step) {
  std::vector<double> left;
  for (const int count : {20, 80}) {
    const maneuver::Problem problem = turning_gait(count, 0.02);
    const maneuver::Solution solution = solved_gait(problem);
    const model::System system(problem.swimmer);
    const StoredMotion motion(system, problem, solution);
    const auto effort = optimality::effort_chain(motion, evidence::check_balance(motion).scale);
    ASSERT_TRUE(effort);
    const auto phase = optimality::phase_direction(motion, *effort);
    ASSERT_TRUE(phase);
    ASSERT_EQ(phase->size(), effort->chain.stage.size());
    VectorXd y = VectorXd::Zero(effort->chain.end_form.rows());
    double sum = 0.0;
    for (std::size_t k = 0; k < phase->size(); ++k) {
      y = (effort->chain.stage[k].A * y + effort->chain.stage[k].B * (*phase)[k]).eval();
      sum += y.squaredNorm() / count;
    }
    left.push_back((effort->chain.end_rows * y).norm() / std::sqrt(sum));
  }
  EXPECT_NEAR(0.5 * std::log2(left[0] / left[1]), 2.0, 0.5) << left[0] << ", as searches begin their gaits anywhere";
}

TEST(GaitPhase, is_told_only_where_the_gait_begun_a_step_later_is_an_answer_too) {
  const maneuver::Problem turning = turning_gait(20, 0.02);
  const maneuver::Solution turn = solved_gait(turning);
  const auto told = [](const maneuver::Problem& problem, const maneuver::Solution& solution) {
    const model::System system(problem.swimmer);
    const StoredMotion motion(system, problem, solution);
    const auto effort = optimality::effort_chain(motion, evidence::check_balance(motion).scale);
    EXPECT_TRUE(effort);
    return effort && optimality::phase_direction(motion, *effort).has_value();
  };
  EXPECT_TRUE(told(turning, turn));
  maneuver::Problem other = turning;
  other.goal->move[1] = turn.position.back()[1] - turn.position.front()[1];
  EXPECT_FALSE(told(other, turn)) << "a way is seen from where the root points at the start";
  other = turning;
  other.cost_weights.displacement[0] = 1.0;
  EXPECT_FALSE(told(other, turn));
  other = turning;
  other.cost_weights.transport = 1.0;
  EXPECT_FALSE(told(other, turn)) << "the way of a cycle that turns is as long as its beginning has it";
  other = turning;
  other.limits.spheres.push_back({Vector3d(1e3, 0, 0), 1.0});
  EXPECT_FALSE(told(other, turn));
  const maneuver::Problem moving = gait_in_the_plane(16);
  EXPECT_FALSE(told(moving, solved_gait(moving)));
  maneuver::Problem in_shape = turning;
  in_shape.start.free_shape = false;
  in_shape.start.rotation.clear();
  for (const Matrix3d& R : turn.rotation.front()) in_shape.start.rotation.push_back(lie::log(R));
  EXPECT_FALSE(told(in_shape, turn));
}

// That the first angle of a wheel is nobody's business is another direction, and not set aside.
TEST(GaitOrder, sets_no_other_flat_direction_aside) {
  maneuver::Problem problem = gait_in_the_plane(16);
  model::BodyDescription wheel;
  wheel.name = "wheel";
  wheel.semi_axes = Vector3d(3.0, 3.0, 1.0);
  problem.swimmer.bodies.push_back(wheel);
  model::JointDescription hinge;
  hinge.name = "wheel";
  hinge.kind = model::JointKind::hinge;
  hinge.parent = problem.swimmer.bodies.front().name;
  hinge.child = "wheel";
  hinge.axis = Vector3d(0, 0, 1);
  problem.swimmer.joints.push_back(hinge);
  problem.start.rotation.emplace_back(Vector3d::Zero());
  problem.start.angular_velocity.emplace_back(Vector3d::Zero());
  const maneuver::Solution solution = solved_gait(problem);
  const SecondOrder found = DenseMotion(problem, solution).certified();
  EXPECT_FALSE(found.along_phase);
  EXPECT_FALSE(found.positive);
  EXPECT_LE(std::abs(found.smallest_eigenvalue), optimality::curvature_mark);
}

TEST(GaitOrder, of_a_planar_gait_that_may_leave_the_plane_is_a_saddle_as_second_differences_say) {
  maneuver::Problem problem = gait_in_the_plane(8);
  const maneuver::Solution solution = solved_gait(problem);
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes.reset();
  expect_eigenvalues_of_gait(problem, solution, false);
}

// A hinge with a spring and a damper, a universal joint, a ball joint with a spring.
maneuver::Problem mixed_joints(int count) {
  maneuver::Problem problem;
  problem.swimmer = swimmer_of_mixed_joints();
  problem.start.rotation.assign(4, Vector3d::Zero());
  problem.start.angular_velocity.assign(4, Vector3d::Zero());
  problem.start.free_shape = true;
  problem.steps = count;
  problem.scheme = maneuver::Scheme::midpoint;
  problem.goal = maneuver::Goal{};
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.goal->move = {0.02, std::nullopt, -0.01};  // the turn over a cycle is free
  problem.search.starts = 4;
  return problem;
}

TEST(GaitOrder, of_mixed_joints_in_space_with_springs_and_dampers_is_that_of_second_differences) {
  const maneuver::Problem problem = mixed_joints(6);
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

// An eel of three links.
maneuver::Problem eel(int count) {
  maneuver::Problem problem;
  problem.swimmer.density = 1.0;
  for (int i = 0; i < 3; ++i) {
    model::BodyDescription body;
    body.name = "link" + std::to_string(i);
    body.semi_axes = Vector3d(0.5, 0.12, 0.25);
    problem.swimmer.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription hinge;
    hinge.kind = model::JointKind::hinge;
    hinge.name = "joint" + std::to_string(i);
    hinge.parent = "link" + std::to_string(i - 1);
    hinge.child = body.name;
    hinge.parent_offset = Vector3d(-0.52, 0, 0);
    hinge.child_offset = Vector3d(0.52, 0, 0);
    hinge.axis = Vector3d(0, 0, 1);
    problem.swimmer.joints.push_back(hinge);
  }
  problem.start.rotation.assign(3, Vector3d::Zero());
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.start.free_shape = true;
  problem.steps = count;
  problem.goal = maneuver::Goal{};
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move = {0.2, std::nullopt, std::nullopt};
  problem.search.starts = 4;
  return problem;
}

TEST(GaitOrder, of_a_free_duration_within_limits_that_pull_is_that_of_second_differences) {
  const maneuver::Problem given = eel(14);
  const maneuver::Solution unlimited = solved_gait(given);
  const model::System system(given.swimmer);
  double bend = 0.0, torque = 0.0;
  for (const auto& R : unlimited.rotation)
    bend = std::max(bend, mechanics::joint_angles(system.joint(1), mechanics::child_to_parent(R, system.joint(1)))[0]);
  for (const auto& u : unlimited.control)
    for (const Vector3d& moment : u) torque = std::max(torque, moment.norm());
  maneuver::Problem problem = given;
  problem.limits.angle["joint2"] = {{-3.0, 0.8 * bend}};
  problem.limits.torque = 0.9 * torque;
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 5.0;
  problem.time_weight = 3.0 * unlimited.cost;
  const maneuver::Solution solution = solved_gait(problem);
  DenseMotion dense(problem, solution);
  EXPECT_GT(dense.held(true), 0U);
  EXPECT_GT(dense.held(false), 0U);
  const VectorXd values = dense.eigenvalues();
  const SecondOrder found = dense.certified();
  EXPECT_NEAR(found.smallest_eigenvalue, values[0], tolerance(1e-4) * std::abs(values[0])) << "kept by a penalty";
  EXPECT_EQ(found.positive, values[0] > 1e-6);
}

// Spheres carry their weighted centre with the shape: what moments reach of the start mixes with what they do not.
TEST(GaitOrder, of_spheres_that_turn_is_that_of_second_differences) {
  maneuver::Problem problem = eel(14);
  for (model::BodyDescription& body : problem.swimmer.bodies) body.semi_axes.setConstant(0.3);
  problem.goal->move[0].reset();
  problem.goal->turn = Vector3d(0, 0, 0.05);
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

// Springs and dampers feel how long a step is.
TEST(GaitOrder, of_a_free_duration_of_mixed_joints_with_springs_and_dampers_is_that_of_second_differences) {
  maneuver::Problem problem = mixed_joints(6);
  problem.time_weight = 3.0 * solved_gait(problem).cost;
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 5.0;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

// Two sprung and damped hinges, the second one passive where asked.
maneuver::Problem compliant_eel(int count, bool passive) {
  maneuver::Problem problem = eel(count);
  for (model::JointDescription& joint : problem.swimmer.joints) {
    joint.stiffness = 0.8;
    joint.damping = 0.05;
  }
  problem.goal->move[0] = 0.03;
  problem.swimmer.joints[1].actuated = !passive;
  if (passive) problem.goal->turn.reset();
  return problem;
}

TEST(GaitOrder, of_a_free_duration_of_a_passive_tail_is_that_of_second_differences) {
  maneuver::Problem problem = compliant_eel(14, true);
  problem.time_weight = solved_gait(problem).cost;
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 8.0;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

void expect_eigenvalues_with_power_and_smoothness(maneuver::Problem problem) {
  problem.cost_weights.power = 20.0 / solved_gait(problem).cost;
  problem.cost_weights.smoothness = 1e-3;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

TEST(CostOrder, of_gaits_with_power_and_smoothness_is_that_of_second_differences) {
  expect_eigenvalues_with_power_and_smoothness(gait_in_the_plane(16));
}

maneuver::Problem rest_to_rest(int count) {
  maneuver::Problem problem = gait_in_the_plane(count);
  problem.goal->periodic = problem.start.free_shape = false;
  problem.goal->rest = true;
  problem.goal->turn = Vector3d(0, 0, 0.1);
  return problem;
}

TEST(CostOrder, of_maneuvers_with_power_and_smoothness_is_that_of_second_differences) {
  expect_eigenvalues_with_power_and_smoothness(rest_to_rest(14));
}

TEST(CostOrder, of_gaits_with_angular_velocity_is_that_of_second_differences) {
  maneuver::Problem problem = gait_in_the_plane(16);
  problem.cost_weights.angular_velocity = 0.02 * solved_gait(problem).cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

TEST(CostOrder, of_maneuvers_with_angular_velocity_is_that_of_second_differences) {
  maneuver::Problem problem = rest_to_rest(14);
  problem.cost_weights.angular_velocity = 0.02 * solved_gait(problem).cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

TEST(CostOrder, of_gaits_of_mixed_joints_in_space_with_angular_velocity_is_that_of_second_differences) {
  maneuver::Problem problem = mixed_joints(6);
  problem.goal->move = {0.1, std::nullopt, -0.05};
  problem.cost_weights.angular_velocity = 0.1 * solved_gait(problem).cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

TEST(CostOrder, of_gaits_of_mixed_joints_in_space_with_power_is_that_of_second_differences) {
  maneuver::Problem problem = mixed_joints(6);
  problem.goal->move = {0.1, std::nullopt, -0.05};
  problem.cost_weights.power = 3.0 / solved_gait(problem).cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true);
}

TEST(CostOrder, of_free_durations_with_all_costs_is_that_of_second_differences) {
  maneuver::Problem problem = eel(14);
  const double cost = solved_gait(problem).cost;
  problem.cost_weights.power = 0.2 / cost;
  problem.cost_weights.smoothness = 1e-3;
  problem.cost_weights.work = 0.05 * cost;
  problem.cost_weights.transport = 0.01 * cost;
  problem.cost_weights.angular_velocity = 0.01 * cost;
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 5.0;
  problem.time_weight = 3.0 * cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

// Joints that turn at the start do so at given rates, whatever the duration.
void expect_eigenvalues_from_a_start_in_motion(const std::function<void(double cost, maneuver::CostWeights&)>& weigh,
                                               double accuracy) {
  maneuver::Problem problem = rest_to_rest(16);
  problem.goal->turn = Vector3d(0, 0, 0.05);
  problem.goal->move = {};
  bend_at_start(problem, {Vector3d(0.0, 0.0, 0.4), Vector3d(0.0, 0.0, -0.7)});
  const double cost = solved_gait(problem).cost;
  weigh(cost, problem.cost_weights);
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 5.0;
  problem.time_weight = 3.0 * cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, accuracy);
}

TEST(CostOrder, of_free_durations_from_a_start_in_motion_with_smooth_costs_is_that_of_second_differences) {
  expect_eigenvalues_from_a_start_in_motion(
      [](double cost, maneuver::CostWeights& weights) {
        weights.power = 5.0 / cost;
        weights.smoothness = 1e-3;
        weights.angular_velocity = 0.1 * cost;
      },
      1e-4);
}

TEST(CostOrder, of_free_durations_from_a_start_in_motion_with_work_is_that_of_second_differences) {
  expect_eigenvalues_from_a_start_in_motion(
      [](double cost, maneuver::CostWeights& weights) { weights.work = 0.3 * std::sqrt(cost); }, 1e-3);
}

TEST(CostOrder, of_free_durations_from_a_start_in_motion_with_work_per_distance_is_that_of_second_differences) {
  expect_eigenvalues_from_a_start_in_motion(
      [](double cost, maneuver::CostWeights& weights) { weights.transport = 1e-3 * cost; }, 1e-3);
}

TEST(CostOrder, of_free_durations_with_springs_dampers_limits_and_costs_is_that_of_second_differences) {
  maneuver::Problem problem = compliant_eel(14, false);
  problem.search.starts = 1;
  problem.goal->move[0] = 0.05;
  const double cost = solved_gait(problem).cost;
  problem.cost_weights.power = 1e-3 / cost;
  problem.cost_weights.smoothness = 1e-4;
  problem.duration.free = true;
  problem.duration.min = 0.2;
  problem.duration.max = 5.0;
  problem.time_weight = 3.0 * cost;
  double torque = 0.0;
  for (const auto& u : solved_gait(problem).control)
    for (const Vector3d& moment : u) torque = std::max(torque, moment.norm());
  problem.limits.torque = 0.95 * torque;
  const maneuver::Solution solution = solved_gait(problem);
  EXPECT_GT(DenseMotion(problem, solution).held(true), 0U);
  expect_eigenvalues_of_gait(problem, solution, true, 1e-3);
}

TEST(CostOrder, of_gaits_with_work_is_that_of_second_differences_of_its_smooth_branch) {
  maneuver::Problem problem = gait_in_the_plane(16);
  problem.cost_weights.work = 3.0;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

TEST(CostOrder, of_an_eel_with_work_per_distance_is_that_of_second_differences_of_its_smooth_branch) {
  maneuver::Problem problem = eel(12);
  problem.cost_weights.transport = 0.1 * solved_gait(problem).cost;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

// The two axes of a universal joint are driven by motors of their own.
TEST(CostOrder, of_gaits_of_mixed_joints_in_space_with_work_is_that_of_second_differences_of_its_smooth_branch) {
  maneuver::Problem problem = mixed_joints(8);
  problem.goal->move = {0.1, std::nullopt, -0.05};
  problem.cost_weights.work = 0.3 * std::sqrt(solved_gait(problem).cost);
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

// A turn from rest to rest that ends as far away as pays.
TEST(CostOrder, of_maneuvers_with_work_per_free_distance_is_that_of_second_differences) {
  maneuver::Problem problem = rest_to_rest(16);
  problem.goal->turn = Vector3d(0, 0, 0.2);
  problem.goal->move = {};
  problem.cost_weights.transport = 0.1 * solved_gait(problem).cost / 100.0;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

TEST(CostOrder, of_gaits_that_go_as_far_as_it_is_worth_is_that_of_second_differences) {
  maneuver::Problem problem = gait_in_the_plane(16);
  const maneuver::Solution given = solved_gait(problem);
  problem.goal->move[0].reset();
  problem.cost_weights.displacement[0] = 1.5 * given.cost / 0.3;
  const maneuver::Solution solution = solved_gait(problem);
  EXPECT_GT(solution.position.back()[0] - solution.position.front()[0], 0.3);
  expect_eigenvalues_of_gait(problem, solution, true);
}

TEST(CostOrder, of_maneuvers_with_work_is_that_of_second_differences_of_its_smooth_branch) {
  maneuver::Problem problem = rest_to_rest(20);
  problem.cost_weights.work = 3.0;
  expect_eigenvalues_of_gait(problem, solved_gait(problem), true, 1e-3);
}

// Powers that vanish are kept whatever the displacement takes off the cost, and a constant beside it changes no curvature.
TEST(CostOrder, does_not_depend_on_what_stands_beside_the_cost) {
  maneuver::Problem problem = gait_in_the_plane(16);
  problem.cost_weights.work = 3.0;
  const double given = solved_gait(problem).cost;
  problem.goal->move[0].reset();
  problem.cost_weights.displacement[0] = 1.5 * given / 0.3;
  maneuver::Solution solution = solved_gait(problem);
  ASSERT_LT(solution.cost, 0.0);
  expect_eigenvalues_of_gait(problem, solution, true, 1e-3);
  const double smallest = DenseMotion(problem, solution).certified().smallest_eigenvalue;
  ASSERT_GT(smallest, 0.0);
  for (const double constant : {-0.9 * solution.cost, -solution.cost, -2.0 * solution.cost}) {
    maneuver::Problem other = problem;
    other.time_weight = constant / other.duration.value;
    maneuver::Solution same = solution;
    same.cost += constant;
    EXPECT_NEAR(DenseMotion(other, same).certified().smallest_eigenvalue, smallest, tolerance(1e-6));
  }
}

}  // namespace
}  // namespace lamprey::tests
