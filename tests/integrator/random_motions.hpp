// Motions of random swimmers, a scalar of each, and directions away from it: what the tests of derivatives share.
#pragma once

#include "chains.hpp"
#include "integrator/adjoint.hpp"
#include "integrator/marching.hpp"

namespace lamprey::tests {

using Eigen::VectorXd;
using integrator::State;
using integrator::StateGradient;
using integrator::Trajectory;
using integrator::TrajectoryDirection;
using integrator::TrajectoryGradient;
using mechanics::Freedoms;
using mechanics::Moments;

inline double largest(const Freedoms& v) {
  double value = 0.0;
  for (const Vector3d& entry : v) value = std::max(value, entry.lpNorm<Eigen::Infinity>());
  return value;
}

inline double dot(const Freedoms& a, const Freedoms& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// A scalar without symmetry: at each node Σ_i a_i·R_i b_i + quadratic in x and μ + ½|u|², weighted by the node.
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
      const State& s = t.state[model::at(k)];
      double term = 0.5 * s.position.squaredNorm() + c_.dot(s.position) + 0.0025 * s.momentum.squaredNorm();
      for (std::size_t i = 0; i < a_.size(); ++i) term += a_[i].dot(s.rotation[i] * b_[i]);
      for (const Vector3d& u : t.control[model::at(k)]) term += 0.005 * u.squaredNorm();
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
      by_state.momentum[i] += 0.005 * weight(k) * mu[i];
    }
    by_state.position += weight(k) * (s.position + c_);
    by_state.linear += 0.005 * weight(k) * s.momentum.tail<3>();
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
      by_state.momentum[i] += 0.005 * weight(k) * along.momentum[i];
    }
    by_state.position += weight(k) * along.position;
    by_state.linear += 0.005 * weight(k) * along.linear;
    for (std::size_t j = 0; j < u_along.size(); ++j) by_u[j] += 0.01 * weight(k) * u_along[j];
  }

 private:
  static double weight(int k) { return 1.0 + 0.3 * std::sin(2.0 * k); }
  const model::System& system_;
  mechanics::Vectors a_, b_;
  Vector3d c_;
};

/// Which swimmer moves how.
struct MotionSetting {
  integrator::Scheme scheme;
  int bodies;
  unsigned seed;
  int steps = 4;
  double duration = 0.08;  // s
};

inline std::ostream& operator<<(std::ostream& out, const MotionSetting& setting) {
  return out << scheme_name(setting.scheme) << ", " << setting.bodies << " bodies, seed " << setting.seed;
}

/// A motion of a random swimmer under random moments.
struct RandomMotion {
  explicit RandomMotion(const MotionSetting& chosen)
      : setting(chosen),
        random(setting.seed),
        swimmer(random_swimmer(random, setting.bodies)),
        system(swimmer),
        start{random_rotations(random, system), random.vector(), VectorXd()} {
    VectorXd velocity(system.velocity_count());
    for (double& v : velocity) v = random.normal();
    start.momentum = mechanics::generalized_momentum(system, start.rotation, velocity);
    const int nodes = setting.steps * composition(setting.scheme).stages() + 1;
    for (int k = 0; k < nodes; ++k) control.push_back(random_moments(random, system, 3.0));
    trajectory = run(system, start, control, setting.duration);
  }
  RandomMotion(const RandomMotion&) = delete;  // trajectory.system points at system
  RandomMotion& operator=(const RandomMotion&) = delete;

  Trajectory run(const model::System& swimming, const State& from, const std::vector<Moments>& moments,
                 double time) const {
    Trajectory rolled = integrator::roll_out(swimming, setting.scheme, time, setting.steps, from, moments);
    EXPECT_TRUE(rolled.report.converged) << setting;
    return rolled;
  }

  TrajectoryDirection random_direction() {
    TrajectoryDirection direction(trajectory);
    direction.start.turn = random_freedoms(random, system, 1.0);
    direction.start.position = random.vector();
    direction.start.momentum = random_freedoms(random, system, 1.0);
    direction.start.linear = random.vector();
    for (Moments& u : direction.control) u = random_moments(random, system, 10.0);
    return direction;
  }

  State moved_start(const TrajectoryDirection& direction, double t) const {
    Freedoms turn = direction.start.turn;
    for (Vector3d& entry : turn) entry *= t;
    VectorXd momentum;
    mechanics::pack(system, direction.start.momentum, direction.start.linear, momentum);
    return {turned(system, start.rotation, turn), start.position + t * direction.start.position,
            start.momentum + t * momentum};
  }

  std::vector<Moments> moved_control(const TrajectoryDirection& direction, double t) const {
    std::vector<Moments> moved = control;
    for (std::size_t k = 0; k < moved.size(); ++k)
      for (std::size_t j = 0; j < moved[k].size(); ++j) moved[k][j] += t * direction.control[k][j];
    return moved;
  }

  /// The motion from a start and under controls that lie along the direction.
  Trajectory moved(const TrajectoryDirection& direction, double t) const {
    return run(system, moved_start(direction, t), moved_control(direction, t), setting.duration);
  }

  MotionSetting setting;
  Random random;
  model::SwimmerDescription swimmer;
  model::System system;
  State start;
  std::vector<Moments> control;
  Trajectory trajectory;
};

