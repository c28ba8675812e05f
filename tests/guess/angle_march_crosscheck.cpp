// Marches along joint angles, against marches under moments and against the continuous equations.
#include "guess/angle_march.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/simulate.hpp"
#include "mechanics/connection.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using guess::JointAngles;
using maneuver::ControlPath;
using maneuver::Problem;
using maneuver::Scheme;
using maneuver::Solution;
using model::System;

// All kinds of joints, springs and dampers in some, each moved about all its axes.
model::SwimmerDescription moved_swimmer(Random& random, int bodies) {
  model::SwimmerDescription swimmer = random_swimmer(random, bodies);
  for (model::JointDescription& joint : swimmer.joints) joint.actuated = true;
  return swimmer;
}

Problem problem_of(const model::SwimmerDescription& swimmer, Scheme scheme, int steps) {
  Problem problem;
  problem.swimmer = swimmer;
  problem.scheme = scheme;
  problem.steps = steps;
  problem.duration.value = 0.6;
  problem.start.rotation.assign(swimmer.bodies.size(), Vector3d::Zero());
  problem.start.angular_velocity.assign(swimmer.bodies.size(), Vector3d::Zero());
  return problem;
}

// Afloat somewhere, turned somehow, and tumbling if asked for.
void begin_anywhere(Random& random, bool tumbling, Problem& problem) {
  const System system(problem.swimmer);
  const mechanics::Rotations R = random_rotations(random, system);
  for (std::size_t i = 0; i < R.size(); ++i) problem.start.rotation[i] = lie::log(R[i]);
  problem.start.position = random.vector();
  if (!tumbling) return;
  const integrator::State state =
      integrator::state_of_velocity(system, R, problem.start.position,
                                    VectorXd::NullaryExpr(system.velocity_count(), [&] { return random.normal(); }));
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  problem.start.angular_velocity = mechanics::angular_velocities(system, R, velocity);
  problem.start.linear_velocity = velocity.tail<3>();
}

JointAngles through(const std::vector<double>& time, const std::vector<maneuver::Vectors>& angle) {
  const auto joints = static_cast<Eigen::Index>(angle.front().size());
  MatrixXd values(3 * joints, static_cast<Eigen::Index>(time.size()));
  for (std::size_t k = 0; k < time.size(); ++k)
    for (Eigen::Index j = 0; j < joints; ++j)
      values.col(static_cast<Eigen::Index>(k)).segment<3>(3 * j) = angle[k][static_cast<std::size_t>(j)];
  const ControlPath path(maneuver::Interpolation::not_a_knot_cubic,
                         Eigen::Map<const VectorXd>(time.data(), static_cast<Eigen::Index>(time.size())), values);
  const auto by_joint = [joints](const VectorXd& all) {
    maneuver::Vectors each;
    for (Eigen::Index j = 0; j < joints; ++j) each.emplace_back(all.segment<3>(3 * j));
    return each;
  };
  return {[path, by_joint](double t) { return by_joint(path.value(t)); },
          [path, by_joint](double t) { return by_joint(path.slope(t)); }};
}

// Angles that swing about some shape, about each of the joints' axes.
JointAngles swinging(Random& random, const System& system) {
  maneuver::Vectors mean, swing, phase;
  for (const model::Joint& joint : system.joints()) {
    mean.push_back(random.vector(0.3));
    swing.push_back(random.vector(0.3));
    phase.push_back(random.vector());
    for (int c = system.body(joint.child).freedoms; c < 3; ++c) mean.back()[c] = swing.back()[c] = 0.0;
  }
  constexpr double rate = 4.0;  // rad/s
  const auto each = [mean, swing, phase](auto of) {
    maneuver::Vectors all = mean;
    for (std::size_t j = 0; j < mean.size(); ++j)
      for (int c = 0; c < 3; ++c) all[j][c] = of(mean[j][c], swing[j][c], phase[j][c]);
    return all;
  };
  return {
      [each](double t) { return each([t](double m, double a, double p) { return m + a * std::sin(rate * t + p); }); },
      [each](double t) { return each([t](double, double a, double p) { return rate * a * std::cos(rate * t + p); }); }};
}

