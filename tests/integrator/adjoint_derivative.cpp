#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "integrator/adjoint.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::Scheme;
using integrator::State;
using integrator::StateGradient;
using integrator::Trajectory;
using mechanics::Freedoms;
using mechanics::Moments;
using model::at;

constexpr int step_count = 4;
constexpr double duration = 0.08;

double largest(const Freedoms& v) {
  double value = 0.0;
  for (const Vector3d& entry : v) value = std::max(value, entry.lpNorm<Eigen::Infinity>());
  return value;
}

double dot(const Freedoms& a, const Freedoms& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

// A scalar without symmetry: at each node Σ_i a_i·R_i b_i + quadratic in x and μ + ½|u|², weighted by the node.
class Scalar : public integrator::Objective {
 public:
  Scalar(Random& random, const model::System& system) : system_(system) {
    for (int i = 0; i < system.body_count(); ++i) {
      a_.push_back(random.vector());
      b_.push_back(random.vector());
    }
    c_ = random.vector();
  }

  double value(const Trajectory& t) const {
    double sum = 0.0;
    for (int k = 0; k <= t.steps(); ++k) {
      const State& s = t.state[at(k)];
      double term = 0.5 * s.position.squaredNorm() + c_.dot(s.position) + 0.25 * s.momentum.squaredNorm();
      for (std::size_t i = 0; i < a_.size(); ++i) term += a_[i].dot(s.rotation[i] * b_[i]);
      for (const Vector3d& u : t.control[at(k)]) term += 0.005 * u.squaredNorm();
      sum += weight(k) * term;
    }
    return sum;
  }

  void add_gradient(int k, const State& s, const Moments& u, StateGradient& by_state, Moments& by_u) const override {
    mechanics::Vectors moment, none(a_.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < a_.size(); ++i)
      moment.push_back(weight(k) * b_[i].cross(s.rotation[i].transpose() * a_[i]));
    Freedoms turn(a_.size()), mu(a_.size());
    mechanics::gather(system_, s.rotation, none, moment, turn);
    mechanics::unpack(system_, s.momentum, mu);
    for (std::size_t i = 0; i < a_.size(); ++i) {
      by_state.turn[i] += turn[i];
      by_state.momentum[i] += 0.5 * weight(k) * mu[i];
    }
    by_state.position += weight(k) * (s.position + c_);
    by_state.linear += 0.5 * weight(k) * s.momentum.tail<3>();
    for (std::size_t j = 0; j < u.size(); ++j) by_u[j] += 0.01 * weight(k) * u[j];
  }

  void add_gradient_rate(int k, const State& s, const Moments&, const StateGradient& along, const Moments& u_along,
                         StateGradient& by_state, Moments& by_u) const override {
    mechanics::Vectors moment, moment_rate, none(a_.size(), Vector3d::Zero()), turns(a_.size());
    mechanics::body_turns(system_, s.rotation, along.turn, turns);
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const Vector3d seen = s.rotation[i].transpose() * a_[i];
      moment.push_back(weight(k) * b_[i].cross(seen));
      moment_rate.push_back(weight(k) * b_[i].cross(seen.cross(turns[i])));
    }
    Freedoms turn(a_.size()), rate(a_.size());
    mechanics::gather(system_, s.rotation, none, moment, turn);
    mechanics::gather_rate(system_, s.rotation, none, moment, {along.turn, turns, none}, moment_rate, rate);
    for (std::size_t i = 0; i < a_.size(); ++i) {
      by_state.turn[i] += rate[i];
      by_state.momentum[i] += 0.5 * weight(k) * along.momentum[i];
    }
    by_state.position += weight(k) * along.position;
    by_state.linear += 0.5 * weight(k) * along.linear;
    for (std::size_t j = 0; j < u_along.size(); ++j) by_u[j] += 0.01 * weight(k) * u_along[j];
  }

 private:
  static double weight(int k) { return 1.0 + 0.3 * std::sin(2.0 * k); }
  const model::System& system_;
  mechanics::Vectors a_, b_;
  Vector3d c_;
};

struct Setting {
  Scheme scheme;
  int bodies;
  unsigned seed;
};

std::ostream& operator<<(std::ostream& out, Setting setting) {
  return out << "scheme " << static_cast<int>(setting.scheme) << ", " << setting.bodies << " bodies, seed "
             << setting.seed;
}

// A motion of a random swimmer under random moments, and a direction away from it.
struct Motion {
  explicit Motion(Setting setting)
      : random(setting.seed),
        swimmer(random_swimmer(random, setting.bodies)),
        system(swimmer),
        scheme(setting.scheme),
        start{random_rotations(random, system), random.vector(), VectorXd()} {
    VectorXd velocity(system.velocity_count());
    for (double& v : velocity) v = random.normal();
    start.momentum = mechanics::generalized_momentum(system, start.rotation, velocity);
    const int nodes = step_count * composition(scheme).stages() + 1;
    for (int k = 0; k < nodes; ++k) control.push_back(random_moments(random, system, 3.0));
    trajectory = run(system, start, control, duration);
  }