/// A sum of products and the size that it would have if their signs were drawn at random.
struct Slope {
  double value = 0.0;
  double squares = 0.0;
  double size() const { return std::sqrt(squares); }
  void add(double gradient, double direction) {
    value += gradient * direction;
    squares += gradient * direction * gradient * direction;
  }
  template <typename Gradient, typename Direction>
  void add_entries(const Gradient& gradient, const Direction& direction) {
    for (Eigen::Index i = 0; i < gradient.size(); ++i) add(gradient.data()[i], direction.data()[i]);
  }
  void add_vectors(const mechanics::Vectors& gradient, const mechanics::Vectors& direction) {
    for (std::size_t i = 0; i < gradient.size(); ++i) add_entries(gradient[i], direction[i]);
  }
  void add_state(const StateGradient& gradient, const StateGradient& direction) {
    add_vectors(gradient.turn, direction.turn);
    add_entries(gradient.position, direction.position);
    add_vectors(gradient.momentum, direction.momentum);
    add_entries(gradient.linear, direction.linear);
  }
};

inline double norm(const StateGradient& state) {
  Slope squared;
  squared.add_state(state, state);
  return std::sqrt(squared.value);
}

/// Slope of the scalar along a direction of start and controls.
inline Slope slope_along(const TrajectoryGradient& gradient, const TrajectoryDirection& direction) {
  Slope slope;
  slope.add_state(gradient.by_start, direction.start);
  for (std::size_t k = 0; k < direction.control.size(); ++k)
    slope.add_vectors(gradient.by_control[k], direction.control[k]);
  return slope;
}

/// A direction of all parameters of a swimmer, entries are the changes of its own: absent springs and dampers stay absent.
inline model::SwimmerDescription random_parameters(Random& random, const model::SwimmerDescription& swimmer) {
  model::SwimmerDescription direction = swimmer;
  for (model::BodyDescription& body : direction.bodies) {
    Matrix3d C;
    for (int c = 0; c < 3; ++c) C.col(c) = random.vector(0.05);
    body.mass_matrix = 0.1 * random.positive_definite();
    body.inertia_matrix = 0.1 * random.positive_definite();
    body.coupling_matrix = C;
  }
  for (model::JointDescription& joint : direction.joints) {
    joint.parent_offset = random.vector(0.3);
    joint.child_offset = random.vector(0.3);
    joint.stiffness *= 0.5 * random.normal();
    joint.damping *= 0.5 * random.normal();
  }
  return direction;
}

inline model::SwimmerDescription moved_parameters(const model::SwimmerDescription& swimmer,
                                                  const model::SwimmerDescription& direction, double t) {
  model::SwimmerDescription moved = swimmer;
  for (std::size_t i = 0; i < moved.bodies.size(); ++i) {
    *moved.bodies[i].mass_matrix += t * *direction.bodies[i].mass_matrix;
    *moved.bodies[i].inertia_matrix += t * *direction.bodies[i].inertia_matrix;
    moved.bodies[i].coupling_matrix =
        moved.bodies[i].coupling_matrix.value_or(Matrix3d::Zero()) + t * *direction.bodies[i].coupling_matrix;
  }
  for (std::size_t j = 0; j < moved.joints.size(); ++j) {
    moved.joints[j].parent_offset += t * direction.joints[j].parent_offset;
    moved.joints[j].child_offset += t * direction.joints[j].child_offset;
    moved.joints[j].stiffness += t * direction.joints[j].stiffness;
    moved.joints[j].damping += t * direction.joints[j].damping;
  }
  return moved;
}

/// Slope of the scalar along a direction of the parameters.
inline Slope slope_along(const integrator::ParameterGradient& by, const model::SwimmerDescription& direction) {
  Slope slope;
  for (std::size_t i = 0; i < direction.bodies.size(); ++i) {
    slope.add_entries(by.mass_matrix[i], *direction.bodies[i].mass_matrix);
    slope.add_entries(by.inertia_matrix[i], *direction.bodies[i].inertia_matrix);
    slope.add_entries(by.coupling_matrix[i], *direction.bodies[i].coupling_matrix);
  }
  for (std::size_t j = 0; j < direction.joints.size(); ++j) {
    const model::JointDescription& joint = direction.joints[j];
    slope.add_entries(by.parent_offset[j], joint.parent_offset);
    slope.add_entries(by.child_offset[j], joint.child_offset);
    slope.add(by.stiffness[static_cast<int>(j)], joint.stiffness);
    slope.add(by.damping[static_cast<int>(j)], joint.damping);
  }
  return slope;
}

/// All of the gradient by start and controls as one vector.
inline VectorXd stacked(const model::System& system, const StateGradient& start,
                        const std::vector<Moments>& by_control) {
  VectorXd turn, momentum;
  mechanics::pack(system, start.turn, start.position, turn);
  mechanics::pack(system, start.momentum, start.linear, momentum);
  VectorXd all(2 * turn.size() + 3 * system.joint_count() * static_cast<int>(by_control.size()));
  all << turn, momentum, VectorXd::Zero(all.size() - 2 * turn.size());
  Eigen::Index place = 2 * turn.size();
  for (const Moments& u : by_control)
    for (const Vector3d& entry : u) {
      all.segment<3>(place) = entry;
      place += 3;
    }
  return all;
}

/// A linear function of the last state alone.
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

}  // namespace lamprey::tests
