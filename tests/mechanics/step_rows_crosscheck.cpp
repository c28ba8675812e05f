// Derivatives of a forced step along many directions at once against those along one, on random trees with every kind of
// joint.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "mechanics/step_hessian.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Index;
using mechanics::DiscreteLagrangian;
using mechanics::FreedomRows;
using mechanics::Freedoms;
using mechanics::RateKind;

// A step of a random swimmer under random moments, and random directions that turn one of its ends.
struct RowsOfStep {
  static constexpr Index left_count = 8, count = 15;

  RowsOfStep(DiscreteLagrangian lagrangian, int bodies, unsigned seed)
      : random(seed),
        system(swimmer(random, bodies, seed % 2 == 0)),
        control(random_moments(random, system, 5.0)),
        control_next(random_moments(random, system, 5.0)),
        interval(random_interval(random, system, 0.4)),
        step{system, lagrangian, 0.1, interval, control, control_next},
        balance(bodies),
        blocks(n()),
        rates(n()),
        directions(bodies, count),
        jacobian(bodies, count),
        hessian(bodies, count),
        multiplier(system),
        multiplier_rate(bodies) {
    for (Index r = 0; r < count; ++r) {
      FreedomRows& rows = r < left_count ? directions.left : directions.right;
      const Freedoms freedoms = random_freedoms(random, system, 1.0);
      for (std::size_t i = 0; i < n(); ++i) rows[i].row(r) = freedoms[i].transpose();
      if (r >= left_count) directions.displacement.row(r) = random.vector().transpose();
    }
    multiplier.left = random_freedoms(random, system, 1.0);
    multiplier.right = random_freedoms(random, system, 1.0);
    multiplier.displacement = random.vector();
    evaluate_balance(step, balance);
    evaluate_rate(step, balance, multiplier, RateKind::adjoint, multiplier_rate);
    body_rates(step, balance.momenta, blocks, rates);
    rates_at_both_ends(step, balance, blocks, rates, directions, left_count, count, jacobian);
    adjoint_rates(step, balance, blocks, rates, multiplier, multiplier_rate, directions, jacobian, left_count, count,
                  hessian);
  }

  // Without coupling, bodies are taken four at a time.
  static model::SwimmerDescription swimmer(Random& random, int bodies, bool coupled) {
    model::SwimmerDescription result = random_swimmer(random, bodies);
    for (model::BodyDescription& body : result.bodies)
      if (!coupled) body.coupling_matrix.reset();
    return result;
  }

  std::size_t n() const { return model::at(system.body_count()); }

  mechanics::StepVariation direction(Index r) const {
    mechanics::StepVariation d(system);
    for (std::size_t i = 0; i < n(); ++i) {
      d.left[i] = directions.left[i].row(r).transpose();
      d.right[i] = directions.right[i].row(r).transpose();
    }
    d.displacement = directions.displacement.row(r).transpose();
    return d;
  }

  Random random;
  model::System system;
  mechanics::Moments control, control_next;
  mechanics::Interval interval;
  mechanics::ForcedStep step;
  mechanics::StepBalance balance;
  std::vector<mechanics::BodyBlock> blocks;
  std::vector<mechanics::BodyRates> rates;
  mechanics::StepDirections directions;
  mechanics::StepJacobian jacobian;
  mechanics::StepHessian hessian;
  mechanics::StepVariation multiplier;
  mechanics::StepRate multiplier_rate;
};

// Rates along one direction by the scalar road.
struct Scalar {
  Scalar(RowsOfStep& rows, Index r) : direction(rows.direction(r)), rate(rows.system.body_count()) {
    mechanics::SecondRateWorkspace work(rows.system.body_count());
    minus = plus = Freedoms(rows.n());
    evaluate_rate(rows.step, rows.balance, direction, RateKind::tangent, rate);
    evaluate_adjoint_rate(rows.step, rows.balance, rows.multiplier, rows.multiplier_rate, direction, rate, work, minus,
                          plus, linear);
  }
  mechanics::StepVariation direction;
  mechanics::StepRate rate;
  Freedoms minus, plus;
  Vector3d linear;
};

void expect_row(const FreedomRows& rows, Index r, const Freedoms& expected, const std::string& what) {
  double size = 1.0, error = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    size = std::max(size, expected[i].lpNorm<Eigen::Infinity>());
    error = std::max(error, (rows[i].row(r).transpose() - expected[i]).lpNorm<Eigen::Infinity>());
  }
  EXPECT_LE(error, tolerance(1e-12) * size) << what << " of direction " << r;
}

class StepRows : public ::testing::TestWithParam<DiscreteLagrangian> {
 protected:
  template <typename Check>
  void for_swimmers(const Check& check) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(seed);
      RowsOfStep rows(GetParam(), 2 + static_cast<int>(seed) / 2, seed);
      check(rows);
    }
  }
};

TEST_P(StepRows, agree_with_rates_along_one_direction) {
  for_swimmers([](RowsOfStep& rows) {
    for (Index r = 0; r < RowsOfStep::count; ++r) {
      const Scalar scalar(rows, r);
      expect_row(rows.jacobian.minus, r, scalar.rate.minus, "E- rate");
      expect_row(rows.jacobian.plus, r, scalar.rate.plus, "E+ rate");
      expect_row({rows.jacobian.linear}, r, {scalar.rate.linear}, "p_x rate");
    }
  });
}

TEST_P(StepRows, agree_with_second_rates_along_one_direction) {
  for_swimmers([](RowsOfStep& rows) {
    for (Index r = 0; r < RowsOfStep::count; ++r) {
      const Scalar scalar(rows, r);
      expect_row(rows.hessian.minus, r, scalar.minus, "second rate at the left end");
      if (r >= RowsOfStep::left_count) expect_row(rows.hessian.plus, r, scalar.plus, "second rate at the right end");
      expect_row({rows.hessian.linear}, r, {scalar.linear}, "second rate of p_x");
    }
  });
}

// What the rows leave out: second derivatives by both ends do not depend on the order.
TEST_P(StepRows, mixed_second_derivatives_are_symmetric) {
  for_swimmers([](RowsOfStep& rows) {
    for (Index s = 0; s < RowsOfStep::left_count; ++s) {
      const Scalar left(rows, s);
      for (Index t = RowsOfStep::left_count; t < RowsOfStep::count; ++t) {
        const mechanics::StepVariation right = rows.direction(t);
        double one = 0.0, other = left.linear.dot(right.displacement), size = 1.0;
        for (std::size_t i = 0; i < rows.n(); ++i) {
          one += rows.hessian.minus[i].row(t).dot(left.direction.left[i]);
          other += left.plus[i].dot(right.right[i]);
          size += std::abs(left.plus[i].dot(right.right[i]));
        }
        EXPECT_NEAR(one, other, tolerance(1e-12) * size) << s << ", " << t;
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Lagrangians, StepRows,
                         ::testing::Values(DiscreteLagrangian::paper, DiscreteLagrangian::trapezoid,
                                           DiscreteLagrangian::midpoint),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
