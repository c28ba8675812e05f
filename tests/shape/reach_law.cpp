// What moments can reach is a matter of joints and axes, not of units: heavy swimmers and light ones, quick and slow
// motions have the same coordinates.
#include "shape/reach.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem chain_problem(bool planar, double duration) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  if (planar)
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Eigen::Vector3d(0, 0, 1)};
  problem.start.rotation = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 0.7)};
  problem.start.angular_velocity.assign(3, Eigen::Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.duration.value = duration;
  return problem;
}

struct Reached {
  maneuver::ShapeCoordinates coordinates;
  std::size_t rows;
};

Reached reached(bool planar, double mass_unit, double duration) {
  maneuver::Problem problem = chain_problem(planar, duration);
  for (model::BodyDescription& body : problem.swimmer.bodies) {
    *body.mass_matrix *= mass_unit;
    *body.inertia_matrix *= mass_unit;
  }
  problem.goal->turn = Eigen::Vector3d::Zero();
  problem.goal->move[0] = 2.0;
  const model::System system(problem.swimmer);
  const maneuver::Maneuver probe = maneuver::make_maneuver(system, problem, 20);
  const maneuver::NodePath guess = guess::random_guess(system, probe, 1);
  Reached result{shape::reachable_coordinates(system, probe, guess).value(), 0};
  result.rows = shape::independent_end_rows(system, probe, result.coordinates, guess)->size();
  return result;
}

TEST(Reach, does_not_depend_on_the_units_of_mass_and_time) {
  for (const bool planar : {true, false}) {
    const Reached unit = reached(planar, 1.0, 1.0);
    EXPECT_EQ(unit.coordinates.shape.cols(), planar ? 2 : 6);
    for (const auto& [mass, duration] : {std::pair{1e6, 1.0}, {1e-9, 1.0}, {1.0, 1e-3}, {1.0, 1e4}, {1e9, 1e-4}}) {
      const Reached other = reached(planar, mass, duration);
      EXPECT_EQ(other.coordinates.shape.cols(), unit.coordinates.shape.cols()) << mass << " kg, " << duration << " s";
      EXPECT_EQ(other.coordinates.pose.cols(), unit.coordinates.pose.cols()) << mass << " kg, " << duration << " s";
      EXPECT_EQ(other.rows, unit.rows) << mass << " kg, " << duration << " s";
    }
  }
}

// One angle is one angle: what a grid's round-off or error would add to it, from whatever first guess, is none.
TEST(Reach, of_one_ball_joint_about_one_axis_is_one_coordinate_whatever_the_size_and_the_guess) {
  for (const double size : {0.01, 0.05, 1.0, 30.0}) {
    maneuver::Problem problem;
    problem.swimmer.density = 1000.0;
    problem.swimmer.bodies.resize(2);
    for (std::size_t i = 0; i < 2; ++i) {
      problem.swimmer.bodies[i].name = i == 0 ? "front" : "back";
      problem.swimmer.bodies[i].semi_axes = size * Eigen::Vector3d(0.9 + 0.1 * static_cast<double>(i), 0.15, 0.3);
    }
    model::JointDescription joint;
    joint.kind = model::JointKind::ball;
    joint.parent = "front";
    joint.child = joint.name = "back";
    joint.parent_offset = size * Eigen::Vector3d(-0.97, 0, 0);
    joint.child_offset = size * Eigen::Vector3d(1.08, 0, 0);
    joint.control_axes = {Eigen::Vector3d(0, 0, 1)};
    problem.swimmer.joints = {joint};
    problem.start.rotation.assign(2, Eigen::Vector3d::Zero());
    problem.start.angular_velocity.assign(2, Eigen::Vector3d::Zero());
    problem.goal = maneuver::Goal();
    problem.goal->move[0] = 0.1 * size;
    const model::System system(problem.swimmer);
    for (const int steps : {20, 100})
      for (unsigned seed = 1; seed <= 8; ++seed) {
        const maneuver::Maneuver probe = maneuver::make_maneuver(system, problem, steps);
        const maneuver::NodePath guess = guess::random_guess(system, probe, seed);
        const auto coordinates = shape::reachable_coordinates(system, probe, guess);
        ASSERT_TRUE(coordinates);
        EXPECT_EQ(coordinates->shape.cols(), 1) << size << " m, " << steps << " steps, seed " << seed;
      }
  }
}

