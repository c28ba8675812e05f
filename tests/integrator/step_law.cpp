#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "chains.hpp"
#include "integrator/scheme.hpp"
#include "integrator/step.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::Scheme;
using integrator::State;
using mechanics::Moments;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Swimmer {
  model::System system;
  State start;
};

Swimmer tumbling_tree(unsigned seed, int bodies) {
  Random random(seed);
  const model::System system(random_tree(random, bodies));
  VectorXd velocity(system.velocity_count());
  for (double& v : velocity) v = random.normal();
  mechanics::Rotations rotation;
  for (int i = 0; i < bodies; ++i) rotation.push_back(random.rotation());
  return {system, integrator::state_of_velocity(system, rotation, random.vector(), velocity)};
}

// The paper's chain and start shape, in motion.
Swimmer tumbling_chain() {
  const model::System system(paper_chain());
  VectorXd velocity(12);
  velocity << 0.6, -0.9, 1.2, 2.5, 1.0, -1.5, -2.0, 1.5, 1.0, 0.5, 0.2, -0.1;
  const mechanics::Rotations rotation = {Matrix3d::Identity(), Matrix3d::Identity(),
                                         lie::exp(Vector3d(0.0, 0.0, 0.25 * std::numbers::pi))};
  return {system, integrator::state_of_velocity(system, rotation, Vector3d::Zero(), velocity)};
}

// Moments at node k, different for each joint; `joint` numbers them.
Vector3d moment(int joint, double k) {
  return {std::sin(0.11 * k + joint), std::cos(0.07 * k + 2.0 * joint), std::sin(0.05 * k - joint)};
}

Moments moments(const model::System& system, int k, double size) {
  Moments u;
  for (int j = 0; j < system.joint_count(); ++j) u.push_back(size * moment(j, k));
  return u;
}

State marched(const model::System& system, Scheme scheme, double h, int steps, State state, double torque) {
  integrator::StepWorkspace work(system);
  for (int k = 0; k < steps; ++k) {
    const auto report = advance(system, lagrangian_of(scheme), h, moments(system, k, torque),
                                moments(system, k + 1, torque), state, work);
    EXPECT_TRUE(report.converged) << "step " << k;
  }
  return state;
}

// Largest difference of two states: rotations, position relative to its size, momentum relative to its size.
double difference(const State& a, const State& b) {
  double largest = (a.position - b.position).lpNorm<Eigen::Infinity>() / (1.0 + a.position.lpNorm<Eigen::Infinity>());
  for (std::size_t i = 0; i < a.rotation.size(); ++i)
    largest = std::max(largest, (a.rotation[i] - b.rotation[i]).lpNorm<Eigen::Infinity>());
  return std::max(largest, (a.momentum - b.momentum).lpNorm<Eigen::Infinity>() / a.momentum.lpNorm<Eigen::Infinity>());
}

class StepLaw : public ::testing::TestWithParam<Scheme> {};

// The state seen from a world turned by Q and shifted.
State seen_from(const State& state, const Matrix3d& Q, const Vector3d& shift) {
  State moved = state;
  for (Matrix3d& R : moved.rotation) R = Q * R;
  moved.position = Q * state.position + shift;
  moved.momentum.tail<3>() = Q * state.momentum.tail<3>();
  return moved;
}

TEST_P(StepLaw, a_turned_and_shifted_start_gives_the_turned_and_shifted_motion) {
  Random random(31);
  for (int bodies : {1, 3, 6}) {
    const Swimmer swimmer = tumbling_tree(30U + static_cast<unsigned>(bodies), bodies);
    const Matrix3d Q = random.rotation();
    const Vector3d shift = random.vector(10.0);
    const State end = marched(swimmer.system, GetParam(), 5e-3, 200, swimmer.start, 1.0);
    const State moved = marched(swimmer.system, GetParam(), 5e-3, 200, seen_from(swimmer.start, Q, shift), 1.0);
    EXPECT_LE(difference(seen_from(end, Q, shift), moved), tolerance(1e-11)) << bodies << " bodies";
    EXPECT_GT(difference(swimmer.start, end), 0.1) << "nothing moved";
  }
}

// Error of returning: march, reverse, march back with the moments in reverse order.
double error_of_return(const Swimmer& swimmer, Scheme scheme, double h, int steps, double torque) {
  State state = marched(swimmer.system, scheme, h, steps, swimmer.start, torque);
  EXPECT_GT(difference(swimmer.start, state), 0.1) << "nothing moved";
  state.momentum *= -1.0;
  integrator::StepWorkspace work(swimmer.system);
  for (int k = steps; k > 0; --k)
    EXPECT_TRUE(advance(swimmer.system, lagrangian_of(scheme), h, moments(swimmer.system, k, torque),
                        moments(swimmer.system, k - 1, torque), state, work)
                    .converged);
  state.momentum *= -1.0;
  return difference(swimmer.start, state);
}

