// Rounds of a search within limits share one time and one interruption.
#include "optimizer/limited_newton.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace lamprey::tests {
namespace {

using optimizer::Merit;
using optimizer::StageModel;
using optimizer::StageSizes;
using optimizer::StageStep;
using optimizer::Termination;

// ½ (x − 1)² + ½ x² of one input x, and a limit that comes nearer with every look at it but is never met.
class SlowLimit : public optimizer::StageProgram {
 public:
  explicit SlowLimit(useconds_t each_model) : each_model_(each_model) { merit_ = at(x_); }
  int models = 0;

  StageSizes sizes() const override { return {.stages = 1, .states = 1, .inputs = 1, .end_rows = 0}; }
  const Merit& merit() const override { return merit_; }
  bool has_multipliers() const override { return true; }
  void linearize(StageModel& model) override {
    ++models;
    usleep(each_model_);
    optimizer::Stage& stage = model.stage.front();
    stage.A.setZero();
    stage.B.setOnes();
    stage.gap.setZero();
    stage.Q.setZero();
    stage.S.setZero();
    stage.q.setZero();
    stage.R.setOnes();
    stage.r.setConstant(x_);
    stage.metric.setIdentity();
    stage.gradient = 1.0;
    model.Q_end.setOnes();
    model.q_end.setConstant(x_ - 1.0);
    model.metric_end.setIdentity();
  }
  const Merit* try_step(const StageStep& step, double length) override {
    trial_ = x_ + length * step.input.front()[0];
    trial_merit_ = at(trial_);
    return &trial_merit_;
  }
  const Eigen::VectorXd& end_rows() const override { return none_; }
  const Eigen::VectorXd& trial_end_rows() const override { return none_; }
  void accept() override {
    x_ = trial_;
    merit_ = trial_merit_;
  }
  void take_multipliers(const StageStep&, double) override {}
  double longest(const StageStep&, const optimizer::Promise&) override { return 1.0; }
  double goal_error() const override { return 0.0; }
  bool limited() const override { return true; }
  double limit_error() const override { return error_ = std::max(0.8 * error_, 1e-6); }

