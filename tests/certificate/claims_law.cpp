// False claims: a certificate is held to what is found when it is computed again, in whatever field it says more.
#include "certificate/claims.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "certificate/certify.hpp"
#include "marched_answers.hpp"
#include "study/answer.hpp"

namespace lamprey::tests {
namespace {

using certificate::Certificate;
using certificate::false_claims;

constexpr double one_second = 1.0, one_metre = 1.0;

const Certificate& proof() {
  static const Certificate found = [] {
    maneuver::Problem problem = chain_problem(60, 1.0);
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move = {2.0, std::nullopt, std::nullopt};
    problem.limits.torque = 1e6;
    for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
    return study::answer(model::System(problem.swimmer), problem, {}).certificate;
  }();
  return found;
}

TEST(Claims, of_the_certificate_itself_hold) {
  EXPECT_EQ(proof().verdict, certificate::Verdict::proved);
  for (const auto& claim : false_claims(proof(), proof(), one_second, one_metre)) ADD_FAILURE() << claim.field;
}

TEST(Claims, that_say_less_or_nothing_hold) {
  Certificate modest = proof();
  modest.goal_error = 1.0;
  modest.kkt = evidence::unset;
  modest.replay.reset();
  modest.second_order.reset();
  modest.verdict = certificate::Verdict::stationary;
  for (const auto& claim : false_claims(modest, proof(), one_second, one_metre)) ADD_FAILURE() << claim.field;
}

TEST(Claims, that_say_more_are_named_in_every_field) {
  const std::vector<std::pair<std::string, std::function<void(Certificate&)>>> worse = {
      {"goal_error", [](Certificate& is) { is.goal_error = 1e-3; }},
      {"rest_error", [](Certificate& is) { is.rest_error = 1e-3; }},
      {"momentum_drift", [](Certificate& is) { is.momentum_drift = 1e-3; }},
      {"rotation_drift", [](Certificate& is) { is.rotation_drift = 1e-3; }},
      {"iterates_momentum", [](Certificate& is) { is.iterates_momentum = 1e-3; }},
      {"equation_residual", [](Certificate& is) { is.equation_residual = 1e-3; }},
      {"start_error", [](Certificate& is) { is.start_error = 1e-3; }},
      {"control_error", [](Certificate& is) { is.control_error = 1e-3; }},
      {"time_error", [](Certificate& is) { is.time_error = 1e-3; }},
      {"velocity_error", [](Certificate& is) { is.velocity_error = 1e-3; }},
      {"cost_error", [](Certificate& is) { is.cost_error = 1e-3; }},
      {"kkt", [](Certificate& is) { is.kkt = 1e-3; }},
      {"limits.violation", [](Certificate& is) { is.limits->violation = 1e-3; }},
      {"limits.complementarity", [](Certificate& is) { is.limits->complementarity = 1e-3; }},
      {"limits.negative", [](Certificate& is) { is.limits->negative = 1e-3; }},
      {"second_order.smallest_eigenvalue", [](Certificate& is) { is.second_order->smallest_eigenvalue *= 0.9; }},
      {"second_order.positive", [](Certificate& is) { is.second_order->positive = false; }},
      {"second_order.negative_eigenvalues", [](Certificate& is) { is.second_order->negative_eigenvalues = 3; }},
      {"replay.rotation_error", [](Certificate& is) { is.replay->rotation_error = 1.0; }},
      {"replay.position_error", [](Certificate& is) { is.replay->position_error = 10.0; }},
      {"replay.rotation_error", [](Certificate& is) { is.replay->rotation_error *= 2.0; }},
      {"replay.growth_rate", [](Certificate& is) { is.replay->growth_rate *= 1.01; }},
      {"replay.window", [](Certificate& is) { is.replay->window *= 2.0; }},
      {"replay.servo_position_error", [](Certificate& is) { is.replay->servo_position_error += 1.0; }},
      {"replay.whole_rotation_error", [](Certificate& is) { is.replay->whole_rotation_error = 10.0; }},
      {"replay.whole_position_error", [](Certificate& is) { is.replay->whole_position_error = 100.0; }},
      {"refinement.cost_half_step", [](Certificate& is) { is.refinement->cost_half_step *= 1.0 + 1e-9; }},
      {"refinement.observed_order", [](Certificate& is) { is.refinement->observed_order += 1e-3; }},
      {"refinement.cost_limit", [](Certificate& is) { is.refinement->cost_limit *= 1.0 + 1e-9; }},
      {"refinement.cost_error", [](Certificate& is) { is.refinement->cost_error *= 2.0; }},
      {"refinement.grids.cost", [](Certificate& is) { is.refinement->grids[1].cost *= 1.0 + 1e-9; }},
      {"clearance.gap", [](Certificate& is) { is.clearance->gap -= 0.01; }},
      {"verdict", [](Certificate& is) { is.verdict = certificate::Verdict::stationary; }},
      {"kkt", [](Certificate& is) { is.kkt = evidence::unset; }},
      {"clearance.gap", [](Certificate& is) { is.clearance.reset(); }}};
  for (const auto& [field, make_worse] : worse) {
    Certificate found = proof();
    make_worse(found);
    const auto claims = false_claims(proof(), found, one_second, one_metre);
    ASSERT_EQ(claims.size(), 1U) << field;
    EXPECT_EQ(claims.front().field, field);
  }
}

// Round-off that grows by e^29 leaves the error of a whole replay no digit to hold on to; by less it comes out the same everywhere.
TEST(Claims, of_whole_replays_are_held_to_as_many_digits_as_growth_leaves) {
  for (const double growth : {2.0, 29.0}) {
    Certificate told = proof();
    told.replay->growth_rate = growth;
    told.replay->whole_rotation_error = 2e-4;
    Certificate found = told;
    found.replay->whole_rotation_error = 3e-4;
    const auto claims = false_claims(told, found, one_second, one_metre);
    EXPECT_EQ(claims.size(), growth < 10.0 ? 1U : 0U) << growth;
  }
}

TEST(Claims, of_all_axes_are_held_to_what_is_found) {
  Certificate told = proof();
  told.all_axes = optimality::AllAxes{1e-12, {}};
  EXPECT_TRUE(false_claims(told, told, one_second, one_metre).empty());
  Certificate found = told;
  found.all_axes->kkt = 1e-3;
  const auto claims = false_claims(told, found, one_second, one_metre);
  ASSERT_EQ(claims.size(), 1U);
  EXPECT_EQ(claims.front().field, "second_order_all_axes.kkt");
}

// Of small swimmers, and of short maneuvers, as of large and long ones.
TEST(Claims, of_small_numbers_are_held_to_their_own_size) {
  const double length = 1e-5, duration = 1e-6;
  Certificate told = proof();
  told.clearance->gap = 5e-7;
  told.replay->window = 1e-7;
  told.replay->work = 5e-7;
  told.replay->growth_rate = 1e4;
  const std::vector<std::pair<std::string, std::function<void(Certificate&)>>> others = {
      {"clearance.gap", [](Certificate& is) { is.clearance->gap = -4e-7; }},
      {"replay.window", [](Certificate& is) { is.replay->window = 2e-7; }},
      {"replay.growth_rate", [](Certificate& is) { is.replay->growth_rate = 2e4; }},
      {"replay.work", [](Certificate& is) { is.replay->work = 1e-9; }}};
  for (const auto& [field, change] : others) {
    Certificate found = told;
    change(found);
    const auto claims = false_claims(told, found, duration, length);
    ASSERT_EQ(claims.size(), 1U) << field;
    EXPECT_EQ(claims.front().field, field);
  }
}

}  // namespace
}  // namespace lamprey::tests
