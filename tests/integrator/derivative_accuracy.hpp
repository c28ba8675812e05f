// How near gradients, Hessian products and tangents come to the truth on random trees, and what the tangent does to the
// symplectic form.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "integrator/random_motions.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {

/// Derivative of f at 0 by central differences extrapolated to order 8 or above (Romberg); of all such extrapolations the
/// one that agrees best with its neighbours, so that the choice knows nothing of the derivative under test.
inline VectorXd extrapolated_derivative(const std::function<VectorXd(double)>& f, double first) {
  constexpr std::size_t rows = 7;
  std::vector<std::vector<VectorXd>> table(rows);
  double least = INFINITY;
  VectorXd best;
  for (std::size_t k = 0; k < rows; ++k) {
    const double t = std::ldexp(first, -static_cast<int>(k));
    table[k].push_back((f(t) - f(-t)) / (2.0 * t));
    double power = 1.0;
    for (std::size_t j = 1; j <= k; ++j) {
      power *= 4.0;
      table[k].push_back(table[k][j - 1] + (table[k][j - 1] - table[k - 1][j - 1]) / (power - 1.0));
      if (j < 3) continue;
      const double change = std::max((table[k][j] - table[k][j - 1]).lpNorm<Eigen::Infinity>(),
                                     (table[k][j] - table[k - 1][j - 1]).lpNorm<Eigen::Infinity>());
      if (change >= least) continue;
      least = change;
      best = table[k][j];
    }
  }
  return best;
}

constexpr double first_difference = 0.05;  // of the widest pair, as a part of the direction

/// Largest relative errors seen, and the seeds that gave them.
struct Worst {
  struct Entry {
    double error = 0.0;
    unsigned seed = 0;
    void add(double value, unsigned from) {
      if (!(value <= error)) *this = {value, from};  // NaN counts as worst
    }
  };
  Entry gradient, by_parameters, hessian, dot_product, symplectic;
};

/// The canonical form in body-side coordinates: η1·δμ2 − δμ1·η2, with −μ·(η1 × η2) of the bodies that turn on their own.
inline Eigen::MatrixXd canonical_form(const model::System& system, const State& state) {
  const int half = system.velocity_count();
  Eigen::MatrixXd form = Eigen::MatrixXd::Zero(2 * half, 2 * half);
  form.topRightCorner(half, half).setIdentity();
  form.bottomLeftCorner(half, half) = -Eigen::MatrixXd::Identity(half, half);
  for (const model::Body& body : system.bodies())
    if (body.freedoms == 3)
      form.block<3, 3>(body.velocity_offset, body.velocity_offset) =
          -lie::hat(state.momentum.segment<3>(body.velocity_offset));
  return form;
}

inline StateGradient unpacked(const model::System& system, const VectorXd& y) {
  const int half = system.velocity_count();
  StateGradient result(system);
  mechanics::unpack(system, y.head(half), result.turn);
  mechanics::unpack(system, y.tail(half), result.momentum);
  result.position = y.segment<3>(half - 3);
  result.linear = y.tail<3>();
  return result;
}

/// Gradients by start, controls and duration, and by parameters, along one direction each, relative to what sums with
/// random signs would be.
inline void add_gradient_errors(const MotionSetting& setting, Worst& worst) {
  RandomMotion m(setting);
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const auto error = [](const Slope& slope, double first, const std::function<double(double)>& f) {
    // of five sets of differences the median: each carries round-off of its own
    std::vector<double> expected;
    for (double ratio : {1.0, 0.9, 0.8, 0.7, 0.6})
      expected.push_back(
          extrapolated_derivative([&](double t) { return VectorXd::Constant(1, f(t)); }, ratio * first)[0]);
    std::sort(expected.begin(), expected.end());
    return std::abs(slope.value - expected[2]) / slope.size();
  };
  const TrajectoryDirection direction = m.random_direction();
  Slope slope = slope_along(gradient, direction);
  slope.add(gradient.by_duration, setting.duration);
  worst.gradient.add(error(slope, first_difference,
                           [&](double t) {
                             return scalar.value(m.run(m.system, m.moved_start(direction, t),
                                                       m.moved_control(direction, t), setting.duration * (1.0 + t)));
                           }),
                     setting.seed);
  const model::SwimmerDescription parameters = random_parameters(m.random, m.swimmer);
  worst.by_parameters.add(error(slope_along(gradient.by_parameters, parameters), 0.4,
                                [&](double t) {
                                  const model::System other(moved_parameters(m.swimmer, parameters, t));
                                  return scalar.value(m.run(other, m.start, m.control, setting.duration));
                                }),
                          setting.seed);
}