 private:
  static Merit at(double x) { return {0.5 * (x - 1.0) * (x - 1.0) + 0.5 * x * x, 0.0}; }
  useconds_t each_model_;  // µs
  double x_ = 0.0, trial_ = 0.0;
  Merit merit_, trial_merit_;
  mutable double error_ = 1e7;
  Eigen::VectorXd none_;
};

optimizer::Outcome solve(SlowLimit& program, const optimizer::Options& options) {
  optimizer::StageNewton newton(program.sizes());
  optimizer::Outcome outcome;
  optimizer::solve_within_limits(newton, program, options, 1e-9, outcome);
  return outcome;
}

TEST(LimitedNewton, gives_all_rounds_together_the_time_of_one_search) {
  SlowLimit endless(0);
  EXPECT_EQ(solve(endless, {}).termination, Termination::stalled);
  EXPECT_GE(endless.models, 40) << "one for each round at least";
  SlowLimit program(10000);  // so that a round takes less than the limit, and all of them much more
  optimizer::Options options;
  options.time_limit = 0.05;
  const optimizer::Outcome outcome = solve(program, options);
  EXPECT_EQ(outcome.termination, Termination::time_limit) << outcome.reason;
  EXPECT_LE(program.models, 6);
  EXPECT_GE(program.models, 2);
}

TEST(LimitedNewton, ends_between_rounds_when_it_is_interrupted) {
  SlowLimit program(0);
  optimizer::Options options;
  options.interrupted = [&] { return program.models >= 5; };
  EXPECT_EQ(solve(program, options).termination, Termination::interrupted);
  EXPECT_LE(program.models, 6);
}

// The same without the limit, in steps that never go farther than a hundredth: a valley that goes on falling.
class LongValley : public SlowLimit {
 public:
  LongValley() : SlowLimit(0) {}
  double longest(const StageStep& step, const optimizer::Promise&) override {
    return std::min(1.0, 0.01 / std::abs(step.input.front()[0]));
  }
  bool limited() const override { return false; }
  double limit_error() const override { return 0.0; }
};

TEST(StageNewton, goes_on_for_longer_while_the_cost_falls) {
  optimizer::Options options;
  options.max_iterations = 10;  // of the 50 that the way to x = ½ takes
  LongValley impatient;
  EXPECT_EQ(optimizer::StageNewton(impatient.sizes()).solve(impatient, options).iterations, 10);
  options.patience = 3;
  LongValley still_impatient;
  const optimizer::Outcome stopped = optimizer::StageNewton(still_impatient.sizes()).solve(still_impatient, options);
  EXPECT_EQ(stopped.termination, Termination::stalled);
  EXPECT_EQ(stopped.iterations, 30);
  options.patience = 100;
  options.most_iterations = 25;
  LongValley hasty;
  EXPECT_EQ(optimizer::StageNewton(hasty.sizes()).solve(hasty, options).iterations, 25);
  options.most_iterations = 1000;
  LongValley patient;
  const optimizer::Outcome arrived = optimizer::StageNewton(patient.sizes()).solve(patient, options);
  EXPECT_EQ(arrived.termination, Termination::converged) << arrived.reason;
  EXPECT_NEAR(arrived.objective, 0.25, 1e-12);
}

// The same with the limit.
class LimitedValley : public LongValley {
 public:
  bool limited() const override { return true; }
  double limit_error() const override { return SlowLimit::limit_error(); }
};

TEST(LimitedNewton, gives_all_rounds_together_no_more_iterations_than_are_allowed) {
  optimizer::Options options;
  options.max_iterations = 5;  // of a round
  LimitedValley endless;
  ASSERT_GT(solve(endless, options).iterations, 20);
  options.most_iterations = 7;
  LimitedValley program;
  const optimizer::Outcome outcome = solve(program, options);
  EXPECT_EQ(outcome.iterations, 7);
  EXPECT_EQ(outcome.termination, Termination::stalled);
  EXPECT_EQ(outcome.reason, "no convergence within 7 iterations");
}

// Limits that are met, and of which those that hold are or are not found.
class Landing : public SlowLimit {
 public:
  explicit Landing(bool finds_them) : SlowLimit(0), finds_them_(finds_them) {}
  int landings = 0, returns = 0;
  double limit_error() const override { return landed_ && !finds_them_ ? 1.0 : 0.0; }
  bool land() override {
    landed_ = true;
    ++landings;
    return true;
  }
  bool landed() const override { return landed_; }
  void take_off() override {
    landed_ = false;
    ++returns;
  }

 private:
  bool finds_them_, landed_ = false;
};

TEST(LimitedNewton, ends_with_the_limits_that_hold_as_equalities) {
  Landing program(true);
  EXPECT_EQ(solve(program, {}).termination, Termination::converged);
  EXPECT_TRUE(program.landed());
  EXPECT_EQ(program.landings, 1);
  EXPECT_EQ(program.returns, 0);
}

TEST(LimitedNewton, returns_where_it_does_not_find_them) {
  Landing program(false);
  EXPECT_EQ(solve(program, {}).termination, Termination::converged);
  EXPECT_FALSE(program.landed());
  EXPECT_EQ(program.landings, 1);
  EXPECT_EQ(program.returns, 1);
}

// The same, and with more weight the barrier's answer is none.
class LightAnswer : public Landing {
 public:
  LightAnswer() : Landing(false) {}
  int kept = 0;
  double limit_error() const override { return heavy_ ? 1e-4 : Landing::limit_error(); }
  double limit_violation() const override { return limit_error(); }
  void take_off() override {
    Landing::take_off();
    heavy_ = true;
  }
  void keep_worth() override { ++kept; }
  void take_kept_worth() override {
    EXPECT_EQ(kept, 1);
    heavy_ = false;
  }