// In words, why the goal is out of reach of the chain as it lies when `lie` turns the world.
std::string out_of_reach(maneuver::Problem problem, const Eigen::Vector3d& lie, const Eigen::Vector3d& move,
                         const Eigen::Vector3d& turn) {
  const Eigen::Matrix3d Q = lie::exp(lie);
  for (Eigen::Vector3d& rotation : problem.start.rotation) rotation = lie::log(Q * lie::exp(rotation));
  const Eigen::Vector3d turned_move = Q * move;
  for (int c = 0; c < 3; ++c) problem.goal->move[static_cast<std::size_t>(c)] = turned_move[c];
  problem.goal->turn = Q * turn;
  const model::System system(problem.swimmer);
  const maneuver::Maneuver probe = maneuver::make_maneuver(system, problem, 20);
  const maneuver::NodePath guess = guess::random_guess(system, probe, 1);
  const auto coordinates = shape::reachable_coordinates(system, probe, guess);
  return shape::out_of_reach(system, probe, problem.waypoints, *coordinates, guess);
}

TEST(Reach, of_planar_joints_ends_at_their_plane_however_it_lies) {
  const maneuver::Problem plane = chain_problem(true, 1.0), space = chain_problem(false, 1.0);
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& lie : {none, Eigen::Vector3d(0.4, -0.9, 0.2), Eigen::Vector3d(M_PI / 2.0, 0, 0)}) {
    EXPECT_EQ(out_of_reach(plane, lie, {2.0, -1.0, 0.0}, none), "");
    EXPECT_EQ(out_of_reach(plane, lie, none, {0.0, 0.0, 0.5}), "");
    const std::string beside = out_of_reach(plane, lie, {2.0, 0.0, 0.25}, none);
    EXPECT_NE(beside.find("in the plane normal to"), std::string::npos) << beside;
    EXPECT_NE(beside.find("asks for 0.25 m out of it"), std::string::npos) << beside;
    maneuver::Problem by_way_of = plane;  // a place out of the plane, on the way to one in it
    const Eigen::Vector3d place = lie::exp(lie) * Eigen::Vector3d(1.0, 0.0, 0.5);
    by_way_of.waypoints = {{.time = 0.5, .move = {place[0], place[1], place[2]}, .turn = {}, .rotation = {}}};
    const std::string aside = out_of_reach(by_way_of, lie, {2.0, 0.0, 0.0}, none);
    EXPECT_NE(aside.find("a waypoint's move asks for 0.5 m out of it"), std::string::npos) << aside;
    const std::string rolled = out_of_reach(plane, lie, none, {0.5, 0.0, 0.0});
    EXPECT_NE(rolled.find("turn middle about"), std::string::npos) << rolled;
    EXPECT_EQ(out_of_reach(space, lie, {2.0, 0.0, 0.25}, none), "");
    EXPECT_EQ(out_of_reach(space, lie, none, {0.5, 0.0, 0.0}), "");
  }
}

