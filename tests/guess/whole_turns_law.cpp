// Guesses whose joints turn all the way round end in the shape that they would end in anyway, lead where they were drawn to lead, and
// spare joints that limits hold.
#include "guess/whole_turns.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "chains.hpp"
#include "guess/strokes.hpp"
#include "hull_with_paddles.hpp"
#include "shape/reach.hpp"
#include "shape/shape_program.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using guess::WholeTurns;

constexpr double round_once = 2.0 * std::numbers::pi;

// A problem with what its guesses are made of.
struct Turning {
  maneuver::Problem problem;
  model::System system;
  maneuver::Maneuver maneuver;
  maneuver::ShapeCoordinates coordinates;
  std::vector<maneuver::EndRow> rows;

  explicit Turning(const maneuver::Problem& asked)
      : problem(asked),
        system(problem.swimmer),
        maneuver(maneuver::make_maneuver(system, problem, 200)),
        coordinates(system) {
    const maneuver::NodePath guess = guess::random_guess(system, maneuver, 1);
    coordinates = *shape::reachable_coordinates(system, maneuver, guess);
    rows = *shape::independent_end_rows(system, maneuver, coordinates, guess);
  }

  std::optional<WholeTurns> drawn(std::uint64_t seed, double share = 1.0, int most = 10) const {
    maneuver::Random random(seed);
    return guess::whole_turns_to_goal(system, maneuver, coordinates, rows,
                                      guess::joints_that_turn_round(system, problem), share, most, random);
  }

  // rad: by which the root ends turned about e_3, all the way.
  double turned_by(const WholeTurns& turns) const {
    shape::ShapeProgram program(system, maneuver, coordinates, rows, {}, shape::Steps::rough);
    const auto still = [](int, double) -> Vector3d { return Vector3d::Zero(); };
    EXPECT_TRUE(program.go_to(guess::swung(system, maneuver, still, turns)));
    const maneuver::NodePath path = program.path();
    double turned = 0.0;
    for (std::size_t k = 1; k < path.rotation.size(); ++k)
      turned += lie::log(path.rotation[k - 1][0].transpose() * path.rotation[k][0])[2];
    return turned;
  }
};

TEST(WholeTurnsOfJoints, end_in_the_shape_that_there_would_be_without_them) {
  Random random(3);
  for (int trial = 0; trial < 10; ++trial) {
    maneuver::Problem problem;
    problem.swimmer = random_swimmer(random, 4);
    problem.goal = maneuver::Goal();
    const model::System system(problem.swimmer);
    problem.start.rotation.assign(4, Vector3d::Zero());
    problem.start.angular_velocity.assign(4, Vector3d::Zero());
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system, problem, 60);
    const auto swing = [](int, double s) -> Vector3d { return 0.3 * s * (1.0 - s) * Vector3d(1.0, -1.0, 0.5); };
    WholeTurns turns;
    for (const model::Joint& joint : system.joints())
      turns.emplace_back(joint.actuation.cols() > 0 ? Vector3d(2.0 * round_once * joint.actuation.col(0).normalized())
                                                    : Vector3d(Vector3d::Zero()));
    const auto with = guess::swung(system, maneuver, swing, turns);
    const auto without = guess::swung(system, maneuver, swing);
    for (int j = 0; j < system.joint_count(); ++j) {
      const model::Joint& joint = system.joint(j);
      const auto shape = [&](const maneuver::NodePath& path, std::size_t node) {
        return mechanics::child_to_parent(path.rotation[node], joint);
      };
      EXPECT_LE((shape(with, 60) - shape(without, 60)).norm(), tolerance(1e-12));
      if (turns[model::at(j)].isZero(0.0)) continue;
      EXPECT_GT((shape(with, 23) - shape(without, 23)).norm(), 0.1) << "does not turn round on its way";
    }
  }
}

