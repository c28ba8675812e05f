// Lamprey's own solver and Ipopt on the full transcription: on the examples each stays at the other's minima.
#include "back_ends.hpp"
#include "printed.hpp"

namespace lamprey::tests {
namespace {

using search::Found;

TEST_P(BackEnds, stay_at_the_minima_of_newtons_method) {
  const Found by_newton = newton_->solve_starts(0, 1).front();
  ASSERT_TRUE(by_newton.converged()) << by_newton.outcome.reason;
  EXPECT_LT(certified(by_newton).kkt, 1e-8);
  expect_to_stay(*ipopt_, by_newton);
}

// But of the yaw, where Ipopt does not arrive from first guesses of few steps, and of the eel, where it takes minutes.
class BackEndsFromFirstGuesses : public BackEnds {};

TEST_P(BackEndsFromFirstGuesses, stay_at_the_minima_of_ipopt) { expect_newton_to_stay_where_ipopt_arrives(); }

struct Catalogue {
  const char* name;
  int starts;
};

class BackEndsInTheCatalogue : public testing::TestWithParam<Catalogue>, protected BackEndsOn {
 protected:
  BackEndsInTheCatalogue() : BackEndsOn(GetParam().name, 40) {}
};

TEST_P(BackEndsInTheCatalogue, have_their_minima) { expect_minima_of_both_in_the_catalogue(GetParam().starts); }

// From the same first guesses, where there are too many minima to meet those of both by chance.
class BackEndsTogether : public BackEnds {};

TEST_P(BackEndsTogether, lay_their_minima_into_one_catalogue) {
  const Found by_newton = newton_->solve_starts(0, 1).front();
  ASSERT_TRUE(by_newton.converged()) << by_newton.outcome.reason;
  EXPECT_LT(certified(by_newton).kkt, 1e-8);
  Found by_ipopt;
  certificate::Certificate proof;
  ASSERT_NO_FATAL_FAILURE(arrive_by_ipopt(by_ipopt, proof));
  problem_.search.starts = tried_;
  options_.solver = search::Backend::both;
  options_.workers = 2;
  const maneuver::SearchRecord record = search::solve(system_, problem_, options_).front().search;
  EXPECT_EQ(record.starts, 2 * tried_);
  const auto counted = [&](double cost) {
    const auto found = std::find_if(record.minima.begin(), record.minima.end(), [&](const maneuver::Minimum& minimum) {
      return std::abs(minimum.cost / cost - 1.0) < 1e-6;
    });
    return found == record.minima.end() ? maneuver::Minimum() : *found;
  };
  const maneuver::Minimum of_newton = counted(by_newton.cost), of_ipopt = counted(by_ipopt.cost);
  EXPECT_GT(of_newton.count - of_newton.by_ipopt.value_or(of_newton.count), 0);
  EXPECT_GT(of_ipopt.by_ipopt.value_or(0), 0);
}

INSTANTIATE_TEST_SUITE_P(Examples, BackEndsTogether,
                         testing::Values("as_printed/rotation", "sideways", "rotation", "around_an_obstacle",
                                         "translation_with_clearance", "rotation_with_clearance", "compliant_tail",
                                         "falling_cat_flip"),
                         named_by_value);
INSTANTIATE_TEST_SUITE_P(Examples, BackEndsInTheCatalogue,
                         testing::Values(Catalogue{"translation", 20}, Catalogue{"rotation", 120},
                                         Catalogue{"free_time", 20}, Catalogue{"gait", 20},
                                         Catalogue{"gait_within_limits", 5}, Catalogue{"least_work", 20}),
                         [](const auto& catalogue) { return std::string(catalogue.param.name); });
INSTANTIATE_TEST_SUITE_P(Examples, BackEnds,
                         testing::Values("translation", "translation_in_space", "rotation", "as_printed/translation",
                                         "as_printed/rotation", "sideways", "yaw", "around_an_obstacle",
                                         "translation_with_clearance", "rotation_with_clearance", "free_time", "gait",
                                         "gait_within_limits", "furthest_gait", "least_work", "falling_cat_flip",
                                         "eel_gait", "compliant_tail", "drifting"),
                         named_by_value);
INSTANTIATE_TEST_SUITE_P(Examples, BackEndsFromFirstGuesses,
                         testing::Values("translation", "translation_in_space", "rotation", "as_printed/translation",
                                         "as_printed/rotation", "sideways", "around_an_obstacle",
                                         "translation_with_clearance", "rotation_with_clearance", "free_time", "gait",
                                         "gait_within_limits", "furthest_gait", "least_work", "falling_cat_flip",
                                         "compliant_tail"),
                         named_by_value);

}  // namespace
}  // namespace lamprey::tests
