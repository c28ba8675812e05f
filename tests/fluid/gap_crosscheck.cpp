#include "fluid/gap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lie/so3.hpp"
#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

EllipsoidPair random_pair(std::mt19937_64& generator, double aspect, double reach) {
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  const auto vector = [&] { return Vector3d(entry(generator), entry(generator), entry(generator)); };
  const auto axes = [&] { return vector().unaryExpr([&](double x) { return std::pow(aspect, 0.5 * x); }).eval(); };
  EllipsoidPair pair{axes(), axes(), lie::exp(3.0 * vector()), lie::exp(3.0 * vector()), {}};
  pair.offset = reach * (pair.semi_axes_1.maxCoeff() + pair.semi_axes_2.maxCoeff()) * vector();
  return pair;
}

// The definition, written out.
double separation(const EllipsoidPair& pair, const Vector3d& n) {
  return n.dot(pair.offset) - pair.semi_axes_1.cwiseProduct(pair.rotation_1.transpose() * n).norm() -
         pair.semi_axes_2.cwiseProduct(pair.rotation_2.transpose() * n).norm();
}

// Every direction of a grid, then ever smaller steps from the best of them: no derivative, no start chosen by thought.
double by_dense_search(const EllipsoidPair& pair) {
  struct Found {
    double value;
    Vector3d n;
  };
  std::vector<Found> grid;
  for (int i = 0; i < 60; ++i) {
    for (int k = 0; k < 120; ++k) {
      const double polar = std::numbers::pi * (i + 0.5) / 60.0;
      const double azimuth = std::numbers::pi * k / 60.0;
      const Vector3d n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
      grid.push_back({separation(pair, n), n});
    }
  }
  std::partial_sort(grid.begin(), grid.begin() + 20, grid.end(),
                    [](const Found& a, const Found& b) { return a.value > b.value; });
  double best = -INFINITY;
  for (int start = 0; start < 20; ++start) {
    Found here = grid[static_cast<std::size_t>(start)];
    for (double step = 0.05; step > 1e-9;) {
      const Vector3d side = here.n.unitOrthogonal();
      const Vector3d across = here.n.cross(side);
      Found there = here;
      for (int k = 0; k < 8; ++k) {
        const double angle = 0.25 * std::numbers::pi * k;
        const Vector3d n = (here.n + step * (std::cos(angle) * side + std::sin(angle) * across)).normalized();
        const double value = separation(pair, n);
        if (value > there.value) there = {value, n};
      }
      if (there.value > here.value) {
        here = there;
      } else {
        step *= 0.5;
      }
    }
    best = std::max(best, here.value);
  }
  return best;
}

// Point of a solid ellipsoid about the origin nearest to p outside it: x = A (A + τ I)⁻¹ p, by halving in τ.
Vector3d nearest(const Vector3d& semi_axes, const Matrix3d& R, const Vector3d& p) {
  const Vector3d local = R.transpose() * p;
  const Vector3d squares = semi_axes.cwiseAbs2();
  if (local.cwiseQuotient(semi_axes).norm() <= 1.0) return p;
  double lower = 0.0, upper = semi_axes.maxCoeff() * local.norm();
  Vector3d x;
  for (int n = 0; n < 70; ++n) {
    const double tau = 0.5 * (lower + upper);
    x = squares.cwiseProduct(local).cwiseQuotient(squares + Vector3d::Constant(tau));
    (x.cwiseQuotient(semi_axes).norm() > 1.0 ? lower : upper) = tau;
  }
  return R * x;
}

}  // namespace

TEST(GapCrosscheck, a_dense_search_of_all_directions_finds_the_same) {
  std::mt19937_64 generator(31);
  int overlapping = 0;
  for (const double aspect : {4.0, 30.0}) {
    for (int n = 0; n < 60; ++n) {
      const EllipsoidPair pair = random_pair(generator, aspect, n % 3 == 0 ? 0.1 : 0.6);
      const double value = gap(pair).value;
      const double size = pair.offset.norm() + pair.semi_axes_1.maxCoeff() + pair.semi_axes_2.maxCoeff();
      EXPECT_NEAR(value, by_dense_search(pair), tests::tolerance(1e-10 * size));
      overlapping += value < 0.0;
    }
  }
  EXPECT_GT(overlapping, 30);
  EXPECT_LT(overlapping, 110);
}

TEST(GapCrosscheck, nearest_points_found_by_turns_on_either_body_are_as_far_apart) {
  std::mt19937_64 generator(32);
  int apart = 0;
  for (int n = 0; n < 100; ++n) {
    const EllipsoidPair pair = random_pair(generator, 4.0, 1.0);
    const Gap result = gap(pair);
    if (result.value < 0.05) continue;
    ++apart;
    Vector3d on_1 = Vector3d::Zero(), on_2 = pair.offset;
    for (int turn = 0; turn < 300; ++turn) {
      on_1 = nearest(pair.semi_axes_1, pair.rotation_1, on_2);
      on_2 = pair.offset + nearest(pair.semi_axes_2, pair.rotation_2, on_1 - pair.offset);
    }
    EXPECT_NEAR((on_2 - on_1).norm(), result.value, tests::tolerance(1e-9));
    EXPECT_LT((on_1 - result.point_1).norm(), tests::tolerance(1e-4));
    EXPECT_LT((on_2 - pair.offset - result.point_2).norm(), tests::tolerance(1e-4));
  }
  EXPECT_GT(apart, 30);
}

}  // namespace lamprey::fluid