TEST(Reversal, the_trapezoid_marches_back_to_its_start) {
  EXPECT_LE(error_of_return(tumbling_chain(), Scheme::trapezoid, 1e-3, 500, 50.0), tolerance(1e-10));
  EXPECT_LE(error_of_return(tumbling_tree(41, 5), Scheme::trapezoid, 5e-3, 200, 1.0), tolerance(1e-10));
}

TEST(Reversal, the_paper_scheme_does_not_which_shows_that_the_check_can_fail) {
  EXPECT_GT(error_of_return(tumbling_chain(), Scheme::paper, 1e-3, 500, 50.0), 1e-4);
}

// Bodies but the root, and joints, in another order.
model::SwimmerDescription shuffled(const model::SwimmerDescription& tree, const std::vector<int>& order) {
  model::SwimmerDescription other = tree;
  for (std::size_t n = 0; n < order.size(); ++n) {
    other.bodies[n + 1] = tree.bodies[at(order[n]) + 1];
    other.joints[order.size() - 1 - n] = tree.joints[at(order[n])];
  }
  return other;
}

TEST_P(StepLaw, the_order_of_bodies_and_joints_does_not_matter) {
  constexpr int bodies = 7;
  Random random(51);
  const model::SwimmerDescription tree = random_tree(random, bodies);
  const model::System system(tree);
  const std::vector<int> order = {3, 5, 0, 4, 1, 2};  // children come before their parents in places
  const model::System other(shuffled(tree, order));
  State start = tumbling_tree(52, bodies).start;
  State start_other = start;
  for (std::size_t n = 0; n < order.size(); ++n) {
    const int from = order[n] + 1;
    const int to = static_cast<int>(n) + 1;
    start_other.rotation[at(to)] = start.rotation[at(from)];
    start_other.momentum.segment<3>(3 * to) = start.momentum.segment<3>(3 * from);
  }
  integrator::StepWorkspace work(system), work_other(other);
  for (int k = 0; k < 100; ++k) {
    const Moments u = moments(system, k, 1.0), u_next = moments(system, k + 1, 1.0);
    Moments v = u, v_next = u;
    for (std::size_t n = 0; n < order.size(); ++n) {
      v[order.size() - 1 - n] = u[at(order[n])];
      v_next[order.size() - 1 - n] = u_next[at(order[n])];
    }
    ASSERT_TRUE(advance(system, lagrangian_of(GetParam()), 5e-3, u, u_next, start, work).converged);
    ASSERT_TRUE(advance(other, lagrangian_of(GetParam()), 5e-3, v, v_next, start_other, work_other).converged);
  }
  EXPECT_LE((start.position - start_other.position).norm(), tolerance(1e-11));
  for (std::size_t n = 0; n < order.size(); ++n)
    EXPECT_LE((start.rotation[at(order[n]) + 1] - start_other.rotation[n + 1]).norm(), tolerance(1e-11));
}

// A chain a – b – c described from a or from c; moments act on the parent, in its frame.
model::SwimmerDescription chain_of_three(const model::SwimmerDescription& bodies, bool reversed) {
  model::SwimmerDescription chain;
  chain.density = bodies.density;
  chain.bodies = bodies.bodies;
  const Vector3d d[4] = {{1.0, 0.2, 0.0}, {-0.8, 0.1, 0.3}, {0.7, -0.2, 0.1}, {-1.1, 0.0, -0.2}};
  const auto joint = [](const std::string& parent, const std::string& child, const Vector3d& p, const Vector3d& c) {
    model::JointDescription described;
    described.name = child;
    described.parent = parent;
    described.child = child;
    described.parent_offset = p;
    described.child_offset = c;
    return described;
  };
  if (reversed) {
    std::reverse(chain.bodies.begin(), chain.bodies.end());
    chain.joints = {joint("body2", "body1", d[3], d[2]), joint("body1", "body0", d[1], d[0])};
  } else {
    chain.joints = {joint("body0", "body1", d[0], d[1]), joint("body1", "body2", d[2], d[3])};
  }
  return chain;
}

TEST(Root, the_trapezoid_does_not_depend_on_which_body_is_the_root) {
  Random random(61);
  const model::SwimmerDescription tree = random_tree(random, 3);
  const model::System system(chain_of_three(tree, false)), other(chain_of_three(tree, true));
  mechanics::Rotations R;
  std::vector<Vector3d> Omega;
  for (int i = 0; i < 3; ++i) R.push_back(random.rotation()), Omega.push_back(random.vector());
  const mechanics::Rotations R_reversed(R.rbegin(), R.rend());
  const Vector3d x = random.vector(), x_rate = random.vector();
  // where the last body is, and how fast
  const Vector3d x_last = system.mass_centres(R, x)[2];
  Vector3d rate = x_rate;
  for (int i = 0; i < 3; ++i)
    for (const model::PathPoint& point : system.body(2).path)
      if (point.body == i) rate += R[at(i)] * Omega[at(i)].cross(point.offset);
  VectorXd velocity(12), velocity_reversed(12);
  velocity << Omega[0], Omega[1], Omega[2], x_rate;
  velocity_reversed << Omega[2], Omega[1], Omega[0], rate;
  State state = integrator::state_of_velocity(system, R, x, velocity);
  State reversed = integrator::state_of_velocity(other, R_reversed, x_last, velocity_reversed);
  state = marched(system, Scheme::trapezoid, 5e-3, 100, state, 0.0);
  reversed = marched(other, Scheme::trapezoid, 5e-3, 100, reversed, 0.0);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LE((state.rotation[i] - reversed.rotation[2 - i]).norm(), tolerance(1e-12));
  EXPECT_LE((system.mass_centres(state.rotation, state.position)[2] - reversed.position).norm(), tolerance(1e-12));
  EXPECT_GT((state.position - x).norm(), 0.1);
}