// Of a price of displacement, in words.
std::string price_refused(const maneuver::Problem& problem) {
  const model::System system(problem.swimmer);
  const maneuver::Maneuver probe = maneuver::make_maneuver(system, problem, 20);
  const maneuver::NodePath guess = guess::random_guess(system, probe, 1);
  try {
    shape::refuse_price_of_no_displacement(system, probe, *shape::reachable_coordinates(system, probe, guess));
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Reach, of_one_joint_angle_ends_where_its_period_began) {
  maneuver::Problem problem = chain_problem(false, 1.0);
  problem.swimmer.bodies.pop_back();
  problem.swimmer.joints.pop_back();
  problem.start.rotation.pop_back();
  problem.start.angular_velocity.pop_back();
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.swimmer.joints[0].control_axes = {Eigen::Vector3d(0, 0, 1)};
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  EXPECT_EQ(out_of_reach(problem, none, {1.0, 0.0, 0.0}, none), "") << "it may turn right round";
  problem.limits.swing["front"] = 1.5;
  EXPECT_NE(out_of_reach(problem, none, {1.0, 0.0, 0.0}, none).find("scallop"), std::string::npos);
  EXPECT_NE(out_of_reach(problem, none, none, {0.0, 0.0, 0.1}).find("scallop"), std::string::npos);
  EXPECT_EQ(out_of_reach(problem, none, none, none), "");
  problem.cost_weights.displacement = {1.0, 0.0, 0.0};
  EXPECT_NE(price_refused(problem).find("cost.displacement: found a price of displacement, but a single joint angle"),
            std::string::npos);
  problem.limits.swing.clear();
  EXPECT_EQ(price_refused(problem), "") << "whole turns may win one";
  problem.swimmer.joints[0].stiffness = 1.0;
  EXPECT_NE(price_refused(problem).find("a single joint angle"), std::string::npos) << "springs do not turn round";
  problem.swimmer.joints[0].stiffness = 0.0;
  problem.limits.swing["front"] = 1.5;
  problem.cost_weights.displacement.setZero();
  EXPECT_EQ(price_refused(problem), "");
  problem.cost_weights.transport = 1.0;
  const auto asked = problem.goal;
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  EXPECT_NE(price_refused(problem).find("cost.transport: found a price of each metre, but a single joint angle"),
            std::string::npos);
  problem.cost_weights = {};
  problem.goal = asked;
  problem.swimmer.joints[0].control_axes = {Eigen::Vector3d(1, 0, 0)};  // along both arms
  EXPECT_EQ(out_of_reach(problem, none, none, {0.1, 0.0, 0.0}), "")
      << "an arm that is turned about itself does not swing";
  problem.limits.swing.clear();
  problem.limits.twist["front"] = 3.0;
  EXPECT_NE(out_of_reach(problem, none, none, {0.1, 0.0, 0.0}).find("scallop"), std::string::npos) << "but it twists";
  problem.limits.twist["front"] = 3.1415926535;
  EXPECT_EQ(out_of_reach(problem, none, none, {0.1, 0.0, 0.0}), "") << "which is no limit";
  problem.limits.twist.clear();
  problem.limits.swing["front"] = 1.5;
  problem.swimmer.joints[0].control_axes = {Eigen::Vector3d(0, 0, 1)};
  problem.goal->periodic = false;
  problem.goal->rest = true;
  EXPECT_NE(out_of_reach(problem, none, {1.0, 0.0, 0.0}, none).find("scallop"), std::string::npos);
  EXPECT_NE(out_of_reach(problem, none, none, {0.0, 0.0, 0.1}).find("scallop"), std::string::npos);
  problem.goal->rotation["front"] = Eigen::Vector3d(0.0, 0.0, 0.3);
  EXPECT_EQ(out_of_reach(problem, none, {1.0, 0.0, 0.0}, none), "") << "another shape";
  problem.goal->rotation.clear();
  problem.goal->periodic = true;
  problem.goal->rest = false;
  problem.swimmer.joints[0].control_axes.reset();
  EXPECT_EQ(out_of_reach(problem, none, {1.0, 0.0, 0.0}, none), "") << "three angles";
}

std::string contradiction(const maneuver::Problem& problem) {
  try {
    maneuver::make_maneuver(model::System(problem.swimmer), problem, 20);
  } catch (const model::InputError& error) {
    return error.what();
  }
  return "";
}

// Bodies that are as heavy in all directions keep their weighted centre, in a fluid as in a vacuum.
TEST(WeightedCentre, of_equally_heavy_bodies_tells_where_the_root_ends) {
  for (const bool vacuum : {false, true}) {
    maneuver::Problem problem = chain_problem(false, 1.0);
    Random random(3);
    for (std::size_t i = 0; i < problem.swimmer.bodies.size(); ++i)
      problem.swimmer.bodies[i].mass_matrix = (1.0 + 0.5 * static_cast<double>(i)) * Eigen::Matrix3d::Identity();
    if (vacuum) {
      problem.swimmer.density = 0.0;
      for (model::BodyDescription& body : problem.swimmer.bodies) {
        body.mass = body.mass_matrix->trace() / 3.0;
        body.mass_matrix.reset();
      }
    }
    const model::System system(problem.swimmer);
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    problem.goal->turn = none;
    problem.goal->move = {0.3, std::nullopt, std::nullopt};
    EXPECT_NE(contradiction(problem).find("goal.move: found 0.3 m along e₁, but each body is as heavy"),
              std::string::npos)
        << contradiction(problem);
    problem.goal->move[0] = 0.0;
    EXPECT_EQ(contradiction(problem), "") << "it ends where it must";
    problem.cost_weights.displacement = {0.0, 1.0, 0.0};
    EXPECT_NE(contradiction(problem).find("cost.displacement: found a price"), std::string::npos);
    problem.cost_weights.displacement.setZero();
    // another shape moves the root by what the motion's momentum says
    for (const model::BodyDescription& body : problem.swimmer.bodies)
      problem.goal->rotation[body.name] = random.vector(0.5);
    mechanics::Rotations ends, starts;
    for (std::size_t i = 0; i < problem.swimmer.bodies.size(); ++i) {
      starts.push_back(lie::exp(problem.start.rotation[i]));
      ends.push_back(lie::exp(*problem.goal->rotation[problem.swimmer.bodies[i].name]));
    }
    const auto before = system.mass_centres(starts, problem.start.position),
               after = system.mass_centres(ends, problem.start.position);
    Eigen::Vector3d moved = none;
    double whole = 0.0;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const double mass = system.bodies()[i].mass_matrix(0, 0);
      moved += mass * (before[i] - after[i]);
      whole += mass;
    }
    for (int c = 0; c < 3; ++c) problem.goal->move[static_cast<std::size_t>(c)] = moved[c] / whole;
    EXPECT_EQ(contradiction(problem), "");
    problem.goal->move[1] = *problem.goal->move[1] + 1e-3;
    EXPECT_NE(contradiction(problem).find("along e₂"), std::string::npos);
    problem.goal->rotation["front"] = std::nullopt;
    EXPECT_EQ(contradiction(problem), "") << "one attitude is open";
    double farthest = 0.0;  // all joints stretched
    for (const model::Body& body : system.bodies())
      for (const model::PathPoint& point : body.path) farthest += body.mass_matrix(0, 0) / whole * point.offset.norm();
    maneuver::Problem far = problem;
    far.goal->move = {2.0 * farthest + 1e-3, std::nullopt, std::nullopt};  // to and fro
    EXPECT_NE(contradiction(far).find("with all joints stretched"), std::string::npos) << contradiction(far);
    problem.goal->rotation.clear();
    problem.goal->periodic = problem.start.free_shape = true;
    problem.goal->rest = false;
    problem.goal->move = {0.1, std::nullopt, std::nullopt};
    EXPECT_NE(contradiction(problem), "") << "straight on";
    problem.goal->turn = Eigen::Vector3d(0.0, 0.0, 0.3);
    EXPECT_EQ(contradiction(problem), "") << "turned, from whatever shape";
  }
  maneuver::Problem circles = chain_problem(true, 1.0);  // in a plane fluid
  circles.start.rotation[2].setZero();
  for (model::BodyDescription& body : circles.swimmer.bodies) {
    body.ellipse = true;
    body.semi_axes = Vector3d::Ones();
    body.mass_matrix.reset();
    body.inertia_matrix.reset();
  }
  circles.goal->turn = Eigen::Vector3d::Zero();
  circles.goal->move = {0.3, std::nullopt, std::nullopt};
  EXPECT_NE(contradiction(circles).find("(circles, fluid included)"), std::string::npos) << contradiction(circles);
  circles.swimmer.bodies[1].semi_axes = Vector3d(1.0, 0.9, 0.9);
  EXPECT_EQ(contradiction(circles), "");
  maneuver::Problem longer = chain_problem(false, 1.0);
  longer.goal->move = {0.3, std::nullopt, std::nullopt};
  longer.goal->turn = Eigen::Vector3d::Zero();
  EXPECT_EQ(contradiction(longer), "");
}

}  // namespace
}  // namespace lamprey::tests
