#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrator/joints_stay.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using integrator::Scheme;
using integrator::State;
using mechanics::Moments;
using model::at;

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
  for (int bodies : {1, 3, 6, 9}) {
    const bool any_joint = bodies == 6 || bodies == 9;
    const Moving swimmer = moving(random, any_joint ? random_swimmer(random, bodies) : random_tree(random, bodies));
    const Waves control(random, swimmer.system, 1.0);
    const Matrix3d Q = random.rotation();
    const Vector3d shift = random.vector(10.0);
    const State end = marched(swimmer.system, GetParam(), 5e-3, 200, swimmer.start, control);
    const State moved = marched(swimmer.system, GetParam(), 5e-3, 200, seen_from(swimmer.start, Q, shift), control);
    EXPECT_LE(difference(seen_from(end, Q, shift), moved), tolerance(1e-11)) << bodies << " bodies";
    EXPECT_GT(difference(swimmer.start, end), 0.1) << "nothing moved";
  }
}

// Error of returning: march, reverse, march back with the moments in reverse order.
double error_of_return(const Moving& swimmer, Scheme scheme, double h, int steps, const TimedControl& control) {
  State state = marched(swimmer.system, scheme, h, steps, swimmer.start, control);
  EXPECT_GT(difference(swimmer.start, state), 0.1) << "nothing moved";
  state.momentum *= -1.0;
  state = marched(swimmer.system, scheme, h, steps, state, [&](double time) { return control(steps * h - time); });
  state.momentum *= -1.0;
  return difference(swimmer.start, state);
}

TEST(Reversal, symmetric_schemes_march_back_to_their_start) {
  for (Scheme scheme : {Scheme::trapezoid, Scheme::midpoint, Scheme::order4, Scheme::order6}) {
    Random random(41);
    const Moving chain = tumbling_chain();
    EXPECT_LE(error_of_return(chain, scheme, 1e-3, 500, Waves(random, chain.system, 50.0)), tolerance(1e-10))
        << scheme_name(scheme);
    for (int bodies : {3, 5, 9}) {
      const Moving swimmer = moving(random, without_dampers(random_swimmer(random, bodies)));
      EXPECT_LE(error_of_return(swimmer, scheme, 5e-3, 200, Waves(random, swimmer.system, 1.0)), tolerance(1e-10))
          << scheme_name(scheme) << ", " << bodies << " bodies";
    }
  }
}

TEST(Reversal, the_paper_scheme_does_not_which_shows_that_the_check_can_fail) {
  Random random(41);
  const Moving chain = tumbling_chain();
  EXPECT_GT(error_of_return(chain, Scheme::paper, 1e-3, 500, Waves(random, chain.system, 50.0)), 1e-4);
}