/// Hessian times a direction against differences of gradients, largest entries compared.
inline void add_hessian_error(const MotionSetting& setting, Worst& worst) {
  RandomMotion m(setting);
  const Scalar scalar(m.random, m.system);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  sweep.gradient(scalar, gradient);
  const TrajectoryDirection direction = m.random_direction();
  integrator::HessianProduct product(m.trajectory);
  sweep.hessian_product(scalar, direction, product);
  const VectorXd expected = extrapolated_derivative(
      [&](double t) {
        const Trajectory moved = m.moved(direction, t);
        integrator::AdjointSweep other(moved);
        TrajectoryGradient there(moved);
        other.gradient(scalar, there);
        return stacked(m.system, there.by_start, there.by_control);
      },
      first_difference);
  const VectorXd found = stacked(m.system, product.by_start, product.by_control);
  worst.hessian.add((found - expected).lpNorm<Eigen::Infinity>() / expected.lpNorm<Eigen::Infinity>(), setting.seed);
}

/// Tangent against adjoint over the whole motion.
inline void add_dot_product_error(const MotionSetting& setting, Worst& worst) {
  RandomMotion m(setting);
  integrator::AdjointSweep sweep(m.trajectory);
  TrajectoryGradient gradient(m.trajectory);
  const StateGradient row = m.random_direction().start;
  sweep.gradient(AtEnd(m.trajectory.steps(), row), gradient);
  const TrajectoryDirection direction = m.random_direction();
  StateGradient end(m.system);
  sweep.tangent(direction, end);
  Slope ahead;
  ahead.add_state(row, end);
  const double behind = slope_along(gradient, direction).value;
  worst.dot_product.add(std::abs(ahead.value - behind) / (norm(row) * norm(end)), setting.seed);
}

/// Aᵀ ω(end) A − ω(start) of one step without moments and dampers, largest entry.
inline void add_symplectic_error(const MotionSetting& setting, Worst& worst) {
  Random random(setting.seed);
  const Moving swimmer = moving(random, without_dampers(random_swimmer(random, setting.bodies)));
  const model::System& system = swimmer.system;
  const std::vector<Moments> none(model::at(composition(setting.scheme).stages() + 1),
                                  Moments(model::at(system.joint_count()), Vector3d::Zero()));
  const double h = setting.duration / setting.steps;
  const Trajectory step = integrator::roll_out(system, setting.scheme, h, 1, swimmer.start, none);
  EXPECT_TRUE(step.report.converged) << setting;
  integrator::AdjointSweep sweep(step);
  TrajectoryGradient unused(step);
  StateGradient row(system), end(system);
  row.set_zero();
  sweep.gradient(AtEnd(step.steps(), row), unused);
  const int size = 2 * system.velocity_count();
  Eigen::MatrixXd A(size, size);
  for (int c = 0; c < size; ++c) {
    TrajectoryDirection direction(step);
    direction.start = unpacked(system, VectorXd::Unit(size, c));
    for (Moments& u : direction.control) u = none.front();
    sweep.tangent(direction, end);
    VectorXd turn, momentum;
    mechanics::pack(system, end.turn, end.position, turn);
    mechanics::pack(system, end.momentum, end.linear, momentum);
    A.col(c) << turn, momentum;
  }
  const Eigen::MatrixXd before = canonical_form(system, step.state.front());
  const Eigen::MatrixXd after = canonical_form(system, step.state.back());
  worst.symplectic.add((A.transpose() * after * A - before).lpNorm<Eigen::Infinity>(), setting.seed);
}

