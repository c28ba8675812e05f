// An example, with few steps, before Lamprey's own solver and Ipopt on the full transcription, which share no equations of motion.
#pragma once

#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "study/method.hpp"

namespace lamprey::tests {

class BackEnds : public testing::TestWithParam<const char*> {
 protected:
  static constexpr int few_steps = 40;
  static constexpr int most_starts = 6;

  static maneuver::Problem example() {
    maneuver::Problem problem =
        file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/" + GetParam() + ".toml");
    problem.steps = few_steps;
    problem.search.starts = 1;
    problem.search.hops = 0;
    return problem;
  }

  certificate::Certificate certified(const study::Found& found) const {
    certificate::Options options;
    options.replay = false;
    const maneuver::Maneuver maneuver = maneuver::make_maneuver(system_, problem_, few_steps);
    return certificate::certify(
        system_, problem_,
        study::describe(system_, maneuver, problem_.scheme, maneuver::limit_rows(system_, problem_), found), options);
  }

  void expect_to_stay(study::Method& method, const study::Found& at) {
    const study::Found stayed = method.carry(at, few_steps);
    ASSERT_TRUE(stayed.converged()) << method.name() << ": " << stayed.outcome.reason;
    EXPECT_NEAR(stayed.cost / at.cost, 1.0, 1e-8) << method.name();
  }

  // Newton's method from where Ipopt arrives from first guesses of its own. It may end where constraints are all but
  // dependent: what its multipliers hide the certificate tells.
  void expect_newton_to_stay_where_ipopt_arrives() {
    study::Found by_ipopt;
    certificate::Certificate proof;
    for (int start = 0; start < most_starts && !(proof.kkt < 1e-8); ++start) {
      by_ipopt = ipopt_->solve_starts(start, 1).front();
      if (by_ipopt.converged()) proof = certified(by_ipopt);
    }
    ASSERT_LT(proof.kkt, 1e-8) << "no start of Ipopt's is certified";
    ASSERT_TRUE(proof.second_order);
    if (proof.second_order->positive)
      expect_to_stay(*newton_, by_ipopt);
    else  // a saddle, which Newton's method leaves
      EXPECT_LT(newton_->carry(by_ipopt, few_steps).cost, by_ipopt.cost);
  }

  maneuver::Problem problem_ = example();
  model::System system_ = model::System(problem_.swimmer);
  study::SolveOptions options_;
  study::Budget budget_ = study::Budget(problem_, options_);
  std::unique_ptr<study::Method> newton_ = study::newton_method(system_, problem_, options_, budget_);
  std::unique_ptr<study::Method> ipopt_ = study::ipopt_method(system_, problem_, options_, budget_);
};

}  // namespace lamprey::tests
