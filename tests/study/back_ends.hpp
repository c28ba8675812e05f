// An example, with few steps, before Lamprey's own solver and Ipopt on the full transcription, which share no equations of motion.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "search/method.hpp"

namespace lamprey::tests {

class BackEndsOn {
 protected:
  static constexpr int most_starts = 6;

  BackEndsOn(const std::string& name, int steps) : problem_(example(name, steps)) {}

  static maneuver::Problem example(const std::string& name, int steps) {
    maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + ".toml");
    problem.steps = steps;
    problem.search.starts = 1;
    problem.search.hops = 0;
    return problem;
  }

  certificate::Certificate certified(const search::Found& found) const {
    certificate::Options options;
    options.replay = false;
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system_, problem_, problem_.steps);
    return certificate::certify(
        system_, problem_,
        search::describe(system_, maneuver, problem_.scheme, maneuver::limit_rows(system_, problem_), found), options);
  }

  void expect_to_stay(search::Method& method, const search::Found& at) {
    const search::Found stayed = method.carry(at, problem_.steps);
    ASSERT_TRUE(stayed.converged()) << method.name() << ": " << stayed.outcome.reason;
    EXPECT_NEAR(stayed.cost / at.cost, 1.0, 1e-8) << method.name();
  }

  // Where Ipopt arrives from the first of its first guesses whose answer is certified: it may end where constraints are all but
  // dependent, and what its multipliers hide the certificate tells.
  void arrive_by_ipopt(search::Found& by_ipopt, certificate::Certificate& proof) {
    for (int start = 0; start < most_starts && !(proof.kkt < 1e-8); ++start) {
      by_ipopt = ipopt_->solve_starts(start, 1).front();
      tried_ = start + 1;
      if (by_ipopt.converged()) proof = certified(by_ipopt);
    }
    ASSERT_LT(proof.kkt, 1e-8) << "no start of Ipopt's is certified";
    ASSERT_TRUE(proof.second_order);
  }

  // From the same first guesses the two may end at different minima: both are in the catalogue of so many starts.
  void expect_minima_of_both_in_the_catalogue(int starts) {
    const search::Found by_newton = newton_->solve_starts(0, 1).front();
    ASSERT_TRUE(by_newton.converged()) << by_newton.outcome.reason;
    search::Found by_ipopt;
    certificate::Certificate proof;
    ASSERT_NO_FATAL_FAILURE(arrive_by_ipopt(by_ipopt, proof));
    EXPECT_TRUE(proof.second_order->positive);
    maneuver::Problem problem = problem_;
    problem.search.starts = starts;
    search::SolveOptions options;
    options.solver = search::Backend::newton;
    options.workers = 2;
    const maneuver::SearchRecord record = search::solve(system_, problem, options).front().search;
    EXPECT_EQ(record.starts, starts);
    for (double cost : {by_newton.cost, by_ipopt.cost})
      EXPECT_TRUE(
          std::any_of(record.minima.begin(), record.minima.end(),
                      [&](const maneuver::Minimum& minimum) { return std::abs(minimum.cost / cost - 1.0) < 1e-6; }))
          << "no minimum of cost " << cost << " among " << record.minima.size();
  }

  void expect_newton_to_stay_where_ipopt_arrives() {
    search::Found by_ipopt;
    certificate::Certificate proof;
    ASSERT_NO_FATAL_FAILURE(arrive_by_ipopt(by_ipopt, proof));
    if (proof.second_order->positive)
      expect_to_stay(*newton_, by_ipopt);
    else  // a saddle, which Newton's method leaves
      EXPECT_LT(newton_->carry(by_ipopt, problem_.steps).cost, by_ipopt.cost);
  }

  int tried_ = 0;  // first guesses by Ipopt
  maneuver::Problem problem_;
  model::System system_ = model::System(problem_.swimmer);
  search::SolveOptions options_;
  search::Budget budget_ = search::Budget(problem_, options_);
  std::unique_ptr<search::Method> newton_ = search::newton_method(system_, problem_, options_, budget_);
  std::unique_ptr<search::Method> ipopt_ = search::ipopt_method(system_, problem_, options_, budget_);
};

class BackEnds : public testing::TestWithParam<const char*>, protected BackEndsOn {
 protected:
  BackEnds() : BackEndsOn(GetParam(), 40) {}
};

}  // namespace lamprey::tests