TEST(Reversal, a_damped_swimmer_does_not_come_back_by_the_turned_momentum) {
  Random random(42);
  const Moving swimmer = moving(random, random_swimmer(random, 7));
  ASSERT_TRUE(std::any_of(swimmer.system.joints().begin(), swimmer.system.joints().end(),
                          [](const model::Joint& joint) { return joint.damping > 0.0; }));
  EXPECT_GT(error_of_return(swimmer, Scheme::midpoint, 5e-3, 200, Waves(random, swimmer.system, 1.0)), 1e-4);
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
  for (const bool any_joint : {false, true}) {
    const model::SwimmerDescription tree = any_joint ? random_swimmer(random, bodies) : random_tree(random, bodies);
    const Moving swimmer = moving(random, tree);
    const model::System& system = swimmer.system;
    const std::vector<int> order = {3, 5, 0, 4, 1, 2};  // children come before their parents in places
    const model::System other(shuffled(tree, order));
    const auto places = [&](int from) {  // of a body in the other system
      for (int i = 0; i < bodies; ++i)
        if (other.body(i).name == system.body(from).name) return i;
      return -1;
    };
    State start = swimmer.start;
    for (int i = 0; i < bodies; ++i) {
      const int to = places(i);
      start.rotation[at(to)] = swimmer.start.rotation[at(i)];
      for (int f = 0; f < system.body(i).freedoms; ++f)
        start.momentum[other.body(to).velocity_offset + f] = swimmer.start.momentum[system.body(i).velocity_offset + f];
    }
    const Waves control(random, system, 1.0);
    const auto control_of_other = [&](double time) {
      const Moments u = control(time);
      Moments v = u;
      for (std::size_t n = 0; n < order.size(); ++n) v[order.size() - 1 - n] = u[at(order[n])];
      return v;
    };
    const State end = marched(system, GetParam(), 5e-3, 100, swimmer.start, control);
    const State end_other = marched(other, GetParam(), 5e-3, 100, start, control_of_other);
    EXPECT_LE((end.position - end_other.position).norm(), tolerance(1e-11));
    for (int i = 0; i < bodies; ++i)
      EXPECT_LE((end.rotation[at(i)] - end_other.rotation[at(places(i))]).norm(), tolerance(1e-11));
    EXPECT_GT(rotation_distance(swimmer.start.rotation, end.rotation), 0.1) << "nothing moved";
  }
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

TEST(LongChain, of_a_thousand_bodies_marches_from_rest_and_keeps_its_momentum) {
  model::SwimmerDescription chain;
  chain.density = paper_density;
  const model::BodyDescription link = paper_chain().bodies[1];
  for (int i = 0; i < 1000; ++i) {
    chain.bodies.push_back(link);
    chain.bodies.back().name = std::to_string(i);
    if (i == 0) continue;
    model::JointDescription joint = paper_chain().joints[0];
    joint.name = joint.child = std::to_string(i);
    joint.parent = std::to_string(i - 1);
    joint.parent_offset = Vector3d(5.5, 0, 0);
    joint.child_offset = Vector3d(-5.5, 0, 0);
    chain.joints.push_back(joint);
  }
  const model::System system(chain);
  const mechanics::Rotations straight(1000, Matrix3d::Identity());
  State state = integrator::state_of_velocity(system, straight, Vector3d::Zero(), VectorXd::Zero(3003));
  integrator::StepWorkspace work(system);
  const auto moments = [&](int k) {
    Moments u;
    for (int j = 0; j < 999; ++j)
      u.emplace_back(5.0 * std::sin(3.0 * j), 100.0 * std::cos(2.0 * j + 0.01 * k), 300.0 * std::sin(j + 0.01 * k));
    return u;
  };
  double largest_body = 0.0;
  for (int k = 0; k < 30; ++k) {
    const integrator::StepReport report =
        advance(system, mechanics::DiscreteLagrangian::trapezoid, 1e-3, moments(k), moments(k + 1), state, work);
    ASSERT_TRUE(report.converged) << "step " << k << ": " << report.residual;
    for (const Vector3d& impulse : work.momenta.impulse) largest_body = std::max(largest_body, impulse.norm());
  }
  const auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  EXPECT_LE(total.linear.norm(), tolerance(1e-12) * largest_body);
  EXPECT_LE(total.angular.norm(), tolerance(1e-12) * largest_body);
  EXPECT_GT(largest_body, 0.1);
}

// The paper's scheme treats its root in a way of its own.
class RootLaw : public StepLaw {};

TEST_P(RootLaw, which_body_is_the_root_does_not_matter) {
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
  state = marched(system, GetParam(), 5e-3, 100, state);
  reversed = marched(other, GetParam(), 5e-3, 100, reversed);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LE((state.rotation[i] - reversed.rotation[2 - i]).norm(), tolerance(1e-12));
  EXPECT_LE((system.mass_centres(state.rotation, state.position)[2] - reversed.position).norm(), tolerance(1e-12));
  EXPECT_GT((state.position - x).norm(), 0.1);
}

bool same(const State& a, const State& b) {
  return a.rotation == b.rotation && a.position == b.position && a.momentum == b.momentum;
}

// The paper's chain, and a swimmer with every kind of joint.
std::vector<Moving> two_swimmers() {
  Random random(71);
  return {tumbling_chain(), moving(random, random_swimmer(random, 8))};
}

TEST_P(StepLaw, an_absurd_step_is_reported_and_leaves_the_state_alone) {
  for (const Moving& swimmer : two_swimmers()) {
    Random random(72);
    const Moments u = Waves(random, swimmer.system, 50.0)(0.3);
    const integrator::StageControl control = [&](int) -> const Moments& { return u; };
    for (double h : {1e3, 1e6, 1e150, std::numeric_limits<double>::infinity(), std::nan("")}) {
      State state = swimmer.start;
      integrator::March march(swimmer.system, GetParam());
      EXPECT_FALSE(march.advance(h, control, state).converged) << "h = " << h;
      EXPECT_TRUE(same(state, swimmer.start)) << "h = " << h;
      // the same march serves on
      EXPECT_TRUE(march.advance(1e-3, control, state).converged) << "after h = " << h;
      State fresh = swimmer.start;
      integrator::March(swimmer.system, GetParam()).advance(1e-3, control, fresh);
      EXPECT_LE(difference(fresh, state), tolerance(1e-13)) << "after h = " << h;
    }
  }
}

TEST_P(StepLaw, numbers_that_are_not_finite_are_reported_and_do_not_spread) {
  for (const Moving& swimmer : two_swimmers()) {
    Random random(72);
    const Moments good = Waves(random, swimmer.system, 50.0)(0.3);
    Moments bad = good;
    for (const model::Joint& joint : swimmer.system.joints())
      if (joint.kind != model::JointKind::fixed) bad[at(joint.child) - 1][0] = std::nan("");
    State state = swimmer.start;
    integrator::March march(swimmer.system, GetParam());
    for (int place : {0, march.stages()}) {  // at the beginning of a step, and at its very end
      const integrator::StageControl spoilt = [&](int node) -> const Moments& { return node == place ? bad : good; };
      EXPECT_FALSE(march.advance(1e-3, spoilt, state).converged);
      EXPECT_TRUE(same(state, swimmer.start));
    }
    EXPECT_TRUE(march
                    .advance(
                        1e-3, [&](int) -> const Moments& { return good; }, state)
                    .converged);
    EXPECT_GT(difference(state, swimmer.start), 0.0);
    EXPECT_TRUE(std::isfinite(difference(state, swimmer.start)));
  }
}

model::BodyDescription brick(const std::string& name, double mass, const Matrix3d& inertia) {
  model::BodyDescription body;
  body.name = name;
  body.semi_axes = Vector3d(1.0, 2.0, 0.5);
  body.mass = mass;
  body.body_inertia = inertia;
  return body;
}

// In a vacuum trapezoid and midpoint are one: the discrete Moser–Veselov top, whose energy is exact in its nodes' momenta.
TEST_P(StepLaw, a_free_body_in_a_vacuum_keeps_energy_and_momentum_to_round_off) {
  model::SwimmerDescription swimmer;
  swimmer.bodies = {brick("brick", 3.0, Matrix3d(Vector3d(1.0, 2.0, 2.6).asDiagonal()))};
  const model::System system(swimmer);
  VectorXd velocity(6);
  velocity << 0.05, 3.0, -0.02, 0.4, -0.3, 0.2;  // near the unstable axis: it tumbles
  const State start =
      integrator::state_of_velocity(system, {lie::exp(Vector3d(0.3, -0.4, 0.2))}, Vector3d(1, 2, 3), velocity);
  const auto energy = [&system](const State& s) {
    return mechanics::kinetic_energy(system, s.rotation, integrator::velocity_of_state(system, s));
  };
  const auto first = mechanics::spatial_momentum(system, start.rotation, start.position, start.momentum);
  double energy_error = 0.0, momentum_error = 0.0, least_spin = 3.0;
  const State end = marched(system, GetParam(), 1e-2, 2000, start, {}, [&](int, const State& state) {
    energy_error = std::max(energy_error, std::abs(energy(state) / energy(start) - 1.0));
    const auto now = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
    momentum_error = std::max({momentum_error, (now.linear - first.linear).norm() / first.linear.norm(),
                               (now.angular - first.angular).norm() / first.angular.norm()});
    least_spin = std::min(least_spin, state.momentum[1] / 2.0);
  });
  EXPECT_LE(energy_error, tolerance(1e-12));
  EXPECT_LE(momentum_error, tolerance(1e-12));
  EXPECT_LT(least_spin, -2.5) << "it did not tumble, so the check says little";
  EXPECT_LE((end.position - Vector3d(1, 2, 3) - 20.0 * Vector3d(0.4, -0.3, 0.2)).norm(), tolerance(1e-11));
}

// A tree whose joints are all fixed, and the one body that it is.
struct Welded {
  model::SwimmerDescription tree, body;
  Matrix3d root_to_body = Matrix3d::Identity();
  Vector3d centre = Vector3d::Zero();  // of the one body, m, from the root's mass centre, root's frame
};

// Rotations and mass centres of a fixed tree in the frame of its root.
mechanics::Rotations fixed_rotations(const model::System& system) {
  mechanics::Rotations R(at(system.body_count()), Matrix3d::Identity());
  for (int i : system.root_to_leaves())
    if (i > 0) R[at(i)] = R[at(system.body(i).parent)] * system.joint(system.body(i).joint).reference_rotation;
  return R;
}

void fix_joints(Random& random, model::SwimmerDescription& tree) {
  for (auto& joint : tree.joints) {
    joint.kind = model::JointKind::fixed;
    joint.reference_rotation = random.vector();
  }
}

Welded welded_in_a_vacuum(Random& random, int bodies) {
  Welded welded;
  welded.tree = random_tree(random, bodies);
  welded.tree.density = 0.0;
  for (std::size_t i = 0; i < welded.tree.bodies.size(); ++i) {
    // inertia of some cloud of points: its principal moments obey the triangle rule
    const Matrix3d spread = random.positive_definite();
    welded.tree.bodies[i] =
        brick(welded.tree.bodies[i].name, random.uniform(0.5, 2.0), spread.trace() * Matrix3d::Identity() - spread);
  }
  fix_joints(random, welded.tree);
  const model::System system(welded.tree);
  const mechanics::Rotations R = fixed_rotations(system);
  const auto centres = system.mass_centres(R, Vector3d::Zero());
  double mass = 0.0;
  for (int i = 0; i < bodies; ++i) {
    mass += system.body(i).mass;
    welded.centre += system.body(i).mass * centres[at(i)];
  }
  welded.centre /= mass;
  Matrix3d J = Matrix3d::Zero();
  for (int i = 0; i < bodies; ++i) {
    const Matrix3d c = lie::hat(centres[at(i)] - welded.centre);
    J += R[at(i)] * system.body(i).body_inertia * R[at(i)].transpose() - system.body(i).mass * c * c;
  }
  welded.body.bodies = {brick("all", mass, 0.5 * (J + J.transpose()))};
  return welded;
}

// Both in one motion: the tree's rotation and position are the root's, so the one body's are seen from there.
struct Pair {
  model::System tree, body;
  Vector3d centre;
  State tree_start, body_start;

  Pair(const Welded& welded, Random& random) : tree(welded.tree), body(welded.body), centre(welded.centre) {
    const Matrix3d R = random.rotation();
    const Vector3d x = random.vector(), Omega = random.vector(), rate = random.vector();
    VectorXd velocity(6), shifted(6);
    velocity << Omega, rate;
    shifted << Omega, rate + R * Omega.cross(centre);
    mechanics::Rotations rotations = fixed_rotations(tree);
    for (Matrix3d& rotation : rotations) rotation = R * rotation;
    tree_start = integrator::state_of_velocity(tree, rotations, x, velocity);
    body_start = integrator::state_of_velocity(body, {R}, x + R * centre, shifted);
  }

  double distance_at_end(Scheme scheme, double h, int steps) const {
    const State a = marched(tree, scheme, h, steps, tree_start);
    const State b = marched(body, scheme, h, steps, body_start);
    EXPECT_GT((a.rotation[0] - tree_start.rotation[0]).norm(), 0.1) << "nothing moved";
    return std::max((a.rotation[0] - b.rotation[0]).norm(), (a.position + a.rotation[0] * centre - b.position).norm());
  }
};

TEST_P(StepLaw, a_chain_with_fixed_joints_moves_as_one_body_in_a_vacuum) {
  Random random(81);
  for (int bodies : {2, 3, 6}) {
    const Pair pair(welded_in_a_vacuum(random, bodies), random);
    EXPECT_LE(pair.distance_at_end(GetParam(), 1e-2, 200), tolerance(1e-11)) << bodies << " bodies";
  }
}

// In a fluid mass depends on direction: the discrete laws of many bodies and of one differ, at the scheme's order. The one
// body is described about the root's mass centre, so it has a coupling matrix.
Welded welded_in_a_fluid(Random& random, int bodies) {
  Welded welded;
  welded.tree = random_tree(random, bodies);
  fix_joints(random, welded.tree);
  const model::System system(welded.tree);
  const mechanics::Rotations R = fixed_rotations(system);
  const auto centres = system.mass_centres(R, Vector3d::Zero());
  Matrix3d M = Matrix3d::Zero(), C = M, J = M;
  for (int i = 0; i < bodies; ++i) {
    const Matrix3d c = lie::hat(centres[at(i)]);
    const Matrix3d M_i = R[at(i)] * system.body(i).mass_matrix * R[at(i)].transpose();
    M += M_i;
    C -= M_i * c;
    J += R[at(i)] * system.body(i).inertia_matrix * R[at(i)].transpose() - c * M_i * c;
  }
  welded.body = welded.tree;
  welded.body.joints.clear();
  welded.body.bodies.resize(1);
  welded.body.bodies[0].mass_matrix = 0.5 * (M + M.transpose());
  welded.body.bodies[0].inertia_matrix = 0.5 * (J + J.transpose());
  welded.body.bodies[0].coupling_matrix = C;
  return welded;
}

TEST_P(StepLaw, a_chain_with_fixed_joints_in_a_fluid_comes_to_move_as_one_body_at_the_schemes_order) {
  Random random(82);
  for (int bodies : {2, 4}) {
    const Pair pair(welded_in_a_fluid(random, bodies), random);
    const int steps = GetParam() == Scheme::order6 ? 10 : 80;  // before round-off
    const double coarse = pair.distance_at_end(GetParam(), 1.0 / steps, steps);
    const double fine = pair.distance_at_end(GetParam(), 0.5 / steps, 2 * steps);
    EXPECT_NEAR(std::log2(coarse / fine), order(GetParam()), tolerance(GetParam() == Scheme::order6 ? 0.3 : 0.1))
        << bodies << " bodies, " << coarse << ", " << fine;
  }
}

TEST_P(StepLaw, joints_stay_joints_for_2000_stages) { expect_joints_stay(GetParam(), 2'000); }

// Axes that are orthogonal at zero angle stay so at every angle, so a universal joint never gets there by itself.
TEST_P(StepLaw, a_universal_joint_whose_axes_have_been_made_to_meet_ends_with_a_status) {
  Random random(92);
  model::SwimmerDescription swimmer = random_tree(random, 2);
  swimmer.joints[0].kind = model::JointKind::universal;
  swimmer.joints[0].axes = {Vector3d::UnitX(), Vector3d::UnitY()};
  Moving pair = moving(random, swimmer);
  const Moments none(1, Vector3d::Zero());
  State state = pair.start;
  const Matrix3d y_to_x = lie::exp(Vector3d(0.0, 0.0, -0.5 * M_PI));
  state.rotation[1] = state.rotation[0] * y_to_x;
  const State before = state;
  integrator::March march(pair.system, GetParam());
  const integrator::StageControl control = [&](int) -> const Moments& { return none; };
  EXPECT_FALSE(march.advance(1e-3, control, state).converged);
  EXPECT_TRUE(same(before, state));
  EXPECT_FALSE(integrator::velocity_of_state(pair.system, state).allFinite());
  state = pair.start;
  EXPECT_TRUE(march.advance(1e-3, control, state).converged);
}

INSTANTIATE_TEST_SUITE_P(Schemes, StepLaw, ::testing::ValuesIn(all_schemes), named_by_value);
INSTANTIATE_TEST_SUITE_P(SymmetricSchemes, RootLaw,
                         ::testing::Values(Scheme::trapezoid, Scheme::midpoint, Scheme::order4, Scheme::order6),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
