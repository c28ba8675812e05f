#include <gtest/gtest.h>

#include "integrator/derivative_accuracy.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

class AccuracyLong : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(AccuracyLong, of_derivatives_holds_on_200_random_trees) {
  expect_accurate(worst_derivatives(GetParam(), 200, 1000 * (1 + static_cast<unsigned>(GetParam()))));
}

INSTANTIATE_TEST_SUITE_P(Schemes, AccuracyLong, ::testing::ValuesIn(all_schemes), named_by_value);

}  // namespace
}  // namespace lamprey::tests
