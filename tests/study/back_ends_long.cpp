// The eel's gait by Ipopt: minutes in a sparse factorisation that knows nothing of time.
#include "back_ends.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

class BackEndsOfTheEel : public BackEnds {};

TEST_P(BackEndsOfTheEel, stay_at_the_minima_of_ipopt) { expect_newton_to_stay_where_ipopt_arrives(); }

// On steps of which a search tells minima apart, where there are hundreds of them.
TEST(BackEndsInALargeCatalogue, have_their_minima_in_space) {
  struct InSpace : BackEndsOn {
    InSpace() : BackEndsOn("translation_in_space", 100) {}
    using BackEndsOn::expect_minima_of_both_in_the_catalogue;
  };
  InSpace().expect_minima_of_both_in_the_catalogue(1000);
}

INSTANTIATE_TEST_SUITE_P(Examples, BackEndsOfTheEel, testing::Values("eel_gait"), named_by_value);

}  // namespace
}  // namespace lamprey::tests
