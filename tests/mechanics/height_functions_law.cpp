// Height functions: volumes over loops of shapes are what the swimmer moves, in the frame that shapes disturb least.
#include "mechanics/height_functions.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using mechanics::HeightFunctions;
using mechanics::Planar;
using mechanics::Rotations;
using mechanics::ShapePlane;
using model::System;

// A row of three unlike bodies, bent about one of the axes 0, 1, 2 by hinges or, about the parent's axis, by ball joints.
model::SwimmerDescription row_of_three(int normal, bool hinges) {
  model::SwimmerDescription swimmer;
  swimmer.density = 1000.0;
  const std::array<Vector3d, 3> sizes{Vector3d(0.12, 0.03, 0.05), Vector3d(0.15, 0.02, 0.03),
                                      Vector3d(0.09, 0.04, 0.02)};
  const auto turned = [&](const Vector3d& v) {  // e₃ becomes the normal
    Vector3d result;
    for (int k = 0; k < 3; ++k) result[(k + normal + 1) % 3] = v[k];
    return result;
  };
  for (int i = 0; i < 3; ++i) {
    model::BodyDescription body;
    body.name = std::to_string(i);
    body.semi_axes = turned(sizes[static_cast<std::size_t>(i)]);
    swimmer.bodies.push_back(body);
  }
  for (int side : {1, -1}) {
    model::JointDescription joint;
    joint.kind = hinges ? model::JointKind::hinge : model::JointKind::ball;
    joint.parent = "0";
    joint.child = joint.name = side > 0 ? "1" : "2";
    joint.parent_offset = turned(Vector3d(0.13 * side, 0.01, 0));
    joint.child_offset = turned(Vector3d((side > 0 ? -0.16 : 0.1), 0, 0));
    if (hinges) joint.axis = turned(Vector3d::UnitZ());
    swimmer.joints.push_back(joint);
  }
  return swimmer;
}

ShapePlane plane_of(int normal, bool hinges, double reach, int points) {
  ShapePlane plane;
  plane.middle.assign(2, Vector3d::Zero());
  for (std::size_t n = 0; n < 2; ++n) {
    plane.direction[n].assign(2, Vector3d::Zero());
    plane.direction[n][n][hinges ? 0 : normal] = 1.0;
    plane.low[n] = -reach;
    plane.high[n] = reach;
  }
  plane.points = points;
  return plane;
}

struct Planarity {
  int normal;
  bool hinges;
};

class Heights : public testing::TestWithParam<Planarity> {
 protected:
  System system_{row_of_three(GetParam().normal, GetParam().hinges)};

  ShapePlane plane(double reach, int points) const {
    return plane_of(GetParam().normal, GetParam().hinges, reach, points);
  }

  // Rates of the root by the two angles, in its plane.
  Eigen::Matrix<double, 3, 2> rates(double first, double second) const {
    const int n = GetParam().normal;
    Rotations R(3, Matrix3d::Identity());
    R[1] = lie::exp(Vector3d(first * Vector3d::Unit(n)));
    R[2] = lie::exp(Vector3d(second * Vector3d::Unit(n)));
    const mechanics::LocalConnection connection = mechanics::local_connection(system_, R);
    const Eigen::Index second_column = GetParam().hinges ? 1 : 3 + n, first_column = GetParam().hinges ? 0 : n;
    Eigen::Matrix<double, 3, 2> result;
    for (const auto& [to, from] : {std::pair(Eigen::Index{0}, first_column), std::pair(Eigen::Index{1}, second_column)})
      result.col(to) << connection.shift((n + 1) % 3, from), connection.shift((n + 2) % 3, from),
          connection.turn(n, from);
    return result;
  }

  static constexpr int steps = 400;
  static double phase(double step) { return 2.0 * std::numbers::pi * step / steps; }

  static std::array<double, 2> on_circle(double size, double step) {
    return {0.2 + size * std::cos(phase(step)), -0.1 + size * std::sin(phase(step))};
  }
  static std::vector<std::array<double, 2>> circle(double size) {
    std::vector<std::array<double, 2>> loop;
    for (int k = 0; k < steps; ++k) loop.push_back(on_circle(size, k));
    return loop;
  }