maneuver::ControlFunction swinging_moments(Random& random, const System& system) {
  const mechanics::Moments once = random_moments(random, system, 1.0), twice = random_moments(random, system, 1.0);
  return [once, twice](double t) {
    mechanics::Moments u = once;
    for (std::size_t j = 0; j < u.size(); ++j) u[j] = std::cos(5.0 * t) * once[j] + std::sin(7.0 * t) * twice[j];
    return u;
  };
}

double off(const Solution& a, std::size_t k, const Solution& b, std::size_t m) {
  double largest = (a.position[k] - b.position[m]).norm();
  for (std::size_t i = 0; i < a.rotation[k].size(); ++i)
    largest = std::max(largest, (a.rotation[k][i] - b.rotation[m][i]).norm());
  return largest;
}

double largest_difference(const Solution& a, const Solution& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.time.size(); ++k) largest = std::max(largest, off(a, k, b, k));
  return largest;
}

struct MarchCase {
  Scheme scheme;
  bool tumbling;
};

class AngleMarch : public testing::TestWithParam<MarchCase> {
 protected:
  Problem random_problem(unsigned seed, int bodies, int steps) {
    Random random(seed);
    Problem problem = problem_of(moved_swimmer(random, bodies), GetParam().scheme, steps);
    begin_anywhere(random, GetParam().tumbling, problem);
    return problem;
  }
};

TEST_P(AngleMarch, along_the_angles_of_a_march_under_moments_is_that_march) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Problem problem = random_problem(seed, 2 + static_cast<int>(seed % 4), 60);
    const System system(problem.swimmer);
    Random random(70 + seed);
    const maneuver::ControlFunction moments = swinging_moments(random, system);
    const Solution marched = maneuver::simulate(system, problem, moments, maneuver::SimulateOptions{});
    ASSERT_EQ(marched.status, maneuver::Status::simulated);
    const Solution along = guess::march_along(system, problem, through(marched.time, marched.joint_angle));
    ASSERT_EQ(along.status, maneuver::Status::simulated) << along.message;
    EXPECT_LE(largest_difference(along, marched), tolerance(1e-10)) << seed;
    for (std::size_t k = 1; k + 1 < along.time.size(); ++k)
      for (std::size_t j = 0; j < along.control[k].size(); ++j)
        EXPECT_LE((along.control[k][j] - marched.control[k][j]).norm(), tolerance(1e-7)) << seed << " at " << k;
  }
}

// How joint angles change at the start, as JointAngles have it.
maneuver::Vectors first_rates(const System& system, const maneuver::Start& start, const maneuver::Vectors& turn) {
  const integrator::State state = maneuver::start_state(system, start);
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const maneuver::Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
  maneuver::Vectors rates(turn.size(), Vector3d::Zero());
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const model::Body& child = system.body(joint.child);
    if (!joint.free()) {
      rates[model::at(j)].head(child.freedoms) = velocity.segment(child.velocity_offset, child.freedoms);
      continue;
    }
    const Matrix3d Q = mechanics::child_to_parent(state.rotation, joint);
    const Vector3d against = Q * angular[model::at(joint.child)] - angular[model::at(joint.parent)];
    const Matrix3d by_turn = lie::exp(turn[model::at(j)]) * lie::exp_tangent(turn[model::at(j)]);
    rates[model::at(j)] = by_turn.inverse() * against;
  }
  return rates;
}

