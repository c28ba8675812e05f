// First guesses of chains of many links bend them as one body: in few waves, however many links they are made of.
#include <gtest/gtest.h>

#include <cmath>

#include "guess/guess.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem chain(int links) {
  maneuver::Problem problem;
  problem.swimmer.density = 1000.0;
  for (int i = 0; i < links; ++i) {
    model::BodyDescription body;
    body.name = "link" + std::to_string(i);
    body.semi_axes = {0.5 / links, 0.012, 0.025};
    problem.swimmer.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = joint.child = body.name;
    joint.parent = "link" + std::to_string(i - 1);
    joint.kind = model::JointKind::hinge;
    joint.axis = {0.0, 0.0, 1.0};
    joint.parent_offset = {-0.5 / links, 0.0, 0.0};
    joint.child_offset = {0.5 / links, 0.0, 0.0};
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(problem.swimmer.bodies.size(), Eigen::Vector3d::Zero());
  problem.start.angular_velocity.assign(problem.swimmer.bodies.size(), Eigen::Vector3d::Zero());
  problem.goal.emplace();
  problem.goal->move[0] = 0.1;
  problem.goal->turn = Eigen::Vector3d::Zero();
  return problem;
}

// rad, [joints] at half time.
std::vector<double> bends(int links, std::uint64_t seed) {
  const maneuver::Problem problem = chain(links);
  const model::System system(problem.swimmer);
  const maneuver::NodePath path = guess::random_guess(system, maneuver::make_maneuver(system, problem, 20), seed);
  std::vector<double> angles;
  for (const model::Joint& joint : system.joints())
    angles.push_back(mechanics::joint_angles(joint, mechanics::child_to_parent(path.rotation[10], joint))[0]);
  return angles;
}

double change_of_slope(const std::vector<double>& angles, std::size_t j) {
  return std::abs(angles[j + 1] - 2.0 * angles[j] + angles[j - 1]);
}

TEST(FirstGuessOfChains, changes_its_bend_in_one_place_alone_where_there_are_many_joints) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::vector<double> many = bends(26, seed), few = bends(9, seed);
    int kinks = 0;
    for (std::size_t j = 1; j + 1 < many.size(); ++j) kinks += change_of_slope(many, j) > 1e-12 ? 1 : 0;
    EXPECT_EQ(kinks, 1) << "25 joints, the 13th in the middle";
    for (std::size_t j = 1; j + 1 < few.size(); ++j) EXPECT_GT(change_of_slope(few, j), 1e-3) << "each by itself";
  }
}

TEST(FirstGuessOfChains, bends_the_whole_alike_however_many_links_it_has) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const auto whole = [&](int links) {
      double sum = 0.0;
      for (const double bend : bends(links, seed)) sum += bend;
      return sum;
    };
    EXPECT_NEAR(whole(26), whole(51), 0.1) << seed;
  }
}

}  // namespace
}  // namespace lamprey::tests