  // The root's displacement along a circle of shapes, seen from where it began: [steps + 1].
  std::vector<Planar> displacement_along(double size) const {
    const auto moved = [&](double step, double heading) {  // per step
      const auto [first, second] = on_circle(size, step);
      const Planar v = rates(first, second) * Eigen::Vector2d(-std::sin(phase(step)), std::cos(phase(step))) * size *
                       (2.0 * std::numbers::pi / steps);
      Planar rate;
      rate << Eigen::Rotation2Dd(heading) * v.head<2>(), v[2];
      return rate;
    };
    std::vector<Planar> places{Planar::Zero()};
    for (int k = 0; k < steps; ++k) {
      const Planar& place = places.back();
      const Planar a = moved(k, place[2]), b = moved(k + 0.5, place[2] + 0.5 * a[2]),
                   c = moved(k + 0.5, place[2] + 0.5 * b[2]), d = moved(k + 1, place[2] + c[2]);
      places.emplace_back(place + (a + 2.0 * b + 2.0 * c + d) / 6.0);
    }
    return places;
  }
};
INSTANTIATE_TEST_SUITE_P(
    Planes, Heights, testing::Values(Planarity{2, true}, Planarity{2, false}, Planarity{1, true}, Planarity{0, false}),
    [](const auto& the) {
      return std::string(the.param.hinges ? "hinges" : "balls") + "_about_axis_" + std::to_string(the.param.normal);
    });

// The same heights told in the root's own frame.
HeightFunctions told_by_root(const HeightFunctions& heights) {
  HeightFunctions plain = heights;
  for (Eigen::Index i = 0; i < heights.height[0].rows(); ++i)
    for (Eigen::Index j = 0; j < heights.height[0].cols(); ++j) {
      const double turn = heights.height[2](i, j), x = heights.frame[0](i, j), y = heights.frame[1](i, j);
      const Eigen::Vector2d shift = Eigen::Rotation2Dd(heights.frame[2](i, j)) *
                                    Eigen::Vector2d(heights.height[0](i, j), heights.height[1](i, j));
      plain.height[0](i, j) = shift.x() + turn * y;
      plain.height[1](i, j) = shift.y() - turn * x;
      for (std::size_t k = 0; k < 3; ++k) plain.frame[k](i, j) = 0.0;
    }
  return plain;
}

TEST_P(Heights, are_the_displacement_of_loops) {
  const std::optional<HeightFunctions> heights = mechanics::height_functions(system_, plane(0.8, 81));
  ASSERT_TRUE(heights);
  EXPECT_EQ(heights->normal, GetParam().normal);
  for (const double size : {0.2, 0.4, 0.6}) {
    const std::vector<std::array<double, 2>> loop = circle(size);
    const std::vector<Planar> root = displacement_along(size);
    const auto miss = [&](const HeightFunctions& told) {
      const auto frame = [&](std::size_t k) { return mechanics::frame_at(told, loop[k][0], loop[k][1]); };
      const Planar twist = mechanics::twist_of_frame(frame(0), root.back());
      Planar moved = Planar::Zero();
      for (std::size_t k = 0; k < loop.size(); ++k)
        moved += mechanics::seen_along(twist, mechanics::frame_moved(frame(0), root[k], frame(k))) /
                 static_cast<double>(loop.size());
      return (moved - mechanics::volume_over(told, loop)).norm() / moved.norm();
    };
    EXPECT_LE(miss(*heights), 2e-4) << size;
    EXPECT_GE(miss(told_by_root(*heights)), 10.0 * miss(*heights)) << size;
  }
}

// Begun at another shape the same loop has the same twist, seen from there.
TEST_P(Heights, have_one_twist_wherever_the_loop_begins) {
  const std::optional<HeightFunctions> heights = mechanics::height_functions(system_, plane(0.8, 21));
  ASSERT_TRUE(heights);
  const std::vector<std::array<double, 2>> loop = circle(0.5);
  const std::vector<Planar> root = displacement_along(0.5);
  const auto frame = [&](std::size_t k) { return mechanics::frame_at(*heights, loop[k][0], loop[k][1]); };
  const std::size_t later = 130;
  // once round from there: the rest of the loop, then its beginning
  const Eigen::Rotation2Dd back(-root[later][2]), whole(root.back()[2]);
  const Eigen::Vector2d ahead = root.back().head<2>() + whole * root[later].head<2>();
  Planar round;
  round << back * (ahead - root[later].head<2>()), root.back()[2];
  const Planar direct = mechanics::twist_of_frame(frame(later), round);
  const Planar seen = mechanics::seen_along(mechanics::twist_of_frame(frame(0), root.back()),
                                            mechanics::frame_moved(frame(0), root[later], frame(later)));
  EXPECT_LE((direct - seen).norm(), 1e-12 * direct.norm());
}

