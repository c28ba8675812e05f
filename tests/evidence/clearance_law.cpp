#include "evidence/clearance.hpp"

#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "evidence/bounds.hpp"
#include "maneuver/limit_rows.hpp"
#include "marched_answers.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using evidence::Clearance;

// Two hinged arms about one pivot at the root: each a ball of radius 0.3 m at 1 m from the pivot.
struct Arms {
  maneuver::Problem problem;
  maneuver::Solution solution;

  explicit Arms(int steps) {
    model::SwimmerDescription& swimmer = problem.swimmer;
    swimmer.density = 1000.0;
    swimmer.bodies.resize(3);
    const char* names[] = {"root", "left", "right"};
    for (std::size_t i = 0; i < 3; ++i) {
      swimmer.bodies[i].name = names[i];
      swimmer.bodies[i].semi_axes.setConstant(i == 0 ? 0.1 : 0.3);
    }
    for (std::size_t child : {1U, 2U}) {
      model::JointDescription joint;
      joint.name = joint.child = names[child];
      joint.parent = "root";
      joint.kind = model::JointKind::hinge;
      joint.axis = Vector3d::UnitZ();
      joint.parent_offset.setZero();
      joint.child_offset = {-1.0, 0.0, 0.0};
      swimmer.joints.push_back(joint);
    }
    problem.start.rotation.assign(3, Vector3d::Zero());
    problem.start.angular_velocity.assign(3, Vector3d::Zero());
    problem.steps = steps;
  }

  void add(double time, double left, double right) {
    const Matrix3d root = lie::exp({0.3, 0.7 * time, -0.2});
    solution.time.push_back(time);
    solution.position.emplace_back(2.0 * time, 0.0, 1.0);
    solution.rotation.push_back({root, root * lie::exp({0, 0, left}), root * lie::exp({0, 0, right})});
    solution.control.emplace_back(2, Vector3d::Zero());
  }

  std::optional<Clearance> clearance() const {
    const model::System system(problem.swimmer);
    return evidence::clearance(evidence::StoredMotion(system, problem, solution));
  }
};

// What fixed joints hold together is one body: its parts may overlap, and hide nothing that comes near them.
TEST(Clearance, is_not_asked_between_bodies_that_move_as_one) {
  Arms arms(1);
  model::JointDescription& stiff = arms.problem.swimmer.joints[0];
  stiff.kind = model::JointKind::fixed;
  stiff.axis.reset();
  stiff.child_offset.setZero();  // "left" around "root"
  arms.add(0.0, 0.0, 0.2);
  arms.add(1.0, 0.0, 0.4);
  const auto found = arms.clearance();
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(std::pair(found->first, found->second), std::pair(1, 2));
  EXPECT_NEAR(found->gap, 0.4, tolerance(1e-9));
  arms.problem.limits.clearance = 0.05;
  const model::System system(arms.problem.swimmer);
  std::vector<std::pair<int, int>> pairs;
  for (const maneuver::LimitRow& row : maneuver::limit_rows(system, arms.problem))
    pairs.emplace_back(row.body, row.other_body);
  EXPECT_EQ(pairs, (std::vector<std::pair<int, int>>{{0, 2}, {1, 2}}));
  std::vector<std::pair<int, int>> bounded;
  for (const evidence::Bound& bound : evidence::bounds_of(evidence::StoredMotion(system, arms.problem, arms.solution)))
    bounded.emplace_back(bound.body, bound.other_body);
  EXPECT_EQ(bounded, pairs);
}

// Ellipses that cross leave each other in their plane, however flat they are drawn: their gap is the largest of all separations along
// directions of the plane.
TEST(Clearance, of_ellipses_that_cross_is_the_way_out_in_their_plane) {
  for (const double apart : {0.0014, 0.05, 0.12}) {
    maneuver::Problem problem;
    problem.swimmer.density = 1000.0;
    problem.swimmer.bodies.resize(2);
    for (std::size_t i = 0; i < 2; ++i) {
      problem.swimmer.bodies[i].name = std::string(i == 0 ? "one" : "other");
      problem.swimmer.bodies[i].semi_axes = Vector3d(0.1, 0.01, 0.01);
      problem.swimmer.bodies[i].ellipse = true;
    }
    model::JointDescription joint;
    joint.name = joint.child = "other";
    joint.parent = "one";
    joint.kind = model::JointKind::hinge;
    joint.axis = Vector3d::UnitZ();
    joint.parent_offset = Vector3d(apart, 0.5 * apart, 0.0);
    joint.child_offset.setZero();
    problem.swimmer.joints.push_back(joint);
    problem.start.rotation.assign(2, Vector3d::Zero());
    problem.start.angular_velocity.assign(2, Vector3d::Zero());
    problem.steps = 1;
    maneuver::Solution still;
    const double quarter = 0.5 * std::acos(-1.0);
    for (int k = 0; k < 2; ++k) {
      still.time.push_back(k);
      still.position.emplace_back(Vector3d::Zero());
      still.rotation.push_back({Matrix3d::Identity(), lie::exp(quarter * Vector3d::UnitZ())});
      still.control.emplace_back(1, Vector3d::Zero());
    }
    double widest = -1.0;
    for (int n = 0; n < 100'000; ++n) {
      const double c = std::cos(4e-5 * quarter * n), s = std::sin(4e-5 * quarter * n);
      widest =
          std::max(widest, c * apart + 0.5 * s * apart - std::hypot(0.1 * c, 0.01 * s) - std::hypot(0.01 * c, 0.1 * s));
    }
    const model::System system(problem.swimmer);
    const auto found = evidence::clearance(evidence::StoredMotion(system, problem, still));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->gap, widest, 1e-9) << apart;
  }
}

