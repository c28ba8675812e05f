#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"
#include "integrator/step_derivatives.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using integrator::State;
using integrator::StateLayout;
using integrator::StepTangent;
using mechanics::DiscreteLagrangian;
using mechanics::Moments;
using model::at;

constexpr DiscreteLagrangian lagrangians[] = {DiscreteLagrangian::paper, DiscreteLagrangian::trapezoid,
                                              DiscreteLagrangian::midpoint};
constexpr double time_step = 0.02;

VectorXd random_vector(Random& random, int size) {
  VectorXd v(size);
  for (double& entry : v) entry = random.normal();
  return v;
}

State random_state(Random& random, const model::System& system) {
  const mechanics::Rotations rotation = random_rotations(random, system);
  const VectorXd velocity = random_vector(random, system.velocity_count());
  return integrator::state_of_velocity(system, rotation, random.vector(), velocity);
}

State moved(const model::System& system, const State& state, const VectorXd& y) {
  const int half = system.velocity_count();
  mechanics::Freedoms turn(state.rotation.size());
  mechanics::unpack(system, y.head(half), turn);
  State result = state;
  result.rotation = turned(system, state.rotation, turn);
  result.position += y.segment<3>(half - 3);
  result.momentum += y.tail(half);
  return result;
}

VectorXd difference(const model::System& system, const State& from, const State& to) {
  VectorXd turn;
  mechanics::pack(system, turns_between(system, from.rotation, to.rotation), to.position - from.position, turn);
  VectorXd y(2 * turn.size());
  y << turn, to.momentum - from.momentum;
  return y;
}

Moments moved(const model::System& system, const Moments& u, const VectorXd& y) {
  Moments result = u;
  int column = 0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const int columns = static_cast<int>(system.joint(j).actuation.cols());
    result[at(j)] += system.joint(j).actuation * y.segment(column, columns);
    column += columns;
  }
  return result;
}

// One step from a random state, its tangent, and the marched next state.
struct Step {
  Step(Random& random, const model::System& system_, DiscreteLagrangian lagrangian_, bool free = false)
      : system(system_), lagrangian(lagrangian_), start(random_state(random, system)), tangent(system) {
    u = random_moments(random, system, 5.0);
    u_next = random_moments(random, system, 5.0);
    if (free) u = u_next = Moments(u.size(), Vector3d::Zero());
    integrator::StepWorkspace march(system);
    end = start;
    EXPECT_TRUE(integrator::advance(system, lagrangian, time_step, u, u_next, end, march).converged);
    integrator::TangentWorkspace work(system);
    integrator::linearize_step(system, lagrangian, time_step, march.interval, u, u_next, work, tangent);
  }
  State marched(const State& from, const Moments& first, const Moments& second) const {
    State state = from;
    integrator::StepWorkspace march(system);
    EXPECT_TRUE(integrator::advance(system, lagrangian, time_step, first, second, state, march).converged);
    return state;
  }
  const model::System& system;
  DiscreteLagrangian lagrangian;
  State start, end;
  Moments u, u_next;
  StepTangent tangent;
};

// The canonical form in body-side coordinates: η1·δμ2 − δμ1·η2 + μ·(η1 × η2), and the same without the last for x.
MatrixXd symplectic_form(const model::System& system, const State& state) {
  const int half = system.velocity_count();
  MatrixXd form = MatrixXd::Zero(2 * half, 2 * half);
  form.topRightCorner(half, half).setIdentity();
  form.bottomLeftCorner(half, half) = -MatrixXd::Identity(half, half);
  for (int i = 0; i < system.body_count(); ++i) {
    const int place = system.body(i).velocity_offset;
    if (system.body(i).freedoms == 3) form.block<3, 3>(place, place) = -lie::hat(state.momentum.segment<3>(place));
  }
  return form;
}

// Trees of ball joints, and with every kind of joint, springs, dampers and coupled inertia.
struct Kind {
  int bodies;
  bool any_joint;
};

std::ostream& operator<<(std::ostream& out, Kind kind) {
  return out << kind.bodies << (kind.any_joint ? " bodies, any joints" : " bodies, ball joints");
}

model::SwimmerDescription drawn(Random& random, Kind kind) {
  return kind.any_joint ? random_swimmer(random, kind.bodies) : random_tree(random, kind.bodies);
}

