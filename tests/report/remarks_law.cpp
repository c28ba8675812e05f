#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "report/sample_results.hpp"
#include "report/summary.hpp"

namespace lamprey {
namespace {

// The message of a failure is one text; people read it in its parts.
TEST(Remarks, tell_failures_in_blocks_and_what_to_try_as_a_list) {
  result::Results results = tests::sample_results(5);
  const maneuver::Failure failure{"Not solved: it is missed.", "The optimiser stopped: no step.", {"more", "less"}};
  results.solution.status = maneuver::Status::stalled;
  results.solution.message = failure.text() + " Since the time limit was reached, no gains were computed.";
  EXPECT_EQ(failure.text(),
            "Not solved: it is missed. The optimiser stopped: no step. What may help: try more, or less.");
  const std::vector<std::string> whole = report::remarks(results).paragraphs;
  ASSERT_EQ(whole.size(), 1U) << "as files of early versions tell it";
  results.failure = failure;
  const report::Remarks told = report::remarks(results);
  ASSERT_EQ(told.paragraphs.size(), 3U);
  EXPECT_EQ(told.paragraphs[0], failure.missed);
  EXPECT_EQ(told.paragraphs[1], failure.cause);
  EXPECT_EQ(told.paragraphs[2], "Since the time limit was reached, no gains were computed.");
  EXPECT_EQ(told.remedies, failure.remedies);
  results.certificate->goal_error = 0.25;
  results.certificate->goal_missed = "goal.move along e₁";
  results.failure.missed = "Not solved: goal.move along e₁ is missed by 0.25 m.";
  results.solution.message = results.failure.text();
  EXPECT_EQ(report::remarks(results).paragraphs, std::vector<std::string>{failure.cause})
      << "the verdict says the rest";
  results.solution.message = "Another one.";
  EXPECT_TRUE(report::remarks(results).remedies.empty());
  EXPECT_EQ(report::remarks(results).paragraphs, std::vector<std::string>{"Another one."});
}

}  // namespace
}  // namespace lamprey