// In a vacuum the mass centre stays where it is: the frame is there, and nothing moves it.
TEST(HeightsOf, a_swimmer_in_a_vacuum_are_those_of_its_mass_centre) {
  model::SwimmerDescription swimmer = row_of_three(2, true);
  swimmer.density = 0.0;
  for (std::size_t i = 0; i < 3; ++i) swimmer.bodies[i].mass = 1.0 + 0.5 * static_cast<double>(i);
  const System system(swimmer);
  for (const double reach : {0.05, 0.8}) {
    ShapePlane plane = plane_of(2, true, reach, 31);
    plane.middle[0][0] = 0.8;
    plane.middle[1][0] = -0.3;
    const std::optional<HeightFunctions> heights = mechanics::height_functions(system, plane);
    ASSERT_TRUE(heights);
    EXPECT_GT(heights->height[2].cwiseAbs().maxCoeff(), 0.01);
    for (std::size_t k : {std::size_t{0}, std::size_t{1}})
      EXPECT_LE(heights->height[k].cwiseAbs().maxCoeff(), 1e-7 + 3e-6 * reach) << reach;  // m, by the grid
    const double first = 0.8, second = -0.3;  // amid the rectangle: node 15, 15
    const auto arm = [](double angle, double length) {
      return Eigen::Vector2d(length * std::cos(angle), length * std::sin(angle));
    };
    const Eigen::Vector2d centre = (1.5 * (Eigen::Vector2d(0.13, 0.01) + arm(first, 0.16)) +
                                    2.0 * (Eigen::Vector2d(-0.13, 0.01) - arm(second, 0.1))) /
                                   4.5;
    EXPECT_NEAR(heights->frame[0](15, 15), centre.x(), 1e-4);
    EXPECT_NEAR(heights->frame[1](15, 15), centre.y(), 1e-4);
  }
}

// Other variables for the same shapes have other heights over the same loops: by the parallelogram of their directions.
TEST_P(Heights, change_with_their_variables_by_the_area_that_these_span) {
  const int axis = GetParam().hinges ? 0 : GetParam().normal;
  ShapePlane plain = plane(0.6, 5);
  plain.middle[0][axis] = 0.3;
  plain.middle[1][axis] = -0.15;
  ShapePlane skew = plain;
  skew.direction[0][1][axis] = 0.5;   // (1, ½)
  skew.direction[1][0][axis] = -1.0;  // (−1, 1)
  for (std::size_t n = 0; n < 2; ++n) {
    skew.low[n] = n == 0 ? -0.2 : -0.4;
    skew.high[n] = -skew.low[n];
  }
  const auto heights = mechanics::height_functions(system_, plain), seen = mechanics::height_functions(system_, skew);
  ASSERT_TRUE(heights && seen);
  EXPECT_GT(std::abs(heights->height[2](2, 2)), 1e-4);
  EXPECT_NEAR(seen->height[2](2, 2), 1.5 * heights->height[2](2, 2), 1e-12);  // of the same shape, amid both
}