 private:
  bool heavy_ = false;
};

TEST(LimitedNewton, goes_back_to_the_answer_before_where_it_finds_none_with_more_weight) {
  LightAnswer program;
  const optimizer::Outcome outcome = solve(program, {});
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_FALSE(program.landed());
  EXPECT_EQ(program.limit_error(), 0.0);
  EXPECT_EQ(program.returns, 1);
}

// Of the limits that hold each set finds one more, which is broken as far as the ones before it were.
class OneMoreByEachSet : public Landing {
 public:
  explicit OneMoreByEachSet(double changes) : Landing(true), changes_(changes) {}
  double limit_error() const override { return landed() && tried_ < needed ? 1.0 : 0.0; }
  double cost() const override { return 1.0 + changes_ * tried_; }
  void renew_limits(bool) override { tried_ += landed() ? 1 : 0; }

 private:
  static constexpr int needed = 12;
  double changes_;
  int tried_ = 0;
};

// Errors do not tell that they come nearer: costs do, which hardly change.
TEST(LimitedNewton, goes_on_from_set_to_set_while_costs_hardly_change) {
  OneMoreByEachSet program(1e-5);
  EXPECT_EQ(solve(program, {}).termination, Termination::converged);
  EXPECT_TRUE(program.landed());
  EXPECT_EQ(program.landings, 1);
  EXPECT_EQ(program.returns, 0);
  for (const double changes : {0.0, 0.1}) {
    OneMoreByEachSet lost(changes);
    solve(lost, {});
    EXPECT_GE(lost.returns, 1) << "of cost by " << changes;
  }
}

// Each set breaks what it does not hold three times as far as the one before it, at costs that hardly change.
class FartherByEachSet : public Landing {
 public:
  FartherByEachSet() : Landing(true) {}
  double limit_error() const override { return landed() ? error_ : 0.0; }
  double cost() const override { return 1.0 + error_; }
  void renew_limits(bool) override { error_ *= landed() ? 3.0 : 1.0; }

 private:
  double error_ = 1e-6;
};

TEST(LimitedNewton, returns_from_sets_that_lead_farther_and_farther_away) {
  FartherByEachSet program;
  const optimizer::Outcome outcome = solve(program, {});
  EXPECT_EQ(outcome.termination, Termination::converged) << outcome.reason;
  EXPECT_FALSE(program.landed());
  EXPECT_LT(program.cost(), 1.001) << "went on for too long";
}

// Limits that are met from the beginning, beside kinks of the cost that settle slowly: before they have, which limits hold changes.
class LandingBesideKinks : public SlowLimit {
 public:
  LandingBesideKinks() : SlowLimit(0) {}
  std::vector<double> landings;  // kinks' errors
  double limit_error() const override { return std::max(error_, limit_violation()); }
  double limit_violation() const override { return landed_ && landings.back() > changing_below ? 1.0 : 0.0; }
  void renew_limits(bool) override { error_ *= 0.5; }
  bool land() override {
    landed_ = true;
    landings.push_back(error_);
    return true;
  }
  bool landed() const override { return landed_; }
  void take_off() override { landed_ = false; }

 private:
  static constexpr double changing_below = 1e-6;
  bool landed_ = false;
  double error_ = 0.1;
};

TEST(LimitedNewton, lands_when_other_kinks_have_nearly_settled_and_again_much_later) {
  LandingBesideKinks program;
  EXPECT_EQ(solve(program, {}).termination, Termination::converged);
  EXPECT_TRUE(program.landed());
  ASSERT_EQ(program.landings.size(), 2U);
  EXPECT_LE(program.landings[0], 1e-5);
  EXPECT_GT(program.landings[0], 1e-6);
  EXPECT_LE(program.landings[1], 1e-2 * program.landings[0]);
}

}  // namespace
}  // namespace lamprey::tests