TEST(WholeTurnsOfJoints, lead_as_far_as_they_were_drawn_for) {
  const Turning turning(hull_with_paddles(1.5));
  int drawn = 0, other_way = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    for (const double share : {1.0, 0.4}) {
      const std::optional<WholeTurns> turns = turning.drawn(seed, share);
      if (!turns) continue;
      ++drawn;
      double most = 0.0;
      for (const Vector3d& turn : *turns) {
        EXPECT_NEAR(std::remainder(turn.norm(), round_once), 0.0, tolerance(1e-12));
        most = std::max(most, turn.norm() / round_once);
      }
      EXPECT_GT(most, 0.5);
      EXPECT_LT(most, 10.5);
      const double turned = turning.turned_by(*turns), way = turned > 0.0 ? 1.5 : 1.5 - round_once;
      other_way += turned < 0.0;
      EXPECT_LE(std::abs(turned - share * way), (0.5 + tolerance(1e-2)) * std::abs(way)) << seed;
    }
  EXPECT_GE(drawn, 40);
  EXPECT_GE(other_way, 4);
}

TEST(WholeTurnsOfJoints, and_strokes_arrive) {
  const Turning turning(hull_with_paddles(1.5));
  int arrived = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const std::optional<WholeTurns> turns = turning.drawn(seed);
    if (!turns) continue;
    const guess::Strokes found =
        guess::strokes_to_goal(turning.system, turning.maneuver, turning.coordinates, turning.rows,
                               guess::no_stroke_limits(turning.system), 1, seed, *turns);
    if (found.path.rotation.empty() || found.missed > 1e-5) continue;
    ++arrived;
    for (int j = 0; j < 4; ++j) {
      const model::Joint& hinge = turning.system.joint(j);
      double turned = 0.0;
      for (std::size_t k = 1; k < found.path.rotation.size(); ++k)
        turned += mechanics::turn_between(hinge, mechanics::child_to_parent(found.path.rotation[k - 1], hinge),
                                          mechanics::child_to_parent(found.path.rotation[k], hinge))[0];
      EXPECT_NEAR(turned, (*turns)[model::at(j)][0], tolerance(1e-9));
    }
  }
  EXPECT_GE(arrived, 2);
}

TEST(WholeTurnsOfJoints, are_made_by_joints_that_nothing_holds) {
  maneuver::Problem problem = hull_with_paddles(1.0);
  problem.limits.angle["fr"] = {{-1.0, 1.0}};
  problem.swimmer.joints[3].actuated = false;
  const model::System system(problem.swimmer);
  EXPECT_EQ(guess::joints_that_turn_round(system, problem), (std::vector<int>{0, 2}));
  problem.swimmer.joints[0].stiffness = 0.1;
  EXPECT_EQ(guess::joints_that_turn_round(model::System(problem.swimmer), problem), (std::vector<int>{2}));
  maneuver::Problem balls;
  balls.swimmer = paper_chain();
  balls.limits.swing["front"] = 1.0;
  EXPECT_EQ(guess::joints_that_turn_round(model::System(balls.swimmer), balls), (std::vector<int>{1}));
  balls.limits.twist["back"] = 1.0;
  EXPECT_TRUE(guess::joints_that_turn_round(model::System(balls.swimmer), balls).empty());
}

// Where nothing is to be turned, turns to and fro may still carry the swimmer along.
TEST(WholeTurnsOfJoints, towards_goals_without_a_turn_hardly_turn_the_swimmer) {
  const Turning turning(hull_with_paddles(0.0));
  int drawn = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    if (const std::optional<WholeTurns> turns = turning.drawn(seed)) {
      ++drawn;
      EXPECT_LE(std::abs(turning.turned_by(*turns)), 2.0);
      for (const Vector3d& turn : *turns) EXPECT_LE(turn.norm(), tolerance(1e-12) + round_once);
    }
  EXPECT_GE(drawn, 10);
}

}  // namespace
}  // namespace lamprey::tests