// Volumes are counted by how often and in which sense the loop goes round.
TEST_P(Heights, are_summed_over_what_a_loop_goes_round) {
  const std::optional<HeightFunctions> heights = mechanics::height_functions(system_, plane(1.0, 9));
  ASSERT_TRUE(heights);
  HeightFunctions flat = *heights;
  for (std::size_t k = 0; k < 3; ++k) {  // 1 + 2 r₁ + 3 r₂, which is linear
    for (Eigen::Index i = 0; i < 9; ++i)
      for (Eigen::Index j = 0; j < 9; ++j)
        flat.height[k](i, j) =
            1.0 + 2.0 * flat.at[0][static_cast<std::size_t>(i)] + 3.0 * flat.at[1][static_cast<std::size_t>(j)];
  }
  std::vector<std::array<double, 2>> once, twice, back;
  constexpr int corners = 2000;
  for (int k = 0; k < 2 * corners; ++k) {
    const double s = 2.0 * std::numbers::pi * k / corners;
    const std::array<double, 2> corner{0.3 + 0.5 * std::cos(s), -0.2 + 0.4 * std::sin(s)};
    twice.push_back(corner);
    if (k < corners) once.push_back(corner);
  }
  back.assign(once.rbegin(), once.rend());
  const double expected = std::numbers::pi * 0.5 * 0.4 * (1.0 + 2.0 * 0.3 - 3.0 * 0.2);
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(mechanics::volume_over(flat, once)[k], expected, 1e-5);
    EXPECT_NEAR(mechanics::volume_over(flat, twice)[k], 2.0 * expected, 2e-5);
    EXPECT_NEAR(mechanics::volume_over(flat, back)[k], -expected, 1e-5);
  }
}

// The squares of the rates that are left, halfway between the nodes; along the rectangle's boundary half of them, as an integral over it
// has them.
double disturbance(const HeightFunctions& heights,
                   const std::function<Eigen::Matrix<double, 3, 2>(double, double)>& rates, bool turn) {
  double sum = 0.0;
  const auto n = heights.height[0].rows();
  const auto at_node = [&](Eigen::Index i, Eigen::Index j) {
    return Planar(heights.frame[0](i, j), heights.frame[1](i, j), heights.frame[2](i, j));
  };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index angle : {0, 1}) {
        const Eigen::Index to_i = i + (angle == 0 ? 1 : 0), to_j = j + (angle == 1 ? 1 : 0);
        if (to_i >= n || to_j >= n) continue;
        const auto middle = [](const std::vector<double>& angles, Eigen::Index a, Eigen::Index b) {
          return 0.5 * (angles[static_cast<std::size_t>(a)] + angles[static_cast<std::size_t>(b)]);
        };
        const Planar rate = rates(middle(heights.at[0], i, to_i), middle(heights.at[1], j, to_j)).col(angle);
        const std::vector<double>& changed = heights.at[static_cast<std::size_t>(angle)];
        const Planar change = (at_node(to_i, to_j) - at_node(i, j)) / (changed[1] - changed[0]);
        const Planar mean = 0.5 * (at_node(i, j) + at_node(to_i, to_j));
        const Eigen::Vector2d shift = rate.head<2>() + rate[2] * Eigen::Vector2d(-mean[1], mean[0]) + change.head<2>();
        const Eigen::Index beside = angle == 0 ? j : i;
        const double share = beside == 0 || beside + 1 == n ? 0.5 : 1.0;
        sum += share * (turn ? std::pow(rate[2] + change[2], 2) : shift.squaredNorm());
      }
  return sum;
}

TEST_P(Heights, are_told_in_the_frame_that_shapes_disturb_least) {
  const std::optional<HeightFunctions> heights = mechanics::height_functions(system_, plane(0.8, 7));
  ASSERT_TRUE(heights);
  const auto by = [&](double first, double second) { return rates(first, second); };
  Random random(7);
  for (const bool turn : {true, false}) {
    HeightFunctions root = *heights;
    for (Eigen::MatrixXd& part : root.frame) part.setZero();
    const double least = disturbance(*heights, by, turn);
    EXPECT_LT(least, 0.5 * disturbance(root, by, turn));
    for (int n = 0; n < 20; ++n) {
      HeightFunctions other = *heights, opposite = *heights;
      for (std::size_t k : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
        if (turn != (k == 2)) continue;
        const Eigen::MatrixXd change = Eigen::MatrixXd::NullaryExpr(7, 7, [&] { return 1e-3 * random.normal(); });
        other.frame[k] += change;
        opposite.frame[k] -= change;
      }
      const double up = disturbance(other, by, turn) - least, down = disturbance(opposite, by, turn) - least;
      EXPECT_GT(up, 0.0);
      EXPECT_LE(std::abs(up - down), 1e-6 * up);  // stationary, not merely lower
    }
  }
}