class StepTangentOfTree : public ::testing::TestWithParam<Kind> {};

TEST_P(StepTangentOfTree, matches_central_differences_of_the_march_at_second_order) {
  Random random(30 + static_cast<unsigned>(GetParam().bodies));
  const model::System system(drawn(random, GetParam()));
  for (auto lagrangian : lagrangians) {
    const Step step(random, system, lagrangian);
    const VectorXd y = random_vector(random, StateLayout{system}.size());
    expect_second_order_differences(
        [&](double t) {
          return difference(system, step.end, step.marched(moved(system, step.start, t * y), step.u, step.u_next));
        },
        step.tangent.A * y);
    if (system.control_count() == 0) continue;
    const VectorXd v = random_vector(random, system.control_count());
    expect_second_order_differences(
        [&](double t) {
          return difference(system, step.end,
                            step.marched(step.start, moved(system, step.u, 100.0 * t * v), step.u_next));
        },
        100.0 * step.tangent.B * v, 1e-9, 0.05);
    const double t = 1.0;  // u_{k+1} enters the next momentum linearly: no truncation, any step will do
    const VectorXd by_next =
        difference(system, step.end, step.marched(step.start, step.u, moved(system, step.u_next, t * v)));
    const VectorXd expected = step.tangent.B_next * v;
    ASSERT_GT(expected.lpNorm<Eigen::Infinity>(), 0.0);
    EXPECT_LE((by_next - expected).lpNorm<Eigen::Infinity>(), tolerance(1e-11) * expected.lpNorm<Eigen::Infinity>());
  }
}

TEST_P(StepTangentOfTree, is_the_same_inverted_whole_and_through_the_tree) {
  Random random(70 + static_cast<unsigned>(GetParam().bodies));
  const model::System system(drawn(random, GetParam()));
  for (auto lagrangian : lagrangians) {
    const State start = random_state(random, system);
    const Moments u = random_moments(random, system, 5.0);
    integrator::StepWorkspace march(system);
    State end = start;
    ASSERT_TRUE(integrator::advance(system, lagrangian, time_step, u, u, end, march).converged);
    integrator::TangentWorkspace work(system);
    StepTangent whole(system), through(system);
    work.dense = true;
    integrator::linearize_step(system, lagrangian, time_step, march.interval, u, u, work, whole);
    work.dense = false;
    integrator::linearize_step(system, lagrangian, time_step, march.interval, u, u, work, through);
    EXPECT_LE((whole.A - through.A).norm(), tolerance(1e-12) * through.A.norm());
    EXPECT_LE((whole.B - through.B).norm(), tolerance(1e-12) * (1.0 + through.B.norm()));
  }
}

// What is not finite goes with the next step that can be linearised.
TEST_P(StepTangentOfTree, is_not_a_number_where_the_step_is_none_and_right_again_after_it) {
  Random random(90 + static_cast<unsigned>(GetParam().bodies));
  const model::System system(drawn(random, GetParam()));
  const Step step(random, system, lagrangians[1]);
  State end = step.start;
  integrator::StepWorkspace march(system);
  ASSERT_TRUE(integrator::advance(system, lagrangians[1], time_step, step.u, step.u_next, end, march).converged);
  mechanics::Interval none = march.interval;
  for (Eigen::Matrix3d& R : none.relative_rotation) R.setConstant(std::numeric_limits<double>::quiet_NaN());
  integrator::TangentWorkspace work(system);
  StepTangent tangent(system);
  for (const mechanics::Interval* interval : {&none, &march.interval}) {
    integrator::linearize_step(system, lagrangians[1], time_step, *interval, step.u, step.u_next, work, tangent);
    EXPECT_EQ(tangent.A.allFinite(), interval != &none);
    if (system.control_count() > 0) {
      EXPECT_EQ(tangent.B.allFinite() && tangent.B_next.allFinite(), interval != &none);
    }
  }
  EXPECT_EQ(tangent.A, step.tangent.A);
  EXPECT_EQ(tangent.B, step.tangent.B);
  EXPECT_EQ(tangent.B_next, step.tangent.B_next);
}

