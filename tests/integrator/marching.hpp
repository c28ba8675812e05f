// Motions that the integrator's tests share: starts, smooth moments, and marches of every scheme.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "chains.hpp"
#include "integrator/march.hpp"

namespace lamprey::tests {

inline constexpr std::array<integrator::Scheme, 5> all_schemes = {
    integrator::Scheme::paper, integrator::Scheme::trapezoid, integrator::Scheme::midpoint, integrator::Scheme::order4,
    integrator::Scheme::order6};

inline const char* scheme_name(integrator::Scheme scheme) {
  constexpr std::array<const char*, 5> names = {"paper", "trapezoid", "midpoint", "order4", "order6"};
  return names[static_cast<std::size_t>(scheme)];
}

/// A swimmer in motion.
struct Moving {
  model::System system;
  integrator::State start;
};

/// The chain of examples/tumble.toml: 101.94622872518 J.
inline Moving tumbling_chain() {
  const model::System system(paper_chain());
  Eigen::VectorXd velocity(12);
  velocity << 0.6, -0.9, 1.2, 2.5, 1.0, -1.5, -2.0, 1.5, 1.0, 0.5, 0.2, -0.1;
  const Matrix3d I = Matrix3d::Identity();
  return {system, integrator::state_of_velocity(system, {I, I, lie::exp(Vector3d(0, 0, M_PI / 4))}, Vector3d::Zero(),
                                                velocity)};
}

/// A swimmer of this description somewhere, with rates of about 1 rad/s and 1 m/s.
inline Moving moving(Random& random, const model::SwimmerDescription& swimmer) {
  const model::System system(swimmer);
  Eigen::VectorXd velocity(system.velocity_count());
  for (double& v : velocity) v = random.normal();
  const mechanics::Rotations rotation = random_rotations(random, system);
  return {system, integrator::state_of_velocity(system, rotation, random.vector(), velocity)};
}

inline model::SwimmerDescription without_dampers(model::SwimmerDescription swimmer) {
  for (model::JointDescription& joint : swimmer.joints) joint.damping = 0.0;
  return swimmer;
}

/// Smooth moments that the joints can exert, N m, two waves for each.
class Waves {
 public:
  Waves(Random& random, const model::System& system, double size)
      : first_(random_moments(random, system, size)), second_(random_moments(random, system, size)) {}

  mechanics::Moments operator()(double time) const {
    mechanics::Moments u = first_;
    for (std::size_t j = 0; j < u.size(); ++j)
      u[j] = std::sin(5.0 * time + double(j)) * first_[j] + std::cos(3.0 * time - double(j)) * second_[j];
    return u;
  }

 private:
  mechanics::Moments first_, second_;
};

using TimedControl = std::function<mechanics::Moments(double time)>;
using NodeWitness = std::function<void(int step, const integrator::State& state)>;

/// Marches from time 0 with the moments at the stages' nodes; the witness sees the state after each whole step. The test
/// fails where a step does not converge.
inline integrator::State marched(const model::System& system, integrator::Scheme scheme, double time_step, int steps,
                                 integrator::State state, const TimedControl& control = {},
                                 const NodeWitness& witness = {}) {
  integrator::March march(system, scheme);
  std::vector<mechanics::Moments> moments(
      march.nodes().size(), mechanics::Moments(static_cast<std::size_t>(system.joint_count()), Vector3d::Zero()));
  const integrator::StageControl at_node = [&](int node) -> const mechanics::Moments& {
    return moments[model::at(node)];
  };
  for (int step = 0; step < steps; ++step) {
    for (std::size_t node = 0; control && node < moments.size(); ++node)
      moments[node] = control(time_step * (step + march.nodes()[node]));
    const auto report = march.advance(time_step, at_node, state);
    EXPECT_TRUE(report.converged) << scheme_name(scheme) << ", step " << step << ", residual " << report.residual;
    if (!report.converged) break;
    if (witness) witness(step, state);
  }
  return state;
}

/// ‖R − R'‖ over all bodies.
inline double rotation_distance(const mechanics::Rotations& a, const mechanics::Rotations& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]).squaredNorm();
  return std::sqrt(squares);
}

}  // namespace lamprey::tests
