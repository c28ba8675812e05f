#include <gtest/gtest.h>

#include "integrator/derivative_accuracy.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

class Accuracy : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(Accuracy, of_derivatives_holds_on_8_random_trees) {
  expect_accurate(worst_derivatives(GetParam(), 8, 100 * static_cast<unsigned>(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Schemes, Accuracy, ::testing::ValuesIn(all_schemes), named_by_value);

}  // namespace
}  // namespace lamprey::tests