// Joints that nothing drives go as they go under the moments: nothing need be known of them but how they begin.
TEST_P(AngleMarch, of_some_joints_lets_the_passive_ones_move_as_they_do) {
  int moved = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Problem problem = random_problem(seed, 3 + static_cast<int>(seed % 3), 60);
    const std::size_t joints = problem.swimmer.joints.size(), first = seed % joints, second = (seed + 1) % joints;
    problem.swimmer.joints[first].actuated = false;
    if (joints > 3) problem.swimmer.joints[second].actuated = false;
    const System system(problem.swimmer);
    Random random(170 + seed);
    const maneuver::ControlFunction moments = swinging_moments(random, system);
    const Solution marched = maneuver::simulate(system, problem, moments, maneuver::SimulateOptions{});
    ASSERT_EQ(marched.status, maneuver::Status::simulated);
    std::vector<maneuver::Vectors> angles = marched.joint_angle;
    JointAngles known;
    std::vector<bool> passive(joints, false);
    for (std::size_t j = 0; j < joints; ++j) {
      passive[j] =
          !problem.swimmer.joints[j].actuated && system.body(system.joint(static_cast<int>(j)).child).freedoms > 0;
      if (!passive[j]) continue;
      moved += (angles.back()[j] - angles.front()[j]).norm() > 1e-3 ? 1 : 0;
      for (maneuver::Vectors& node : angles) node[j].setZero();
    }
    known = through(marched.time, angles);
    known.passive = passive;
    // a cubic through the angles knows their first rates less well than the start does
    known.rate = [later = known.rate, first = first_rates(system, problem.start, marched.joint_angle.front())](
                     double t) { return t == 0.0 ? first : later(t); };
    const Solution along = guess::march_along(system, problem, known);
    ASSERT_EQ(along.status, maneuver::Status::simulated) << along.message;
    EXPECT_LE(largest_difference(along, marched), tolerance(1e-9)) << seed;
    for (std::size_t k = 1; k + 1 < along.time.size(); ++k)
      for (std::size_t j = 0; j < joints; ++j)
        EXPECT_LE((along.control[k][j] - marched.control[k][j]).norm(), tolerance(1e-6)) << seed << " at " << k;
    const double momentum = (along.linear_momentum.total.back() - along.linear_momentum.total.front()).norm();
    EXPECT_LE(momentum, tolerance(1e-11) * (1.0 + along.linear_momentum.total.front().norm()));
  }
  EXPECT_GE(moved, 6);
}

TEST_P(AngleMarch, finds_the_moments_that_march_so) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Problem problem = random_problem(seed, 2 + static_cast<int>(seed % 4), 50);
    const System system(problem.swimmer);
    Random random(80 + seed);
    const JointAngles angles = swinging(random, system);
    const Solution along = guess::march_along(system, problem, angles);
    ASSERT_EQ(along.status, maneuver::Status::simulated) << along.message;
    problem.start = guess::start_along(system, problem, angles);
    std::vector<mechanics::Moments> found;
    for (std::size_t k = 0; k < along.time.size(); ++k)
      found.push_back(mechanics::moments_of_applied(system, along.rotation[k], along.control[k]));
    const double h = problem.time_step();
    const auto moments = [&](double t) { return found[static_cast<std::size_t>(std::lround(t / h))]; };
    const Solution marched = maneuver::simulate(system, problem, moments, maneuver::SimulateOptions{});
    ASSERT_EQ(marched.status, maneuver::Status::simulated) << marched.message;
    EXPECT_LE(largest_difference(along, marched), tolerance(1e-9)) << seed;
  }
}

// Joints that jump from node to node as impulses make them: no step resembles the last one.
JointAngles jumping(Random& random, const System& system, const Problem& problem) {
  std::vector<maneuver::Vectors> table;
  for (int k = 0; k <= problem.steps; ++k) {
    table.emplace_back();
    for (const model::Joint& joint : system.joints()) {
      table.back().push_back(random.vector(0.5));
      for (int c = system.body(joint.child).freedoms; c < 3; ++c) table.back().back()[c] = 0.0;
    }
  }
  const double h = problem.time_step();
  return {[table, h](double t) { return table[static_cast<std::size_t>(std::lround(t / h))]; },
          [&system](double) { return maneuver::Vectors(model::at(system.joint_count()), Vector3d::Zero()); }};
}

