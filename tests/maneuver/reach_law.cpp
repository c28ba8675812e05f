// What moments can reach is a matter of joints and axes, not of units: heavy swimmers and light ones, quick and slow
// motions have the same coordinates.
#include "maneuver/reach.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "maneuver/guess.hpp"

namespace lamprey::tests {
namespace {

struct Reached {
  maneuver::ShapeCoordinates coordinates;
  std::size_t rows;
};

Reached reached(bool planar, double mass_unit, double duration) {
  maneuver::Problem problem;
  problem.swimmer = paper_chain();
  for (model::BodyDescription& body : problem.swimmer.bodies) {
    *body.mass_matrix *= mass_unit;
    *body.inertia_matrix *= mass_unit;
  }
  if (planar)
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Eigen::Vector3d(0, 0, 1)};
  problem.start.rotation = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 0.7)};
  problem.start.angular_velocity.assign(3, Eigen::Vector3d::Zero());
  problem.goal = maneuver::Goal();
  problem.goal->turn = Eigen::Vector3d::Zero();
  problem.goal->move[0] = 2.0;
  problem.duration.value = duration;
  const model::System system(problem.swimmer);
  const maneuver::Maneuver probe = maneuver::make_maneuver(system, problem, 20);
  const maneuver::NodePath guess = maneuver::random_guess(system, probe, 1);
  Reached result{maneuver::reachable_coordinates(system, probe, guess).value(), 0};
  result.rows = maneuver::independent_end_rows(system, probe, result.coordinates, guess)->size();
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

}  // namespace
}  // namespace lamprey::tests
