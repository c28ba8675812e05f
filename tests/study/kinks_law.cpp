// Costs of work have kinks where powers change their signs, and answers settle on them.
#include <gtest/gtest.h>

#include "file/problem_file.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

// Limits that hold nowhere take no part in an answer; what looks for those that hold leaves the kinks settled.
TEST(Kinks, settle_within_limits_that_hold_nowhere_as_well_as_without) {
  maneuver::Problem within =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/transport_within_wide_limits.toml");
  maneuver::Problem without = within;
  without.limits = maneuver::Limits();
  search::SolveOptions options;
  options.refinement = false;
  const study::Answer far = study::answer(model::System(within.swimmer), within, options),
                      free = study::answer(model::System(without.swimmer), without, options);
  for (const study::Answer* answer : {&far, &free}) {
    EXPECT_EQ(answer->certificate.verdict, certificate::Verdict::proved) << answer->solution.message;
    EXPECT_LE(answer->certificate.kkt, 1e-9);
    EXPECT_EQ(answer->solution.message.find("meets all that is asked, too, but"), std::string::npos)
        << answer->solution.message;
  }
  EXPECT_LT(far.solution.cost, 25.0) << "23.66 where this was written, and 70 before";
}

}  // namespace
}  // namespace lamprey::tests