  Trajectory run(const model::System& swimming, const State& from, const std::vector<Moments>& moments,
                 double time) const {
    Trajectory rolled = integrator::roll_out(swimming, scheme, time, step_count, from, moments);
    EXPECT_TRUE(rolled.report.converged);
    return rolled;
  }

  integrator::TrajectoryDirection random_direction() {
    integrator::TrajectoryDirection direction(trajectory);
    direction.start.turn = random_freedoms(random, system, 1.0);
    direction.start.position = random.vector();
    direction.start.momentum = random_freedoms(random, system, 1.0);
    direction.start.linear = random.vector();
    for (Moments& u : direction.control) u = random_moments(random, system, 10.0);
    return direction;
  }

  State moved_start(const integrator::TrajectoryDirection& direction, double t) const {
    Freedoms turn = direction.start.turn;
    for (Vector3d& entry : turn) entry *= t;
    VectorXd momentum;
    mechanics::pack(system, direction.start.momentum, direction.start.linear, momentum);
    return {turned(system, start.rotation, turn), start.position + t * direction.start.position,
            start.momentum + t * momentum};
  }

  std::vector<Moments> moved_control(const integrator::TrajectoryDirection& direction, double t) const {
    std::vector<Moments> moved = control;
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t j = 0; j < moved[k].size(); ++j) moved[k][j] += t * direction.control[k][j];
    return moved;
  }

  Trajectory moved(const integrator::TrajectoryDirection& direction, double t) const {
    return run(system, moved_start(direction, t), moved_control(direction, t), duration);
  }

  Random random;
  model::SwimmerDescription swimmer;
  model::System system;
  Scheme scheme;
  State start;
  std::vector<Moments> control;
  Trajectory trajectory;
};

VectorXd one(double value) { return VectorXd::Constant(1, value); }

class Adjoint : public ::testing::TestWithParam<Setting> {};

TEST_P(Adjoint, gradient_by_start_and_controls_matches_central_differences_at_second_order) {
  Motion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  integrator::TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto direction = m.random_direction();
  double slope = dot(gradient.by_start.turn, direction.start.turn) +
                 gradient.by_start.position.dot(direction.start.position) +
                 dot(gradient.by_start.momentum, direction.start.momentum) +
                 gradient.by_start.linear.dot(direction.start.linear);
  for (std::size_t k = 0; k < direction.control.size(); ++k)
    slope += dot(gradient.by_control[k], direction.control[k]);
  expect_second_order_differences([&](double t) { return one(scalar.value(m.moved(direction, t))); }, one(slope));
}

TEST_P(Adjoint, gradient_by_duration_matches_central_differences_at_second_order) {
  Motion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  integrator::TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  expect_second_order_differences(
      [&](double t) { return one(scalar.value(m.run(m.system, m.start, m.control, duration * (1.0 + t)))); },
      one(duration * gradient.by_duration));
}

TEST_P(Adjoint, gradient_by_parameters_matches_central_differences_at_second_order) {
  Motion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  integrator::TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto& by = gradient.by_parameters;
  model::SwimmerDescription direction = m.swimmer;  // entries are the change of those of the swimmer
  double slope = 0.0;
  for (std::size_t i = 0; i < direction.bodies.size(); ++i) {
    Matrix3d M = 0.1 * m.random.positive_definite(), J = 0.1 * m.random.positive_definite(), C;
    for (int c = 0; c < 3; ++c) C.col(c) = m.random.vector(0.05);
    direction.bodies[i].mass_matrix = M;
    direction.bodies[i].inertia_matrix = J;
    direction.bodies[i].coupling_matrix = C;
    slope += by.mass_matrix[i].cwiseProduct(M).sum() + by.inertia_matrix[i].cwiseProduct(J).sum() +
             by.coupling_matrix[i].cwiseProduct(C).sum();
  }
  for (std::size_t j = 0; j < direction.joints.size(); ++j) {
    model::JointDescription& joint = direction.joints[j];
    joint.parent_offset = m.random.vector(0.3);
    joint.child_offset = m.random.vector(0.3);
    if (joint.stiffness > 0.0) joint.stiffness = m.random.normal();
    if (joint.damping > 0.0) joint.damping = m.random.normal();
    slope += by.parent_offset[j].dot(joint.parent_offset) + by.child_offset[j].dot(joint.child_offset) +
             by.stiffness[static_cast<int>(j)] * joint.stiffness + by.damping[static_cast<int>(j)] * joint.damping;
  }
  const auto along = [&](double t) {
    model::SwimmerDescription moved = m.swimmer;
    for (std::size_t i = 0; i < moved.bodies.size(); ++i) {
      *moved.bodies[i].mass_matrix += t * *direction.bodies[i].mass_matrix;
      *moved.bodies[i].inertia_matrix += t * *direction.bodies[i].inertia_matrix;
      moved.bodies[i].coupling_matrix =
          moved.bodies[i].coupling_matrix.value_or(Matrix3d::Zero()) + t * *direction.bodies[i].coupling_matrix;
    }
    for (std::size_t j = 0; j < moved.joints.size(); ++j) {
      moved.joints[j].parent_offset += t * direction.joints[j].parent_offset;
      moved.joints[j].child_offset += t * direction.joints[j].child_offset;
      if (moved.joints[j].stiffness > 0.0) moved.joints[j].stiffness += t * direction.joints[j].stiffness;
      if (moved.joints[j].damping > 0.0) moved.joints[j].damping += t * direction.joints[j].damping;
    }
    const model::System other(moved);
    return one(scalar.value(m.run(other, m.start, m.control, duration)));
  };
  expect_second_order_differences(along, one(slope));
}