TEST(Clearance, of_arms_that_open_and_close_is_their_chord_less_both_radii) {
  Arms arms(4);
  for (int k = 0; k <= 4; ++k) arms.add(0.25 * k, 0.9, k == 3 ? -0.5 : -1.2);
  const auto nearest = arms.clearance();
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->gap, 0.6, tolerance(1e-14)) << "the root's radius 0.1 m and an arm's 0.3 m at 1 m";
  EXPECT_EQ(nearest->first, 0);
  Arms near(4);
  for (int k = 0; k <= 4; ++k) near.add(0.25 * k, 0.4, k == 3 ? -0.3 : -1.2);
  const auto chord = near.clearance();
  ASSERT_TRUE(chord);
  EXPECT_NEAR(chord->gap, 2.0 * std::sin(0.35) - 0.6, tolerance(1e-14));
  EXPECT_NEAR(chord->time, 0.75, tolerance(1e-14));
  EXPECT_EQ(chord->first, 1);
  EXPECT_EQ(chord->second, 2);
}

// At both nodes the arms are apart; half way one swings through the other.
TEST(Clearance, sees_bodies_that_pass_through_each_other_between_two_nodes) {
  Arms arms(1);
  arms.add(0.0, 0.8, 0.0);
  arms.add(0.5, -0.8, 0.0);
  const auto nearest = arms.clearance();
  ASSERT_TRUE(nearest);
  EXPECT_NEAR(nearest->gap, -0.6, tolerance(1e-14));
  EXPECT_NEAR(nearest->time, 0.25, tolerance(1e-14));
  EXPECT_EQ(nearest->first, 1);
  EXPECT_EQ(nearest->second, 2);
}

TEST(Clearance, is_part_of_the_certificate_and_missing_for_a_single_body) {
  Arms arms(1);
  arms.add(0.0, 0.8, 0.0);
  arms.add(0.5, -0.8, 0.0);
  arms.solution.status = maneuver::Status::simulated;
  const model::System system(arms.problem.swimmer);
  const auto proof = certificate::certify(system, arms.problem, arms.solution, {.optimality = false, .replay = false});
  ASSERT_TRUE(proof.clearance);
  EXPECT_EQ(proof.clearance->gap, arms.clearance()->gap);
  Arms single(1);
  single.problem.swimmer.bodies.resize(1);
  single.problem.swimmer.joints.clear();
  for (double t : {0.0, 1.0}) {
    single.add(t, 0.0, 0.0);
    single.solution.rotation.back().resize(1);
  }
  EXPECT_FALSE(single.clearance());
}

TEST(Clearance, is_not_a_number_where_stored_numbers_are_none) {
  Arms arms(2);
  for (int k = 0; k <= 2; ++k) arms.add(k, 0.8, 0.0);
  arms.solution.rotation[1][2](0, 1) = NAN;
  ASSERT_TRUE(arms.clearance());
  EXPECT_TRUE(std::isnan(arms.clearance()->gap));
  EXPECT_EQ(arms.clearance()->first, -1);
}

TEST(Clearance, places_ten_million_bodies_at_most_unless_the_nodes_are_more) {
  EXPECT_EQ(evidence::parts_of_step(1000, 3), 10);
  EXPECT_EQ(evidence::parts_of_step(1000, 1000), 10);
  EXPECT_EQ(evidence::parts_of_step(1000000, 3), 3);
  EXPECT_EQ(evidence::parts_of_step(1000000, 1000), 1);
}

TEST(StepPath, ends_at_the_nodes_and_keeps_hinges_and_joints_between_them) {
  Arms arms(1);
  arms.add(0.0, 0.8, 0.3);
  arms.add(0.5, -1.7, 0.9);
  const model::System system(arms.problem.swimmer);
  const evidence::StoredMotion motion(system, arms.problem, arms.solution);
  const evidence::StepPath path(motion, 0);
  for (std::size_t node : {0U, 1U})
    for (std::size_t i = 0; i < 3; ++i) {
      const Matrix3d& stored = arms.solution.rotation[node][i];
      EXPECT_LT((path.at(double(node)).rotation[i] - stored).norm(), tolerance(1e-14));
    }
  for (double s : {0.3, 0.77}) {
    const auto placed = path.at(s);
    const Matrix3d left = placed.rotation[0].transpose() * placed.rotation[1];
    EXPECT_LT((left - lie::exp({0, 0, 0.8 - 2.5 * s})).norm(), tolerance(1e-14));
    EXPECT_NEAR((placed.position[2] - placed.position[0]).norm(), 1.0, tolerance(1e-14));
    EXPECT_LT((placed.position[0] - Vector3d(s, 0.0, 1.0)).norm(), tolerance(1e-14));
  }
}

}  // namespace
}  // namespace lamprey::tests
