// Two roads to one maneuver: Newton's method in shapes, and the full transcription with Ipopt.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "guess/guess.hpp"
#include "optimizer/ipopt.hpp"
#include "optimizer/stage_newton.hpp"
#include "shape/reach.hpp"
#include "shape/shape_program.hpp"
#include "tolerance.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::tests {
namespace {

using maneuver::Maneuver;
using maneuver::NodePath;
using optimizer::Outcome;

struct Asked {
  std::string name;
  Vector3d turn;
  std::optional<double> move;
  mechanics::DiscreteLagrangian lagrangian;
  bool axis_alone;  // one of the ball joints exerts moments about two axes only
  std::uint64_t seed;
};

class TwoRoads : public ::testing::TestWithParam<Asked> {
 protected:
  static constexpr int steps = 40;

  TwoRoads() : system_(chain()) {
    maneuver_.start.rotation.assign(3, Matrix3d::Identity());
    maneuver_.start.rotation[2] = lie::exp(Vector3d(0.0, 0.0, 0.5));
    maneuver_.start.position = Vector3d::Zero();
    maneuver_.start.momentum = Eigen::VectorXd::Zero(system_.velocity_count());
    maneuver_.total = {Vector3d::Zero(), Vector3d::Zero()};
    for (const Matrix3d& R : maneuver_.start.rotation)
      maneuver_.end_rotation.emplace_back(lie::exp(GetParam().turn) * R);
    maneuver_.end_position[0] = GetParam().move;
    maneuver_.lagrangian = GetParam().lagrangian;
    maneuver_.steps = steps;
    maneuver_.node_weight = maneuver::node_weights(maneuver::CostRule::trapezoid, 1.0, 1.0 / steps, steps);
  }

  static model::SwimmerDescription chain() {
    model::SwimmerDescription swimmer = paper_chain();
    if (GetParam().axis_alone) swimmer.joints[0].control_axes = {Vector3d::UnitY(), Vector3d::UnitZ()};
    return swimmer;
  }

  // From a path by Newton's method in shapes.
  Outcome by_newton(const NodePath& from, NodePath& found) const {
    const NodePath guess = guess::random_guess(system_, maneuver_, GetParam().seed);
    const maneuver::ShapeCoordinates coordinates = shape::reachable_coordinates(system_, maneuver_, guess).value();
    shape::ShapeProgram program(system_, maneuver_, coordinates,
                                shape::independent_end_rows(system_, maneuver_, coordinates, guess).value(), {},
                                shape::Steps::rough);  // as Ipopt: on the way bodies may turn far
    EXPECT_TRUE(program.go_to(from));
    optimizer::Options options;
    options.tolerance = 1e-8;
    const Outcome outcome = optimizer::StageNewton(program.sizes()).solve(program, options);
    found = program.path();
    return outcome;
  }

  // From a path by Ipopt; the cost in (N m)² s.
  Outcome by_ipopt(const NodePath& from, NodePath& found) const {
    std::vector<transcription::GoalRow> rows = transcription::stated_goal_rows(system_, maneuver_);
    transcription::Transcription program(system_, maneuver_, rows);
    optimizer::Options options;
    options.tolerance = 1e-10;
    Outcome outcome = optimizer::solve_with_ipopt(program, options, program.pack(from));
    outcome.objective *= program.cost_unit();
    found = program.unpack(outcome.point);
    return outcome;
  }

  model::System system_;
  Maneuver maneuver_;
};

TEST_P(TwoRoads, each_stays_where_the_other_arrives) {
  NodePath newtons, ipopts, back;
  const Outcome newton = by_newton(guess::random_guess(system_, maneuver_, GetParam().seed), newtons);
  ASSERT_EQ(newton.termination, optimizer::Termination::converged) << newton.reason;
  EXPECT_LE(newton.infeasibility, tolerance(1e-10));
  const Outcome ipopt = by_ipopt(newtons, ipopts);
  EXPECT_EQ(ipopt.termination, optimizer::Termination::converged) << ipopt.reason;
  EXPECT_NEAR(ipopt.objective, newton.objective, tolerance(1e-8) * newton.objective);
  EXPECT_LE(ipopt.iterations, 20);
  const Outcome again = by_newton(ipopts, back);
  EXPECT_EQ(again.termination, optimizer::Termination::converged) << again.reason;
  EXPECT_NEAR(again.objective, newton.objective, tolerance(1e-8) * newton.objective);
  EXPECT_LE(again.iterations, 5);
  for (int k = 0; k <= steps; ++k)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE(
          (ipopts.rotation[static_cast<std::size_t>(k)][i] - newtons.rotation[static_cast<std::size_t>(k)][i]).norm(),
          tolerance(1e-5));
}

INSTANTIATE_TEST_SUITE_P(Maneuvers, TwoRoads,
                         ::testing::Values(Asked{"a_move_in_space", Vector3d::Zero(), 1.0,
                                                 mechanics::DiscreteLagrangian::trapezoid, false, 3},
                                           Asked{"a_turn", Vector3d(1.5, 0.3, 0.2), std::nullopt,
                                                 mechanics::DiscreteLagrangian::trapezoid, false, 5},
                                           Asked{"a_turn_by_the_papers_scheme", Vector3d(1.5, 0.3, 0.2), std::nullopt,
                                                 mechanics::DiscreteLagrangian::paper, false, 6},
                                           Asked{"a_turn_with_an_idle_axis", Vector3d(0.8, 0.2, 0.4), std::nullopt,
                                                 mechanics::DiscreteLagrangian::trapezoid, true, 7}),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace lamprey::tests
