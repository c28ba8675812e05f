// Costs on three grids: when they make an error bar, and what is said when they do not.
#include <cmath>

#include <gtest/gtest.h>

#include "study/refinement.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using tests::tolerance;

// Costs 100 + c h^p on 100, 200 and 400 steps.
std::vector<certificate::GridCost> costs_of_order(double order, double coarsest) {
  return {{100, 100.0 + coarsest},
          {200, 100.0 + coarsest * std::exp2(-order)},
          {400, 100.0 + coarsest * std::exp2(-2.0 * order)}};
}

TEST(Refinement, extrapolates_costs_that_converge_at_the_order_of_their_scheme) {
  for (int order : {1, 2, 4, 6}) {
    const certificate::Refinement found = study::refinement_of(costs_of_order(order, 1.0), 200, order);
    EXPECT_NEAR(found.observed_order, order, tolerance(1e-6));
    EXPECT_NEAR(found.cost_limit, 100.0, tolerance(1e-9));
    EXPECT_NEAR(found.cost_error, std::exp2(-order), tolerance(1e-9));
    EXPECT_EQ(study::refinement_words(found), "");
  }
  EXPECT_EQ(study::refinement_words(study::refinement_of(costs_of_order(1.0, 6.0), 200, 1)),
            " The error of the cost, 3, is 3 % of it: more steps make it smaller.");
}

// As of `paper`, where a motion that runs backwards alike hides the odd powers of the step.
TEST(Refinement, is_too_wide_rather_than_too_narrow_where_costs_converge_faster) {
  const certificate::Refinement found = study::refinement_of(costs_of_order(2.0, 3.0), 200, 1);
  EXPECT_NEAR(found.observed_order, 2.0, tolerance(1e-9));
  EXPECT_GE(found.cost_error, std::abs(found.grids[1].cost - 100.0));
}

// Where the half grid does not arrive the one of four times as many steps takes its place.
TEST(Refinement, takes_finer_grids_where_the_coarser_one_does_not_arrive) {
  maneuver::Problem problem;
  problem.steps = 200;
  const auto costs = [](int least) {
    return
        [least](int steps) { return steps < least ? std::nullopt : std::optional(100.0 + std::pow(100.0 / steps, 2)); };
  };
  for (const auto& [least, grids] :
       {std::pair(0, std::vector{100, 200, 400}), std::pair(150, std::vector{200, 400, 800})}) {
    const certificate::Refinement found = study::refine_cost(problem, 100.25, costs(least));
    ASSERT_EQ(found.grids.size(), 3U);
    for (std::size_t n = 0; n < 3; ++n) EXPECT_EQ(found.grids[n].steps, grids[n]);
    EXPECT_NEAR(found.cost_limit, 100.0, tolerance(1e-9));
  }
  EXPECT_EQ(study::refine_cost(problem, 100.25, costs(1000)).grids.size(), 1U);
}

TEST(Refinement, says_how_far_costs_agree_that_change_unevenly) {
  const certificate::Refinement near = study::refinement_of({{100, 480.0}, {200, 479.0}, {400, 479.5}}, 200, 2);
  EXPECT_TRUE(std::isnan(near.cost_error));
  EXPECT_EQ(study::refinement_words(near),
            " Other grids have the cost to 0.21 %: 480 with 100 steps, 479 with 200 steps, 479.5 with 400 steps; it "
            "changes too unevenly for an error bar.");
  const certificate::Refinement far = study::refinement_of({{100, 480.0}, {200, 400.0}, {400, 479.5}}, 200, 2);
  EXPECT_NE(study::refinement_words(far).find("has not settled"), std::string::npos);
  EXPECT_FALSE(far.grows() || near.grows());
  const certificate::Refinement grows = study::refinement_of({{100, 2.4}, {200, 6.9}, {400, 21.2}}, 200, 2);
  EXPECT_TRUE(grows.grows());
  EXPECT_NE(study::refinement_words(grows).find("The cost grows on finer grids: 2.4 with 100 steps"),
            std::string::npos);
}

}  // namespace
}  // namespace lamprey
