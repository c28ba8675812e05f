// The eel's gait by Ipopt: minutes in a sparse factorisation that knows nothing of time.
#include "back_ends.hpp"

namespace lamprey::tests {
namespace {

class BackEndsOfTheEel : public BackEnds {};

TEST_P(BackEndsOfTheEel, stay_at_the_minima_of_ipopt) { expect_newton_to_stay_where_ipopt_arrives(); }

INSTANTIATE_TEST_SUITE_P(Examples, BackEndsOfTheEel, testing::Values("eel_gait"));

}  // namespace
}  // namespace lamprey::tests