/// Whether springs stay away from the half turn, where their moments jump and no derivative exists.
inline bool springs_smooth(const RandomMotion& m) {
  for (const State& state : m.trajectory.state)
    for (const model::Joint& joint : m.system.joints()) {
      if (joint.stiffness == 0.0) continue;
      const Matrix3d Q = state.rotation[model::at(joint.parent)].transpose() * state.rotation[model::at(joint.child)];
      const double angle = joint.free() ? lie::rotation_angle(joint.reference_rotation.transpose() * Q)
                                        : mechanics::joint_angles(joint, Q).lpNorm<Eigen::Infinity>();
      if (angle > 2.4) return false;
    }
  return true;
}

/// Whether the moved motions that differences are taken of have all their steps: some swimmers stand so near a step
/// without a solution (the derivative grows without bound there) that a twentieth of their speed takes it away.
inline bool marches_around(const MotionSetting& setting) {
  RandomMotion m(setting);
  const Scalar scalar(m.random, m.system);
  const TrajectoryDirection direction = m.random_direction();
  const auto marches = [&](double t, double time) {
    return integrator::roll_out(m.system, setting.scheme, time, setting.steps, m.moved_start(direction, t),
                                m.moved_control(direction, t))
        .report.converged;
  };
  for (double t : {-first_difference, first_difference})
    if (!marches(t, setting.duration) || !marches(t, setting.duration * (1.0 + t))) return false;
  return true;
}

/// Four steps each of 0.02 s, or of 0.08 s for compositions, so that stages of all schemes are about as long: round-off in
/// the derivatives of a stage of h seconds is in proportion to 1/h (at 0.002 s: dot products to 5e-11, gradients to 1e-10).
/// Trees of one to eight bodies with every kind of joint, springs, dampers and coupled inertia; `count` of them.
inline Worst worst_derivatives(integrator::Scheme scheme, int count, unsigned first_seed) {
  Worst worst;
  unsigned seed = first_seed;
  int without_steps = 0;
  for (int n = 0; n < count; ++seed) {
    const MotionSetting setting{scheme, 1 + n % 8, seed, 4, integrator::order(scheme) > 2 ? 0.32 : 0.08};
    if (!springs_smooth(RandomMotion(setting))) continue;
    if (!marches_around(setting)) {
      ++without_steps;
      continue;
    }
    ++n;
    add_gradient_errors(setting, worst);
    add_hessian_error(setting, worst);
    add_dot_product_error(setting, worst);
    add_symplectic_error(setting, worst);
    if (::testing::Test::HasFailure()) break;
  }
  EXPECT_LE(without_steps, std::max(1, count / 50));
  return worst;
}

inline void expect_accurate(const Worst& worst) {
  EXPECT_LE(worst.gradient.error, tolerance(1e-11)) << "seed " << worst.gradient.seed;
  EXPECT_LE(worst.by_parameters.error, tolerance(1e-11)) << "seed " << worst.by_parameters.seed;
  EXPECT_LE(worst.hessian.error, tolerance(1e-9)) << "seed " << worst.hessian.seed;
  EXPECT_LE(worst.dot_product.error, tolerance(1e-12)) << "seed " << worst.dot_product.seed;
  EXPECT_LE(worst.symplectic.error, tolerance(1e-10)) << "seed " << worst.symplectic.seed;
  EXPECT_GT(worst.gradient.error, 0.0) << "the same path ran twice";
}

}  // namespace lamprey::tests