// What the frame moves by across the first side of the rectangle, at a node of the other variable, told from the two half steps next to it.
Planar across_the_side(const HeightFunctions& heights,
                       const std::function<Eigen::Matrix<double, 3, 2>(double, double)>& rates, Eigen::Index j) {
  const auto at_node = [&](Eigen::Index i) {
    return Planar(heights.frame[0](i, j), heights.frame[1](i, j), heights.frame[2](i, j));
  };
  const auto half_way = [&](Eigen::Index i) {
    const double first = heights.at[0][static_cast<std::size_t>(i)],
                 next = heights.at[0][static_cast<std::size_t>(i + 1)];
    const Planar rate = rates(0.5 * (first + next), heights.at[1][static_cast<std::size_t>(j)]).col(0);
    const Planar change = (at_node(i + 1) - at_node(i)) / (next - first), mean = 0.5 * (at_node(i) + at_node(i + 1));
    return Planar(Planar(rate[0] - rate[2] * mean[1], rate[1] + rate[2] * mean[0], rate[2]) + change);
  };
  return 1.5 * half_way(0) - 0.5 * half_way(1);
}

// Of the least squares over the rectangle: on finer grids heights and frames come near to those of an integral at second order, and
// nothing moves the frame across the rectangle's sides.
TEST_P(Heights, come_near_to_those_of_an_integral_at_second_order) {
  const std::array<int, 3> points{31, 61, 121};
  std::array<HeightFunctions, 3> told;
  for (std::size_t n = 0; n < 3; ++n) {
    ShapePlane rectangle = plane(0.8, points[n]);
    rectangle.high = {1.1, 0.6};  // unlike sides
    const std::optional<HeightFunctions> heights = mechanics::height_functions(system_, rectangle);
    ASSERT_TRUE(heights);
    told[n] = *heights;
  }
  const auto apart = [&](std::size_t n, std::array<Eigen::MatrixXd, 3> HeightFunctions::*part, std::size_t k) {
    double square = 0.0;  // on the average, for next to the corners there is a logarithm, too
    for (Eigen::Index i = 0; i < points[n]; ++i)
      for (Eigen::Index j = 0; j < points[n]; ++j)
        square += std::pow((told[n].*part)[k](i, j) - (told[n + 1].*part)[k](2 * i, 2 * j), 2);
    return std::sqrt(square) / points[n];
  };
  for (const auto part : {&HeightFunctions::height, &HeightFunctions::frame})
    for (std::size_t k = 0; k < 3; ++k) {
      if (part == &HeightFunctions::height && k == 2) continue;  // the same in all frames
      const double coarse = apart(0, part, k), fine = apart(1, part, k);
      EXPECT_GT(fine, 1e-9);
      EXPECT_GT(std::log2(coarse / fine), 1.8) << k << ": " << coarse << ' ' << fine;
    }
  const auto by = [&](double first, double second) { return rates(first, second); };
  std::array<double, 3> across{}, along{};
  for (std::size_t n = 0; n < 3; ++n) {
    const Eigen::Index from = (points[n] - 1) / 6;
    for (Eigen::Index j = from; j < points[n] - from; j += from) {
      across[n] = std::max(across[n], across_the_side(told[n], by, j).norm());
      along[n] = std::max(along[n], rates(-0.8, told[n].at[1][static_cast<std::size_t>(j)]).col(0).norm());
    }
  }
  EXPECT_LE(across[2], 1e-3 * along[2]);
  EXPECT_GT(std::log2(across[1] / across[2]), 1.7) << across[0] << ' ' << across[1] << ' ' << across[2];
}

TEST(HeightsOf, swimmers_that_leave_the_plane_are_none) {
  Random random(3);
  const System system(random_swimmer(random, 3));
  ShapePlane plane = plane_of(2, true, 0.5, 5);
  EXPECT_FALSE(mechanics::height_functions(system, plane));
  const System balls(row_of_three(2, false));
  plane = plane_of(2, false, 0.5, 5);
  EXPECT_TRUE(mechanics::height_functions(balls, plane));
  plane.direction[1][1] = Vector3d(0, 0.1, 1);  // about an axis that turns
  EXPECT_FALSE(mechanics::height_functions(balls, plane));
}

}  // namespace
}  // namespace lamprey::tests
