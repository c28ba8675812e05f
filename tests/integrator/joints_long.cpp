#include <gtest/gtest.h>

#include "integrator/joints_stay.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

class JointsLong : public ::testing::TestWithParam<integrator::Scheme> {};

TEST_P(JointsLong, joints_stay_joints_for_100000_stages) { expect_joints_stay(GetParam(), 100'000); }

INSTANTIATE_TEST_SUITE_P(Schemes, JointsLong, ::testing::ValuesIn(all_schemes), named_by_value);

}  // namespace
}  // namespace lamprey::tests