TEST_P(StepTangentOfTree, adjoint_and_tangent_give_one_dot_product) {
  Random random(40 + static_cast<unsigned>(GetParam().bodies));
  const model::System system(drawn(random, GetParam()));
  for (auto lagrangian : lagrangians) {
    const Step step(random, system, lagrangian);
    const int size = StateLayout{system}.size();
    const VectorXd y = random_vector(random, size);
    const VectorXd v = random_vector(random, system.control_count());
    const VectorXd v_next = random_vector(random, system.control_count());
    const MatrixXd row = random_vector(random, size).transpose();
    const VectorXd forward = step.tangent.A * y + step.tangent.B * v + step.tangent.B_next * v_next;
    const auto back = integrator::pull_back(step.tangent, row);
    const double ahead = row.row(0).dot(forward);
    const double behind =
        back.by_state.row(0).dot(y) + back.by_control.row(0).dot(v) + back.by_next_control.row(0).dot(v_next);
    EXPECT_NEAR(behind, ahead, tolerance(1e-12) * row.norm() * forward.norm());
  }
}

TEST_P(StepTangentOfTree, keeps_the_symplectic_form_in_free_motion) {
  Random random(50 + static_cast<unsigned>(GetParam().bodies));
  model::SwimmerDescription swimmer = drawn(random, GetParam());
  for (model::JointDescription& joint : swimmer.joints) joint.damping = 0.0;
  const model::System system(swimmer);
  for (auto lagrangian : lagrangians) {
    const Step step(random, system, lagrangian, true);
    const MatrixXd before = symplectic_form(system, step.start);
    const MatrixXd carried = step.tangent.A.transpose() * symplectic_form(system, step.end) * step.tangent.A;
    const double size = step.tangent.A.norm() * step.tangent.A.norm();
    EXPECT_LE((carried - before).lpNorm<Eigen::Infinity>(), tolerance(1e-10));
    // the form without its Lie–Poisson part is another one, and not kept: the check can tell
    MatrixXd canonical = before;
    canonical.topLeftCorner(before.rows() / 2, before.rows() / 2).setZero();
    EXPECT_GT((step.tangent.A.transpose() * canonical * step.tangent.A - canonical).lpNorm<Eigen::Infinity>(),
              1e-6 * size);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, StepTangentOfTree,
                         ::testing::Values(Kind{1, false}, Kind{2, false}, Kind{3, false}, Kind{5, false},
                                           Kind{2, true}, Kind{3, true}, Kind{5, true}, Kind{9, true}),
                         named_by_value);

// A march under random moments, kept for sweeps.
struct March {
  March(Random& random, const model::System& system_, int steps)
      : system(system_), start(random_state(random, system)) {
    for (int k = 0; k <= steps; ++k) control.push_back(random_moments(random, system, 5.0));
    end = run(control, &intervals);
  }
  State run(const std::vector<Moments>& moments, std::vector<mechanics::Interval>* kept = nullptr) const {
    State state = start;
    integrator::StepWorkspace work(system);
    for (std::size_t k = 0; k + 1 < moments.size(); ++k) {
      EXPECT_TRUE(
          advance(system, DiscreteLagrangian::trapezoid, time_step, moments[k], moments[k + 1], state, work).converged);
      if (kept) kept->push_back(work.interval);
    }
    return state;
  }
  const model::System& system;
  State start, end;
  std::vector<Moments> control;
  std::vector<mechanics::Interval> intervals;
};

TEST(GradientSweep, gradients_of_the_end_state_match_central_differences_at_second_order) {
  Random random(60);
  const model::System system(random_tree(random, 3));
  const int steps = 12;
  const March march(random, system, steps);
  const int size = StateLayout{system}.size();
  const auto swept = integrator::gradient_sweep(
      system, DiscreteLagrangian::trapezoid, time_step,
      [&](int k, mechanics::Interval& interval) { interval = march.intervals[at(k)]; }, march.control, {0, steps},
      MatrixXd::Identity(size, size));
  const MatrixXd& gradients = swept.by_control;
  const VectorXd v = random_vector(random, static_cast<int>(gradients.cols()));
  const auto along = [&](double t) {
    std::vector<Moments> control = march.control;
    for (int k = 0; k <= steps; ++k)
      control[at(k)] = moved(system, control[at(k)], t * v.segment(k * system.control_count(), system.control_count()));
    return difference(system, march.end, march.run(control));
  };
  expect_second_order_differences(along, gradients * v, 1e-9, 0.1);
}

}  // namespace
}  // namespace lamprey::tests