TEST_P(StepLaw, an_absurd_step_is_reported_and_leaves_the_state_alone) {
  const Swimmer swimmer = tumbling_chain();
  const Moments u = moments(swimmer.system, 3, 50.0);
  for (double h : {20.0, 1e3, 1e6, 1e150, std::numeric_limits<double>::infinity(), std::nan("")}) {
    State state = swimmer.start;
    integrator::StepWorkspace work(swimmer.system);
    const auto failed = advance(swimmer.system, lagrangian_of(GetParam()), h, u, u, state, work);
    EXPECT_FALSE(failed.converged) << "h = " << h;
    EXPECT_TRUE(state.rotation == swimmer.start.rotation && state.position == swimmer.start.position &&
                state.momentum == swimmer.start.momentum)
        << "h = " << h;
    // the same workspace serves on
    const auto report = advance(swimmer.system, lagrangian_of(GetParam()), 1e-3, u, u, state, work);
    EXPECT_TRUE(report.converged) << "after h = " << h;
    State fresh = swimmer.start;
    integrator::StepWorkspace fresh_work(swimmer.system);
    advance(swimmer.system, lagrangian_of(GetParam()), 1e-3, u, u, fresh, fresh_work);
    EXPECT_LE(difference(fresh, state), tolerance(1e-14)) << "after h = " << h;
  }
}

TEST_P(StepLaw, numbers_that_are_not_finite_are_reported_and_do_not_spread) {
  const Swimmer swimmer = tumbling_chain();
  const Moments good = moments(swimmer.system, 3, 50.0);
  Moments bad = good;
  bad[1].y() = std::nan("");
  State state = swimmer.start;
  integrator::StepWorkspace work(swimmer.system);
  EXPECT_FALSE(advance(swimmer.system, lagrangian_of(GetParam()), 1e-3, bad, good, state, work).converged);
  EXPECT_EQ(difference(swimmer.start, state), 0.0);
  EXPECT_TRUE(advance(swimmer.system, lagrangian_of(GetParam()), 1e-3, good, good, state, work).converged);
}

// In a vacuum the trapezoid is the discrete Moser–Veselov top, whose energy is exact in its nodes' momenta.
TEST(FreeBody, in_a_vacuum_keeps_energy_and_momentum_to_round_off) {
  model::SwimmerDescription swimmer;
  model::BodyDescription body;
  body.name = "brick";
  body.semi_axes = Vector3d(1.0, 2.0, 0.5);
  body.mass = 3.0;
  body.body_inertia = Matrix3d(Vector3d(1.0, 2.0, 2.6).asDiagonal());
  swimmer.bodies = {body};
  const model::System system(swimmer);
  VectorXd velocity(6);
  velocity << 0.05, 3.0, -0.02, 0.4, -0.3, 0.2;  // near the unstable axis: it tumbles
  State state =
      integrator::state_of_velocity(system, {lie::exp(Vector3d(0.3, -0.4, 0.2))}, Vector3d(1, 2, 3), velocity);
  const auto energy = [&system](const State& s) {
    return mechanics::kinetic_energy(system, s.rotation, integrator::velocity_of_state(system, s));
  };
  const double first = energy(state);
  const auto start = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  integrator::StepWorkspace work(system);
  double energy_error = 0.0, momentum_error = 0.0, least_spin = 3.0;
  for (int k = 0; k < 2000; ++k) {
    ASSERT_TRUE(advance(system, lagrangian_of(Scheme::trapezoid), 1e-2, {}, {}, state, work).converged);
    energy_error = std::max(energy_error, std::abs(energy(state) / first - 1.0));
    const auto now = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
    momentum_error = std::max({momentum_error, (now.linear - start.linear).norm() / start.linear.norm(),
                               (now.angular - start.angular).norm() / start.angular.norm()});
    least_spin = std::min(least_spin, state.momentum[1] / 2.0);
  }
  EXPECT_LE(energy_error, tolerance(1e-12));
  EXPECT_LE(momentum_error, tolerance(1e-12));
  EXPECT_LT(least_spin, -2.5) << "it did not tumble, so the check says little";
  EXPECT_LE((state.position - Vector3d(1, 2, 3) - 20.0 * Vector3d(0.4, -0.3, 0.2)).norm(), tolerance(1e-11));
}

INSTANTIATE_TEST_SUITE_P(Schemes, StepLaw, ::testing::Values(Scheme::paper, Scheme::trapezoid));

}  // namespace
}  // namespace lamprey::tests
