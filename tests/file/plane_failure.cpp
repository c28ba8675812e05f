// Swimmers of ellipses keep to their plane; what leads out of it is refused where it stands.
#include <algorithm>
#include <functional>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "file/plane_checks.hpp"
#include "file/problem_file.hpp"
#include "file/refusals.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/equations_of_motion.hpp"
#include "model/input_error.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "task/tasks.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

maneuver::Problem ellipses() {
  return file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/ellipses.toml").problem;
}

std::string refusal(const std::function<void(maneuver::Problem&)>& change) {
  maneuver::Problem problem = ellipses();
  change(problem);
  try {
    file::require_plane(problem);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Plane, of_ellipses_holds_all_that_a_swimmer_is_asked) {
  EXPECT_EQ(refusal([](auto&) {}), "");
  expect_begins(refusal([](auto& p) { p.swimmer.bodies[1].ellipse = false; }),
                "body[1].semi_axes: found three numbers");
  expect_begins(refusal([](auto& p) { p.swimmer.bodies[1].ellipse = p.swimmer.bodies[2].ellipse = false; }),
                "body[0].semi_axes: found two numbers beside bodies of three");
  expect_begins(refusal([](auto& p) { p.swimmer.joints[0].kind = model::JointKind::universal; }),
                "joint[0].kind: found a universal joint; allowed: hinge or fixed");
  expect_begins(refusal([](auto& p) { p.swimmer.joints[1].axis = Vector3d(0.1, 0, 1); }),
                "joint[1].axis: found [0.1, 0, 1]; allowed: a turn about e₃");
  expect_begins(refusal([](auto& p) { p.swimmer.joints[1].child_offset[2] = 0.01; }),
                "joint[1].child_offset: found [0.12, 0, 0.01]; allowed: 0 along e₃");
  expect_begins(refusal([](auto& p) { p.swimmer.joints[0].reference_rotation[0] = 0.2; }),
                "joint[0].reference_rotation");
  expect_begins(refusal([](auto& p) { p.start.rotation[2] = Vector3d(0, 1, 0); }), "start.rotation.tail");
  expect_begins(refusal([](auto& p) { p.start.angular_velocity[0] = Vector3d(1, 0, 0); }),
                "start.angular_velocity.middle");
  expect_begins(refusal([](auto& p) { p.start.linear_velocity = Vector3d(1, 0, 1); }), "start.linear_velocity");
  expect_begins(refusal([](auto& p) { p.goal->move[2] = 0.5; }),
                "goal.move: found 0.5 along e₃; allowed: 0 or \"free\"");
  expect_begins(refusal([](auto& p) { p.goal->turn = Vector3d(0.5, 0, 0); }), "goal.turn");
  expect_begins(refusal([](auto& p) { p.goal->rotation["head"] = Vector3d(0.5, 0, 0); }), "goal.rotation.head");
  for (const auto& [row, column] : {std::pair(0, 2), std::pair(2, 1)})
    for (auto matrix : {&model::BodyDescription::mass_matrix, &model::BodyDescription::inertia_matrix,
                        &model::BodyDescription::body_inertia})
      EXPECT_NE(refusal([&](auto& p) {
                  p.swimmer.bodies[0].*matrix = Eigen::Matrix3d::Identity();
                  (*(p.swimmer.bodies[0].*matrix))(row, column) = 0.1;
                }).find("0 there, which would drive it out of its plane"),
                std::string::npos);
  const auto coupled = [&](int row, int column) {
    return refusal([&](auto& p) {
      p.swimmer.bodies[1].coupling_matrix = Eigen::Matrix3d::Zero();
      (*p.swimmer.bodies[1].coupling_matrix)(row, column) = 0.1;
    });
  };
  EXPECT_EQ(coupled(0, 2) + coupled(1, 2) + coupled(2, 0), "") << "in the plane, and out of it alone";
  for (const auto& [row, column] : {std::pair(0, 0), std::pair(1, 0), std::pair(2, 2)})
    expect_begins(coupled(row, column), "body[1].coupling_matrix: found 0.1 in row");
  expect_begins(refusal([](auto& p) {
                  p.waypoints.push_back({0.5, {0.1, 0.0, 0.2}, {}, {}});
                }),
                "waypoint[0].move: found 0.2");
  expect_begins(refusal([](auto& p) { p.waypoints.push_back({0.5, {}, Vector3d(1, 0, 0), {}}); }), "waypoint[0].turn");
  expect_begins(refusal([](auto& p) {
                  p.limits.spheres.push_back({Vector3d(0, 0, 0.105), 0.1});
                }),
                "limits.sphere[0].centre: found [0, 0, 0.105]; allowed: 0 along e₃");
  expect_begins(refusal([](auto& p) {
                  p.limits.half_spaces.push_back({Vector3d(0, -1, 0), Vector3d(0, 0.001, 1)});
                }),
                "limits.half_space[0].normal");
  expect_begins(refusal([](auto& p) { p.cost_weights.displacement = Vector3d(0, 0, 1); }), "cost.displacement");
  EXPECT_EQ(refusal([](auto& p) {
              for (auto& body : p.swimmer.bodies) body.ellipse = false;
              p.goal->turn = Vector3d(0.5, 0, 0);
            }),
            "")
      << "ellipsoids turn as they like";
}

// What of M and J lies out of the plane has no part in motions within it.
TEST(Plane, is_kept_in_stored_answers) {
  const file::ProblemFile asked = file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/ellipses.toml");
  task::MarchOptions options;
  options.steps = 4;
  const result::Results results = task::march_task(asked, options, "");
  const result::Results back = result::parse_solution(result::solution_text(results), "x");
  EXPECT_TRUE(back.problem.bodies[2].ellipse);
  EXPECT_TRUE(result::problem_of(back).swimmer.bodies[2].ellipse);
  EXPECT_EQ(result::solution_text(back), result::solution_text(results));
}

TEST(Plane, motions_do_not_feel_what_lies_out_of_it) {
  const maneuver::Problem problem = ellipses();
  const model::System system(problem.swimmer);
  model::SwimmerDescription other = problem.swimmer;
  for (std::size_t i = 0; i < other.bodies.size(); ++i) {
    const model::Body& body = system.bodies()[i];
    other.bodies[i].mass_matrix = body.mass_matrix;
    (*other.bodies[i].mass_matrix)(2, 2) *= 5.0;
    other.bodies[i].inertia_matrix = body.inertia_matrix;
    (*other.bodies[i].inertia_matrix)(0, 0) *= 3.0;
    (*other.bodies[i].inertia_matrix)(1, 1) *= 0.5;
  }
  const model::System heavier(other);
  const mechanics::Rotations R = {lie::exp(Vector3d(0, 0, 0.3)), lie::exp(Vector3d(0, 0, -0.4)),
                                  lie::exp(Vector3d(0, 0, 1.1))};
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(system.velocity_count());
  velocity << 0, 0, 0.7, 1.3, -0.6, 0.4, -0.2, 0.0;
  const mechanics::Moments u = {Vector3d(0.8, 0, 0), Vector3d(-0.5, 0, 0)};
  const Eigen::VectorXd one = mechanics::acceleration(system, R, velocity, u);
  const Eigen::VectorXd two = mechanics::acceleration(heavier, R, velocity, u);
  EXPECT_LE((one - two).norm(), tolerance(1e-12) * one.norm());
  EXPECT_GT(one.norm(), 1.0);
}

// The same of ellipsoids, which keep to a plane by their mirror alone.
maneuver::Problem ellipsoids() {
  maneuver::Problem problem = ellipses();
  for (model::BodyDescription& body : problem.swimmer.bodies) body.ellipse = false, body.semi_axes[2] = 0.05;
  const model::System system(problem.swimmer);
  for (std::size_t i = 0; i < 3; ++i) {
    problem.swimmer.bodies[i].mass_matrix = system.bodies()[i].mass_matrix;
    problem.swimmer.bodies[i].inertia_matrix = system.bodies()[i].inertia_matrix;
  }
  problem.start.rotation = {Vector3d(0, 0, 0.3), Vector3d(0, 0, -0.4), Vector3d(0, 0, 1.1)};
  problem.start.linear_velocity = Vector3d(0.4, -0.2, 0);
  for (Vector3d& rate : problem.start.angular_velocity) rate = Vector3d(0, 0, 0.7);
  return problem;
}

// How fast it leaves the plane across e_3, of how fast it moves.
double leaving(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  mechanics::Rotations R;
  for (const Vector3d& turn : problem.start.rotation) R.push_back(lie::exp(turn));
  Eigen::VectorXd velocity = Eigen::VectorXd::Zero(system.velocity_count());
  velocity.head<3>() = problem.start.angular_velocity[0];
  velocity[3] = 1.3;
  velocity[4] = -0.6;
  velocity.tail<3>() = problem.start.linear_velocity;
  const Eigen::VectorXd rate =
      mechanics::acceleration(system, R, velocity, {Vector3d(0.8, 0, 0), Vector3d(-0.5, 0, 0)});
  const auto out = [](const Eigen::VectorXd& v, const Eigen::Matrix3d& root) {
    const Vector3d turn = root * v.head<3>();
    return std::max({std::abs(turn[0]), std::abs(turn[1]), std::abs(v[v.size() - 1])});
  };
  return std::max(out(rate, R[0]) / rate.norm(), out(velocity, R[0]) / velocity.norm());
}

TEST(Plane, of_ellipsoids_is_left_by_whatever_breaks_its_mirror) {
  const auto stays = [](const maneuver::Problem& problem, int axis = 2) {
    return file::stays_in_plane(model::System(problem.swimmer), problem.start, axis);
  };
  EXPECT_TRUE(stays(ellipsoids()));
  EXPECT_LE(leaving(ellipsoids()), tolerance(1e-12));
  const std::vector<std::function<void(maneuver::Problem&)>> breaks = {
      [](auto& p) { p.swimmer.joints[0].axis = Vector3d(0.1, 0, 1); },
      [](auto& p) { p.swimmer.joints[0].parent_offset[2] = 0.02; },
      [](auto& p) { p.swimmer.joints[1].child_offset[2] = 0.02; },
      [](auto& p) { (*p.swimmer.bodies[0].mass_matrix)(0, 2) = (*p.swimmer.bodies[0].mass_matrix)(2, 0) = 0.01; },
      [](auto& p) {
        Eigen::Matrix3d& J = *p.swimmer.bodies[2].inertia_matrix;
        J(0, 2) = J(2, 0) = 0.1 * J(0, 0);
      },
      [](auto& p) { p.swimmer.bodies[1].coupling_matrix = 1e-3 * Eigen::Matrix3d::Identity(); },
      [](auto& p) { p.start.linear_velocity[2] = 0.1; },
      [](auto& p) { p.start.angular_velocity[0] = Vector3d(0.3, 0, 0.7); },
      [](auto& p) { p.start.rotation[0] = Vector3d(0.3, 0, 0); }};
  for (std::size_t n = 0; n < breaks.size(); ++n) {
    maneuver::Problem problem = ellipsoids();
    breaks[n](problem);
    EXPECT_FALSE(stays(problem)) << n;
    EXPECT_GT(leaving(problem), 1e-6) << n;
  }
}

TEST(Plane, of_ellipsoids_lies_as_the_start_is_turned) {
  maneuver::Problem problem = ellipsoids();
  const Eigen::Matrix3d turned = lie::exp(Vector3d(0, std::numbers::pi / 2, 0));  // e_3 to e_1
  for (Vector3d& rotation : problem.start.rotation) rotation = lie::log(turned * lie::exp(rotation));
  problem.start.linear_velocity = turned * problem.start.linear_velocity;
  const model::System system(problem.swimmer);
  EXPECT_TRUE(file::stays_in_plane(system, problem.start, 0));
  EXPECT_FALSE(file::stays_in_plane(system, problem.start, 2));
  problem.goal->move = {};
  problem.waypoints.push_back({0.5, {}, {}, {}});
  const maneuver::Problem told = file::with_plane_told(system, problem);
  for (const auto& move : {told.goal->move, told.waypoints[0].move}) {
    EXPECT_EQ(move[0], 0.0);
    EXPECT_FALSE(move[1] || move[2]);
  }
}

TEST(Plane, of_ball_joints_is_that_of_their_moments) {
  maneuver::Problem problem = ellipsoids();
  for (model::JointDescription& joint : problem.swimmer.joints) {
    joint.kind = model::JointKind::ball;
    joint.axis.reset();
    joint.control_axes = std::vector<Vector3d>{Vector3d(0, 0, -2)};
  }
  problem.start.free_shape = false;
  const auto stays = [&] { return file::stays_in_plane(model::System(problem.swimmer), problem.start, 2); };
  EXPECT_TRUE(stays());
  problem.start.free_shape = true;
  EXPECT_FALSE(stays()) << "the first shape may be out of it";
  problem.start.free_shape = false;
  problem.swimmer.joints[1].control_axes.reset();
  EXPECT_FALSE(stays());
}

}  // namespace
}  // namespace lamprey::tests
