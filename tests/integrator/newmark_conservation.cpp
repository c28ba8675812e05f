// A counterexample for integrators that are of second order and symmetric on the group but not variational (Bou-Rabee,
// Ortolan, Saccon, arXiv 1005.3078): the semi-explicit Lie–Newmark method. Their rigid body in a static potential is here
// a body in a fluid: its linear momentum p stays, so its turning feels the potential ½ p·R M⁻¹ Rᵀ p.
#include <gtest/gtest.h>

#include "integrator/free_motion.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

// A body that turns in the potential of its own wake.
struct Drifting {
  model::System system;
  integrator::State start;
  Vector3d p;  // kg m/s, world

  // Drawn so that the motion is chaotic: where it is not, Lie–Newmark keeps energy too.
  static Drifting make() {
    Random random(1);
    model::SwimmerDescription swimmer;
    swimmer.density = 1.0;
    model::BodyDescription body;
    body.name = "body";
    body.semi_axes = Vector3d(2.0, 1.0, 0.5);
    const double M_2 = random.uniform(4.0, 9.0), M_1 = random.uniform(1.5, 3.0);
    body.mass_matrix = Matrix3d(Vector3d(1.0, M_1, M_2).asDiagonal());
    const double J_2 = random.uniform(2.0, 4.0), J_1 = random.uniform(2.0, 4.0), J_0 = random.uniform(1.0, 2.0);
    body.inertia_matrix = Matrix3d(Vector3d(J_0, J_1, J_2).asDiagonal());
    swimmer.bodies = {body};
    const model::System system(swimmer);
    Eigen::VectorXd velocity(6);
    velocity.head<3>() = random.vector(0.7);
    velocity.tail<3>() = random.vector(1.5);
    const auto start = integrator::state_of_velocity(system, {random.rotation()}, Vector3d::Zero(), velocity);
    return {system, start, start.momentum.tail<3>()};
  }

  double energy(const integrator::State& state) const {
    return mechanics::kinetic_energy(system, state.rotation, integrator::velocity_of_state(system, state));
  }
  Vector3d angular_momentum(const integrator::State& state) const {
    return mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum).angular;
  }
  // Moment of the fluid, MV × V in the body frame, with MV = Rᵀ p.
  Vector3d torque(const Matrix3d& R) const {
    const Vector3d seen = R.transpose() * p;
    return seen.cross(velocity(R));
  }
  Vector3d velocity(const Matrix3d& R) const { return system.body(0).mass_matrix.inverse() * (R.transpose() * p); }
};

// W_{k+1/2} = W_k + h/2 J⁻¹(τ_k − W_{k+1/2} × J W_{k+1/2}), R_{k+1} = R_k exp(h W_{k+1/2}), and the second half likewise.
class LieNewmark {
 public:
  explicit LieNewmark(const Drifting& body) : body_(body), J_(body.system.body(0).inertia_matrix) {}

  void advance(double h, integrator::State& state) const {
    const Vector3d W = J_.inverse() * state.momentum.head<3>();
    const Matrix3d R = state.rotation[0];
    Vector3d half = W;
    for (int n = 0; n < 50; ++n) half = W + 0.5 * h * J_.inverse() * (body_.torque(R) - half.cross(J_ * half));
    const Matrix3d R_next = R * lie::exp(h * half);
    const Vector3d W_next = half + 0.5 * h * J_.inverse() * (body_.torque(R_next) - half.cross(J_ * half));
    state.position += 0.5 * h * (R * body_.velocity(R) + R_next * body_.velocity(R_next));
    state.rotation[0] = R_next;
    state.momentum.head<3>() = J_ * W_next;
  }

 private:
  const Drifting& body_;
  Matrix3d J_;
};

// What a march does to energy and angular momentum.
struct Kept {
  double largest = 0.0;      // change of energy, relative
  double angular = 0.0;      // change of angular momentum about the starting point, relative
  std::vector<double> mean;  // of the energy's change over each eighth of the march
  explicit Kept(int steps) : mean(8, 0.0), steps_(steps) {}
  void add(const Drifting& body, int step, const integrator::State& state) {
    const double change = body.energy(state) / body.energy(body.start) - 1.0;
    largest = std::max(largest, std::abs(change));
    mean[static_cast<std::size_t>(8L * step / steps_)] += 8.0 * change / steps_;
    const Vector3d first = body.angular_momentum(body.start);
    angular = std::max(angular, (body.angular_momentum(state) - first).norm() / first.norm());
  }
  // How far the mean wanders, against the oscillation about it.
  double wandering() const {
    const auto [least, most] = std::minmax_element(mean.begin(), mean.end());
    return (*most - *least) / largest;
  }
  bool energy_holds() const { return wandering() < 0.05; }
  bool momentum_holds() const { return angular <= tolerance(1e-9); }

 private:
  int steps_;
};

Kept kept_by(const Drifting& body, integrator::Scheme scheme, double h, int steps) {
  Kept kept(steps);
  marched(body.system, scheme, h, steps, body.start, {},
          [&](int step, const integrator::State& state) { kept.add(body, step, state); });
  return kept;
}

Kept kept_by_newmark(const Drifting& body, double h, int steps) {
  Kept kept(steps);
  const LieNewmark newmark(body);
  integrator::State state = body.start;
  for (int step = 0; step < steps; ++step) {
    newmark.advance(h, state);
    kept.add(body, step, state);
  }
  return kept;
}

constexpr double newmark_step = 0.2;  // s: the body turns by some 0.2 rad
constexpr int newmark_steps = 200'000;

// Measured over 400,000 steps: means of Lie–Newmark's energy from 0.7 % to −6 %, of midpoint's within 0.013 %; angular
// momentum 35 % off and 3e-10.
TEST(LieNewmark, fails_the_checks_of_energy_and_momentum) {
  const Kept kept = kept_by_newmark(Drifting::make(), newmark_step, newmark_steps);
  EXPECT_FALSE(kept.energy_holds()) << kept.wandering();
  EXPECT_FALSE(kept.momentum_holds()) << kept.angular;
}

class NewmarkCheck : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(NewmarkCheck, is_passed_by_every_variational_scheme) {
  const Kept kept =
      kept_by(Drifting::make(), GetParam(), newmark_step, newmark_steps / (order(GetParam()) > 2 ? 10 : 1));
  EXPECT_TRUE(kept.energy_holds()) << kept.wandering();
  EXPECT_TRUE(kept.momentum_holds()) << kept.angular;
  EXPECT_GT(kept.largest, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Schemes, NewmarkCheck, ::testing::ValuesIn(all_schemes), named_by_value);

// Both are of second order: one step tells them apart by nothing but their structure.
TEST(LieNewmark, is_of_second_order_all_the_same) {
  const Drifting body = Drifting::make();
  const auto reference = marched(body.system, integrator::Scheme::order6, 0.01, 100, body.start);
  const auto error = [&](int steps) {
    const LieNewmark newmark(body);
    integrator::State state = body.start;
    for (int k = 0; k < steps; ++k) newmark.advance(1.0 / steps, state);
    return rotation_distance(state.rotation, reference.rotation);
  };
  EXPECT_NEAR(std::log2(error(100) / error(200)), 2.0, tolerance(0.05));
}

}  // namespace
}  // namespace lamprey::tests