TEST_P(AngleMarch, is_marched_again_by_its_moments_where_steps_may_begin_at_its_own) {
  int lost = 0;  // without it
  for (unsigned seed = 1; seed <= 12; ++seed) {
    Problem problem = random_problem(seed, 2 + static_cast<int>(seed % 4), 12);
    const System system(problem.swimmer);
    Random random(90 + seed);
    const JointAngles angles = jumping(random, system, problem);
    const Solution along = guess::march_along(system, problem, angles);
    if (along.status != maneuver::Status::simulated) continue;
    problem.start = guess::start_along(system, problem, angles);
    std::vector<mechanics::Moments> found;
    for (std::size_t k = 0; k < along.time.size(); ++k)
      found.push_back(mechanics::moments_of_applied(system, along.rotation[k], along.control[k]));
    const double h = problem.time_step();
    const auto moments = [&](double t) { return found[static_cast<std::size_t>(std::lround(t / h))]; };
    maneuver::SimulateOptions options;
    const auto off_by = [&](const Solution& marched) {
      return marched.status == maneuver::Status::simulated ? largest_difference(along, marched) : 1.0;
    };
    constexpr double same = 1e-9;
    lost += off_by(maneuver::simulate(system, problem, moments, options)) > same ? 1 : 0;
    maneuver::NodePath motion;
    motion.rotation = along.rotation;
    motion.position = along.position;
    options.motion = &motion;
    EXPECT_LE(off_by(maneuver::simulate(system, problem, moments, options)), same) << seed;
    // the motion may lie and be headed otherwise
    const Matrix3d heading = lie::exp(random.vector());
    for (mechanics::Rotations& R : motion.rotation)
      for (Matrix3d& body : R) body = (heading * body).eval();
    for (Vector3d& x : motion.position) x = heading * x + Vector3d(1, 2, 3);
    EXPECT_LE(off_by(maneuver::simulate(system, problem, moments, options)), same) << seed;
  }
  EXPECT_GE(lost, 2) << "the moments ask for no more than any march finds";
}

TEST_P(AngleMarch, keeps_to_its_angles_and_to_total_momentum) {
  const Problem problem = random_problem(5, 5, 40);
  const System system(problem.swimmer);
  Random random(9);
  const JointAngles angles = swinging(random, system);
  const Solution along = guess::march_along(system, problem, angles);
  ASSERT_EQ(along.status, maneuver::Status::simulated) << along.message;
  const integrator::State begin = maneuver::start_state(system, problem.start);
  const mechanics::SpatialMomentum total =
      mechanics::spatial_momentum(system, begin.rotation, begin.position, begin.momentum);
  const double scale = 1.0 + total.linear.norm() + total.angular.norm();
  for (std::size_t k = 0; k < along.time.size(); ++k) {
    EXPECT_LE((along.linear_momentum.total[k] - total.linear).norm(), tolerance(1e-11) * scale);
    EXPECT_LE((along.angular_momentum.total[k] - total.angular).norm(), tolerance(1e-11) * scale);
    const maneuver::Vectors asked = angles.turn(along.time[k]);
    for (std::size_t j = 0; j < asked.size(); ++j) EXPECT_LE((along.joint_angle[k][j] - asked[j]).norm(), 1e-12);
  }
  EXPECT_LE((along.rotation[0][0] - lie::exp(problem.start.rotation[0])).norm(), 1e-14);
}

INSTANTIATE_TEST_SUITE_P(Schemes, AngleMarch,
                         testing::Values(MarchCase{Scheme::trapezoid, false}, MarchCase{Scheme::trapezoid, true},
                                         MarchCase{Scheme::midpoint, false}, MarchCase{Scheme::midpoint, true},
                                         MarchCase{Scheme::paper, true}),
                         [](const auto& the) {
                           const char* scheme = the.param.scheme == Scheme::paper      ? "paper"
                                                : the.param.scheme == Scheme::midpoint ? "midpoint"
                                                                                       : "trapezoid";
                           return std::string(scheme) + (the.param.tumbling ? "_tumbling" : "_from_rest");
                         });

