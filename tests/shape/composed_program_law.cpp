// Steps so long that bodies turn far.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "maneuver/motion.hpp"
#include "shape/composed_program.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using integrator::Scheme;
using mechanics::Rotations;
using shape::ShapeStep;

// A far way between two shapes of a swimmer, and the root's motion that only one of two roads finds to it.
struct FarWay {
  Rotations from, to;
  ShapeStep step;  // by ShapeKernel
};

Rotations as_shape(Rotations R) {
  const Matrix3d root = R[0];
  for (Matrix3d& Q : R) Q = (root.transpose() * Q).eval();
  return R;
}

// The first of many random ones that is lost in fours.
std::optional<FarWay> lost_in_fours(Random& random, const model::System& system) {
  const int size = maneuver::shape_size(system);
  const MatrixXd all = MatrixXd::Identity(size, size);
  const auto lagrangian = integrator::lagrangian_of(Scheme::order4);
  shape::ShapeKernel kernel(system, lagrangian, all);
  shape::FourSteps fours(system, lagrangian, all);
  for (int trial = 0; trial < 4000; ++trial) {
    FarWay way{as_shape(random_rotations(random, system)), {}, ShapeStep(system)};
    way.to = as_shape(turned(system, way.from, random_freedoms(random, system, 0.7)));
    ShapeStep in_four(system);
    fours.take_shapes(0.1, {&way.from, &way.from, &way.from, &way.from}, {&way.to, &way.to, &way.to, &way.to});
    if (fours.solve({&in_four, &in_four, &in_four, &in_four})) continue;
    if (kernel.solve(0.1, way.from, way.to, way.step)) return way;
  }
  return std::nullopt;
}

TEST(ComposedProgram, goes_by_single_stages_where_four_at_once_find_no_motion) {
  Random random(5);
  const model::System system(random_tree(random, 3));
  const std::optional<FarWay> way = lost_in_fours(random, system);
  ASSERT_TRUE(way) << "four at once found them all";
  maneuver::Maneuver maneuver;
  maneuver.start.rotation = way->from;
  maneuver.start.momentum = VectorXd::Zero(system.velocity_count());
  maneuver.end_rotation.assign(way->from.size(), std::nullopt);
  maneuver.duration = 0.1;
  maneuver.steps = 1;
  maneuver.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 0.1, 1);
  shape::ComposedProgram program(system, maneuver, Scheme::order4, maneuver::ShapeCoordinates(system), {});
  const int stages = integrator::composition(Scheme::order4).stages(),
            terms = maneuver::polynomial_terms(Scheme::order4);
  maneuver::NodePath path;  // all of the way in the first stage
  path.rotation.assign(model::at(stages + 1), way->to);
  path.rotation.front() = way->from;
  path.position.assign(model::at(stages + 1), Vector3d::Zero());
  path.polynomial.assign(1, VectorXd::Zero(terms * system.control_count()));
  ASSERT_TRUE(program.go_to(path));
  EXPECT_LE(program.drift(), tolerance(1e-12));
  const maneuver::NodePath found = program.path();
  const Matrix3d root_turn = found.rotation[0][0].transpose() * found.rotation[1][0];
  EXPECT_LE((root_turn - way->step.root_turn).norm(), tolerance(1e-12));
  EXPECT_GT(lie::rotation_angle(root_turn), 0.1);
  EXPECT_LE((found.position.back() - way->step.interval.displacement).norm(),
            tolerance(1e-12) * (1.0 + way->step.interval.displacement.norm()));
}

}  // namespace
}  // namespace lamprey::tests
