#include "maneuver/end_rows.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "difference_order.hpp"

namespace lamprey::tests {
namespace {

using Eigen::VectorXd;
using maneuver::EndRow;

enum class AskedEnd { all, but_the_root, joints };

class EndRows : public ::testing::TestWithParam<AskedEnd> {};

// Far from the goal, where the logarithm's tangent is not the identity.
TEST_P(EndRows, derivatives_match_central_differences_far_from_the_goal) {
  for (unsigned seed : {1U, 2U, 3U}) {
    Random random(seed);
    const model::System system(random_swimmer(random, 6));
    const mechanics::Rotations R = random_rotations(random, system);
    const mechanics::Rotations asked = random_rotations(random, system);
    const Vector3d position = random.vector();
    maneuver::Maneuver maneuver;
    for (const Matrix3d& rotation : asked) maneuver.end_rotation.emplace_back(rotation);
    if (GetParam() == AskedEnd::but_the_root) maneuver.end_rotation[0].reset();
    if (GetParam() == AskedEnd::joints) {
      maneuver.end_rotation.assign(asked.size(), std::nullopt);
      for (const model::Joint& joint : system.joints())
        maneuver.end_joint.emplace_back(mechanics::child_to_parent(asked, joint));
    }
    maneuver.end_position = {0.5, std::nullopt, -0.25};
    const std::vector<EndRow> rows = maneuver::stated_end_rows(system, maneuver, {});
    const auto count = static_cast<Eigen::Index>(rows.size());
    const int shape = maneuver::shape_size(system);
    mechanics::Freedoms turn = random_freedoms(random, system, 0.5);
    turn[0].setZero();
    VectorXd direction(shape + 6);
    for (int i = 1; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f)
        direction[maneuver::shape_offset(system.body(i)) + f] = turn[static_cast<std::size_t>(i)][f];
    direction.segment<3>(shape) = random.vector(0.5);
    direction.tail<3>() = random.vector();
    Eigen::RowVectorXd derivative(shape + 6);
    VectorXd rates(count);
    for (Eigen::Index r = 0; r < count; ++r) {
      end_row(system, maneuver, rows[static_cast<std::size_t>(r)], R, position, derivative);
      rates[r] = derivative.dot(direction);
    }
    const auto values = [&](double t) {
      mechanics::Freedoms moved = turn;
      for (Vector3d& v : moved) v *= t;
      mechanics::Rotations there = turned(system, R, moved);
      for (Matrix3d& rotation : there) rotation = lie::exp(t * direction.segment<3>(shape)) * rotation;
      VectorXd value(count);
      for (Eigen::Index r = 0; r < count; ++r)
        value[r] = end_row(system, maneuver, rows[static_cast<std::size_t>(r)], there,
                           position + t * direction.tail<3>(), derivative);
      return value;
    };
    expect_second_order_differences(values, rates);
  }
}

INSTANTIATE_TEST_SUITE_P(Of, EndRows, ::testing::Values(AskedEnd::all, AskedEnd::but_the_root, AskedEnd::joints),
                         [](const auto& instance) {
                           const bool all = instance.param == AskedEnd::all;
                           return all                                  ? "bodies"
                                  : instance.param == AskedEnd::joints ? "joints"
                                                                       : "bodies_but_the_root";
                         });

}  // namespace
}  // namespace lamprey::tests