// The root's motion by ẋ = connection · rates, fourth-order Runge–Kutta in fine steps.
integrator::State followed_by_connection(const System& system, const Problem& problem, const JointAngles& angles,
                                         int steps) {
  const integrator::State begin = maneuver::start_state(system, problem.start);
  const mechanics::SpatialMomentum total =
      mechanics::spatial_momentum(system, begin.rotation, begin.position, begin.momentum);
  const auto placed = [&](double t, const Matrix3d& root) {
    const maneuver::Vectors turn = angles.turn(t);
    mechanics::Rotations R(static_cast<std::size_t>(system.body_count()), root);
    for (int i : system.root_to_leaves()) {
      const model::Body& body = system.body(i);
      if (body.parent >= 0)
        R[model::at(i)] = R[model::at(body.parent)] *
                          mechanics::rotation_at_turn(system.joint(body.joint), turn[model::at(body.joint)]);
    }
    return R;
  };
  struct Rate {
    Vector3d turn, shift;
  };
  const auto rate = [&](double t, const Matrix3d& root, const Vector3d& x) {
    maneuver::Vectors rates = angles.rate(t);
    const maneuver::Vectors turn = angles.turn(t);
    for (int j = 0; j < system.joint_count(); ++j)
      if (system.joint(j).free()) {
        const std::size_t n = model::at(j);
        // by differences of rotations: no formula of the march
        const double e = 1e-6;
        const Matrix3d by = (lie::exp(turn[n] + e * rates[n]) - lie::exp(turn[n] - e * rates[n])) / (2.0 * e);
        rates[n] = lie::vee(by * lie::exp(turn[n]).transpose());
      }
    const mechanics::Rotations R = placed(t, root);
    const VectorXd velocity = mechanics::velocity_of_rates(system, R, x, rates, total);
    return Rate{mechanics::angular_velocities(system, R, velocity)[0], velocity.tail<3>()};
  };
  Matrix3d root = begin.rotation[0];
  Vector3d x = begin.position;
  const double h = problem.duration.value / steps;
  for (int k = 0; k < steps; ++k) {
    const double t = k * h;
    const Rate a = rate(t, root, x);
    const Rate b = rate(t + 0.5 * h, root * lie::exp(0.5 * h * a.turn), x + 0.5 * h * a.shift);
    const Rate c = rate(t + 0.5 * h, root * lie::exp(0.5 * h * b.turn), x + 0.5 * h * b.shift);
    const Rate d = rate(t + h, root * lie::exp(h * c.turn), x + h * c.shift);
    const Vector3d turn = (a.turn + 2.0 * b.turn + 2.0 * c.turn + d.turn) / 6.0;
    root = root * lie::exp(h * turn);
    x += h * (a.shift + 2.0 * b.shift + 2.0 * c.shift + d.shift) / 6.0;
  }
  return {placed(problem.duration.value, root), x, VectorXd()};
}

TEST(AngleMarchInTime, approaches_the_continuous_motion_at_the_schemes_order) {
  for (const auto& [scheme, order] : {std::pair(Scheme::trapezoid, 2.0), std::pair(Scheme::midpoint, 2.0)}) {
    Random random(31);
    Problem problem = problem_of(moved_swimmer(random, 4), scheme, 0);
    begin_anywhere(random, true, problem);
    const System system(problem.swimmer);
    const JointAngles angles = swinging(random, system);
    const integrator::State exact = followed_by_connection(system, problem, angles, 20000);
    std::vector<double> error;
    for (int steps : {40, 80, 160}) {
      problem.steps = steps;
      const Solution along = guess::march_along(system, problem, angles);
      ASSERT_EQ(along.status, maneuver::Status::simulated) << along.message;
      double largest = (along.position.back() - exact.position).norm();
      for (std::size_t i = 0; i < exact.rotation.size(); ++i)
        largest = std::max(largest, (along.rotation.back()[i] - exact.rotation[i]).norm());
      error.push_back(largest);
    }
    for (std::size_t n = 0; n + 1 < error.size(); ++n)
      EXPECT_NEAR(std::log2(error[n] / error[n + 1]), order, 0.2) << error[n] << " " << error[n + 1];
  }
}

