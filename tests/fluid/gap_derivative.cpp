#include "fluid/gap.hpp"

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "difference_order.hpp"
#include "lie/so3.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Case {
  const char* name;
  EllipsoidPair pair;
  double step;
};

const Matrix3d turn_1 = lie::exp(Vector3d(0.3, -0.8, 1.2));
const Matrix3d turn_2 = lie::exp(Vector3d(-1.0, 0.4, 0.6));

const std::vector<Case> cases{
    {"apart", {{2.0, 0.7, 1.1}, {0.5, 1.9, 0.8}, turn_1, turn_2, {2.5, -2.1, 1.9}}, 0.02},
    {"nearly touching", {{2.0, 0.7, 1.1}, {0.5, 1.9, 0.8}, turn_1, turn_2, {1.6, -1.2, 0.8}}, 0.02},
    {"overlapping", {{2.0, 0.7, 1.1}, {0.5, 1.9, 0.8}, turn_1, turn_2, {0.6, -0.7, 0.4}}, 0.01},
    {"one inside the other", {{2.0, 0.9, 1.4}, {0.2, 0.15, 0.1}, turn_1, turn_2, {0.2, 0.1, -0.1}}, 0.01},
    {"needle and disc", {{3.0, 0.1, 0.15}, {2.0, 1.7, 0.1}, turn_1, turn_2, {1.5, 2.0, 1.0}}, 0.002},
    {"far", {{2.0, 0.7, 1.1}, {0.5, 1.9, 0.8}, turn_1, turn_2, {20.0, -10.0, 5.0}}, 0.05},
};

EllipsoidPair moved(const EllipsoidPair& pair, const Vector9d& d) {
  return {pair.semi_axes_1, pair.semi_axes_2, pair.rotation_1 * lie::exp(d.segment<3>(0)),
          pair.rotation_2 * lie::exp(d.segment<3>(3)), pair.offset + d.segment<3>(6)};
}

std::vector<Vector9d> directions() {
  std::vector<Vector9d> result;
  for (int i = 0; i < 9; ++i) result.push_back(Vector9d::Unit(i));
  std::mt19937_64 generator(21);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  result.push_back(Vector9d::NullaryExpr([&] { return entry(generator); }));
  return result;
}

}  // namespace

TEST(GapDerivative, gradient_matches_central_differences_at_second_order) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Gap here = gap(c.pair);
    Vector9d gradient;
    Matrix9d hessian;
    gap_derivatives(c.pair, here, gradient, hessian);
    for (const Vector9d& direction : directions()) {
      const auto value = [&](double t) -> Eigen::VectorXd {
        return Eigen::VectorXd::Constant(1, gap(moved(c.pair, t * direction), here.direction).value);
      };
      const double slope = gradient.dot(direction);
      ASSERT_GT(std::abs(slope), 1e-5) << direction.transpose();
      const double lost = 1e-13 * c.pair.offset.norm() / std::abs(slope) / c.step;  // to round-off of the value
      tests::expect_second_order_differences(value, Eigen::VectorXd::Constant(1, slope), 1e-9 + 10.0 * lost, c.step);
    }
  }
}

// d²/dε dδ of f(R exp(ε a + δ b)) at 0 is d/dε of the gradient at R exp(ε a), taken along exp_tangent(ε a) b.
TEST(GapDerivative, hessian_along_exponentials_matches_differences_of_the_gradient_at_second_order) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Gap here = gap(c.pair);
    Vector9d gradient;
    Matrix9d hessian;
    gap_derivatives(c.pair, here, gradient, hessian);
    EXPECT_LT((hessian - hessian.transpose()).norm(), tests::tolerance(1e-14) * hessian.norm());
    for (const Vector9d& direction : directions()) {
      const auto pulled = [&](double t) -> Eigen::VectorXd {
        const EllipsoidPair there = moved(c.pair, t * direction);
        Vector9d by_there;
        Matrix9d ignored;
        gap_derivatives(there, gap(there, here.direction), by_there, ignored);
        for (const int at : {0, 3})
          by_there.segment<3>(at) =
              lie::exp_tangent(t * direction.segment<3>(at)).transpose() * by_there.segment<3>(at).eval();
        return by_there;
      };
      tests::expect_second_order_differences(pulled, hessian * direction, 1e-8, c.step);
    }
  }
}

TEST(GapDerivative, hessian_matches_second_differences_of_the_gap_itself) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const Gap here = gap(c.pair);
    Vector9d gradient;
    Matrix9d hessian;
    gap_derivatives(c.pair, here, gradient, hessian);
    const Vector9d direction = directions().back();
    const double curvature = direction.dot(hessian * direction);
    ASSERT_GT(std::abs(curvature), 1e-3);
    const auto quotient = [&](double t) {
      const double ahead = gap(moved(c.pair, t * direction), here.direction).value;
      const double behind = gap(moved(c.pair, -t * direction), here.direction).value;
      return (ahead - 2.0 * here.value + behind) / (t * t);
    };
    const double coarse = quotient(c.step) - curvature;
    const double fine = quotient(c.step / 2.0) - curvature;
    EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.3) << coarse << ", " << fine << " of " << curvature;
    const double extrapolated = (4.0 * quotient(c.step / 2.0) - quotient(c.step)) / 3.0;
    EXPECT_NEAR(extrapolated / curvature, 1.0, tests::tolerance(1e-3));
  }
}

// Turning both bodies and the offset, or shifting both, changes nothing.
TEST(GapDerivative, gradient_and_hessian_vanish_along_rigid_turns) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Vector9d gradient;
    Matrix9d hessian;
    gap_derivatives(c.pair, gap(c.pair), gradient, hessian);
    Eigen::Matrix<double, 9, 3> rigid;
    rigid << c.pair.rotation_1.transpose(), c.pair.rotation_2.transpose(), -lie::hat(c.pair.offset);
    EXPECT_LT((rigid.transpose() * gradient).norm(), tests::tolerance(1e-13 * c.pair.offset.norm()));
    // along exp(ε ŵ) of the whole the offset's path bends: offset + ε w × c + ½ ε² w × (w × c)
    const Matrix3d bend = lie::double_cross(gradient.tail<3>(), c.pair.offset);
    EXPECT_LT((rigid.transpose() * hessian * rigid + bend).norm(),
              tests::tolerance(1e-12 * c.pair.offset.squaredNorm() * hessian.norm()));
  }
}

}  // namespace lamprey::fluid