TEST_P(Adjoint, hessian_product_matches_central_differences_of_the_gradient_at_second_order) {
  Motion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  integrator::TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto direction = m.random_direction();
  integrator::HessianProduct product(m.trajectory);
  sweep.hessian_product(scalar, direction, product);
  const auto stacked = [&](const StateGradient& start, const std::vector<Moments>& by_control) {
    VectorXd turn, momentum, all(2 * m.system.velocity_count() + 3 * m.system.joint_count() * int(by_control.size()));
    mechanics::pack(m.system, start.turn, start.position, turn);
    mechanics::pack(m.system, start.momentum, start.linear, momentum);
    all << turn, momentum, VectorXd::Zero(all.size() - 2 * turn.size());
    Eigen::Index place = 2 * turn.size();
    for (const Moments& u : by_control)
      for (const Vector3d& entry : u) {
        all.segment<3>(place) = entry;
        place += 3;
      }
    return all;
  };
  const auto along = [&](double t) {
    const Trajectory moved = m.moved(direction, t);
    integrator::AdjointSweep other(moved);
    integrator::TrajectoryGradient there(moved);
    other.gradient(scalar, there);
    return stacked(there.by_start, there.by_control);
  };
  expect_second_order_differences(along, stacked(product.by_start, product.by_control), 1e-8);
}

TEST_P(Adjoint, tangent_and_gradient_give_one_dot_product) {
  Motion m(GetParam());
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  integrator::TrajectoryGradient gradient(m.trajectory);
  class AtEnd : public integrator::Objective {
   public:
    AtEnd(int last, const StateGradient& row) : last_(last), row_(row) {}
    void add_gradient(int k, const State&, const Moments&, StateGradient& by_state, Moments&) const override {
      if (k == last_) by_state = row_;
    }
    void add_gradient_rate(int, const State&, const Moments&, const StateGradient&, const Moments&, StateGradient&,
                           Moments&) const override {}

   private:
    int last_;
    const StateGradient& row_;
  };
  StateGradient row(m.system), end(m.system);
  row.turn = random_freedoms(m.random, m.system, 1.0);
  row.momentum = random_freedoms(m.random, m.system, 1.0);
  row.position = m.random.vector();
  row.linear = m.random.vector();
  sweep.gradient(AtEnd(m.trajectory.steps(), row), gradient);
  const auto direction = m.random_direction();
  sweep.tangent(direction, end);
  const double ahead = dot(row.turn, end.turn) + row.position.dot(end.position) + dot(row.momentum, end.momentum) +
                       row.linear.dot(end.linear);
  double behind = dot(gradient.by_start.turn, direction.start.turn) +
                  gradient.by_start.position.dot(direction.start.position) +
                  dot(gradient.by_start.momentum, direction.start.momentum) +
                  gradient.by_start.linear.dot(direction.start.linear);
  for (std::size_t k = 0; k < direction.control.size(); ++k)
    behind += dot(gradient.by_control[k], direction.control[k]);
  EXPECT_NEAR(behind, ahead, tolerance(1e-12) * (1.0 + largest(end.turn) + largest(end.momentum)) * 10.0);
}

std::vector<Setting> settings() {
  std::vector<Setting> all;
  unsigned seed = 1;
  for (Scheme scheme : {Scheme::paper, Scheme::trapezoid, Scheme::midpoint, Scheme::order4, Scheme::order6})
    for (int bodies : {1, 2, 3, 5, 8}) all.push_back({scheme, bodies, seed++});
  return all;
}

INSTANTIATE_TEST_SUITE_P(Schemes, Adjoint, ::testing::ValuesIn(settings()));

}  // namespace
}  // namespace lamprey::tests