// Joints may be driven about some axes alone, where the angles take no moments about others.
TEST(AngleMarchRefusals, name_joints_that_nothing_moves_as_the_angles_do) {
  Random random(2);
  model::SwimmerDescription chain = paper_chain();
  chain.joints[1].control_axes = {Vector3d::UnitX(), Vector3d::UnitZ()};
  const System partly(chain);
  const Problem problem = problem_of(chain, Scheme::trapezoid, 100);
  const Solution stopped = guess::march_along(partly, problem, swinging(random, partly));
  EXPECT_EQ(stopped.status, maneuver::Status::stalled);
  EXPECT_NE(stopped.message.find("N m of joint back at t ="), std::string::npos) << stopped.message;
  EXPECT_NE(stopped.message.find("about an axis that nothing drives (control_axes)"), std::string::npos);
  const JointAngles planar{
      [](double t) {
        return maneuver::Vectors{Vector3d(0, 0, std::sin(4.0 * t)), Vector3d(0, 0, std::cos(5.0 * t))};
      },
      [](double t) {
        return maneuver::Vectors{Vector3d(0, 0, 4.0 * std::cos(4.0 * t)), Vector3d(0, 0, -5.0 * std::sin(5.0 * t))};
      }};
  const Solution along = guess::march_along(partly, problem, planar);
  EXPECT_EQ(along.status, maneuver::Status::simulated) << along.message;
  const System whole(paper_chain());
  const Solution same = guess::march_along(whole, problem_of(paper_chain(), Scheme::trapezoid, 100), planar);
  EXPECT_LE(largest_difference(along, same), 1e-12);
  for (std::size_t k = 0; k < along.time.size(); ++k)
    for (std::size_t j = 0; j < 2; ++j)
      EXPECT_LE((along.control[k][j] - same.control[k][j]).norm(), 1e-9 * (1.0 + same.control[k][j].norm()));
  chain.joints[1].control_axes.reset();
  chain.joints[1].actuated = false;
  const Solution passive = guess::march_along(System(chain), problem_of(chain, Scheme::trapezoid, 100), planar);
  EXPECT_NE(passive.message.find("that nothing drives (actuated = false)"), std::string::npos) << passive.message;
}

TEST(AngleMarchRefusals, tell_where_a_body_turns_too_far_in_a_step) {
  const System system(paper_chain());
  Problem problem = problem_of(paper_chain(), Scheme::trapezoid, 10);
  const JointAngles spin{[](double t) {
                           return maneuver::Vectors{Vector3d(0, 0, 60.0 * t * t), Vector3d::Zero()};
                         },
                         [](double t) {
                           return maneuver::Vectors{Vector3d(0, 0, 120.0 * t), Vector3d::Zero()};
                         }};
  const Solution stopped = guess::march_along(system, problem, spin);
  EXPECT_EQ(stopped.status, maneuver::Status::stalled);
  EXPECT_NE(stopped.message.find("more than a quarter turn; try more steps"), std::string::npos) << stopped.message;
  EXPECT_GT(stopped.time.size(), 2U);
  EXPECT_LT(stopped.time.size(), 11U);
  problem.steps = 1000;
  EXPECT_EQ(guess::march_along(system, problem, spin).status, maneuver::Status::simulated);
  int asked = 0;
  EXPECT_EQ(guess::march_along(system, problem, spin, [&] { return asked++ > 4; }).time.size(), 6U);
  EXPECT_EQ(guess::march_along(system, problem, spin, [] { return true; }).time.size(), 1U);
}

}  // namespace
}  // namespace lamprey::tests
