// What bodies do on their own, four at once, against the formulas of one body with coupling: a coupling too small to be felt
// sends every body along that road.
#include <gtest/gtest.h>

#include "chains.hpp"
#include "mechanics/step_hessian.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using mechanics::DiscreteLagrangian;

// A step, all that is known of it and of a direction's rates.
struct OneStep {
  OneStep(const model::SwimmerDescription& swimmer, unsigned seed)
      : random(seed),
        system(swimmer),
        bodies(system.body_count()),
        control(random_moments(random, system, 5.0)),
        interval(random_interval(random, system, 0.4)),
        step{system, DiscreteLagrangian::trapezoid, 0.1, interval, control, control},
        balance(bodies),
        step_blocks(model::at(bodies)),
        blocks(step_blocks),
        rates(model::at(bodies)),
        direction(system),
        rate(bodies),
        directions(bodies, 4),
        jacobian(bodies, 4),
        hessian(bodies, 4) {
    direction.left = random_freedoms(random, system, 1.0);
    direction.right = random_freedoms(random, system, 1.0);
    direction.displacement = random.vector();
    evaluate_balance(step, balance);
    mechanics::step_blocks(system, step.lagrangian, step.time_step, interval, balance.momenta, step_blocks);
    body_rates(step, balance.momenta, blocks, rates);
    evaluate_rate(step, balance, direction, mechanics::RateKind::adjoint, rate);
    rates_at_both_ends(step, balance, blocks, rates, directions, 4, 4, jacobian);
    adjoint_rates(step, balance, blocks, rates, direction, rate, directions, jacobian, 4, 4, hessian);
  }
  Random random;
  model::System system;
  int bodies;
  mechanics::Moments control;
  mechanics::Interval interval;
  mechanics::ForcedStep step;
  mechanics::StepBalance balance;
  std::vector<mechanics::BodyBlock> step_blocks, blocks;
  std::vector<mechanics::BodyRates> rates;
  mechanics::StepVariation direction;
  mechanics::StepRate rate;
  mechanics::StepDirections directions;
  mechanics::StepJacobian jacobian;
  mechanics::StepHessian hessian;
};

template <typename Values>
void expect_near(const Values& one, const Values& other, const std::string& what) {
  EXPECT_LE((one - other).norm(), tolerance(1e-13) * (1.0 + other.norm())) << what;
}

void expect_near(const mechanics::BodyBlock& one, const mechanics::BodyBlock& other, const std::string& what) {
  expect_near(one.moment_by_turn, other.moment_by_turn, what + ", moment by turn");
  expect_near(one.moment_by_shift, other.moment_by_shift, what + ", moment by shift");
  expect_near(one.force_by_turn, other.force_by_turn, what + ", force by turn");
  expect_near(one.force_by_shift, other.force_by_shift, what + ", force by shift");
}

void expect_near(const mechanics::BodyMomentaRates& one, const mechanics::BodyMomentaRates& other,
                 const std::string& what) {
  expect_near(one.force, other.force, what + ", force");
  expect_near(one.moment, other.moment, what + ", moment");
  expect_near(one.next, other.next, what + ", next moment");
}

// Swimmers of as many bodies as fill no, one and several fours, with joints of every kind.
class FourBodiesOf : public ::testing::TestWithParam<int> {
 protected:
  FourBodiesOf() {
    Random random(17u + static_cast<unsigned>(GetParam()));
    model::SwimmerDescription swimmer = random_swimmer(random, GetParam());
    for (model::BodyDescription& body : swimmer.bodies) body.coupling_matrix.reset();
    plain = std::make_unique<OneStep>(swimmer, 3);
    for (model::BodyDescription& body : swimmer.bodies) body.coupling_matrix = 1e-200 * Matrix3d::Identity();
    coupled = std::make_unique<OneStep>(swimmer, 3);
    EXPECT_TRUE(mechanics::all_plain(plain->system, DiscreteLagrangian::trapezoid));
    EXPECT_FALSE(mechanics::all_plain(coupled->system, DiscreteLagrangian::trapezoid));
  }
  template <typename Check>
  void for_bodies(const Check& check) {
    for (int i = 0; i < GetParam(); ++i) {
      SCOPED_TRACE(i);
      check(model::at(i));
    }
  }
  std::unique_ptr<OneStep> plain, coupled;
};

TEST_P(FourBodiesOf, have_the_momenta_of_each) {
  const mechanics::DiscreteMomenta &one = plain->balance.momenta, &other = coupled->balance.momenta;
  for_bodies([&](std::size_t i) {
    expect_near(one.shift[i], other.shift[i], "shift");
    expect_near(one.turn[i], other.turn[i], "turn");
    expect_near(one.impulse[i], other.impulse[i], "impulse");
    expect_near(one.own_minus[i], other.own_minus[i], "angular momentum at the beginning");
    expect_near(one.subtree_linear[i], other.subtree_linear[i], "linear momentum of the subtree");
  });
}

TEST_P(FourBodiesOf, have_the_rates_of_each) {
  for_bodies([&](std::size_t i) {
    expect_near(plain->step_blocks[i], coupled->step_blocks[i], "block of a step");
    expect_near(plain->blocks[i], coupled->blocks[i], "block");
    const mechanics::BodyRates &one = plain->rates[i], &other = coupled->rates[i];
    expect_near(one.force_by_left, other.force_by_left, "force by the left turn");
    expect_near(one.moment_by_left, other.moment_by_left, "moment by the left turn");
    expect_near(one.next_by_left, other.next_by_left, "next moment by the left turn");
    expect_near(one.next_by_shift, other.next_by_shift, "next moment by the shift");
    expect_near(one.hessian.turn_by_turn, other.hessian.turn_by_turn, "turn by turn");
    expect_near(one.hessian.turn_by_shift, other.hessian.turn_by_shift, "turn by shift");
    expect_near(one.hessian.shift_by_turn, other.hessian.shift_by_turn, "shift by turn");
    expect_near(one.hessian.shift_by_shift, other.hessian.shift_by_shift, "shift by shift");
  });
}

TEST_P(FourBodiesOf, have_the_second_rates_of_each) {
  for_bodies([&](std::size_t i) {
    const mechanics::BodySecondRates &one = plain->hessian.body[i], &other = coupled->hessian.body[i];
    expect_near(one.by_left, other.by_left, "by the left turn");
    expect_near(one.by_right, other.by_right, "by the right turn");
    expect_near(one.by_shift, other.by_shift, "by the shift");
  });
}

// Turns up to nearly half a turn, those of some bodies beyond a right angle and a third.
TEST_P(FourBodiesOf, are_found_again_between_their_rotations) {
  for (const double size : {0.3, 3.0}) {
    Random random(23);
    mechanics::Interval step = random_interval(random, plain->system, 0.4);
    for (Vector3d& zeta : step.cayley) zeta = random.vector(size);
    mechanics::update_interval(plain->system, step);
    mechanics::Interval found(GetParam());
    mechanics::interval_between(plain->system, step.rotation, step.next_rotation, step.displacement, found);
    for_bodies([&](std::size_t i) {
      expect_near(found.cayley[i], step.cayley[i], "Cayley vector");
      expect_near(found.next_rotation[i], step.next_rotation[i], "next rotation");
      expect_near(found.centre_displacement[i], step.centre_displacement[i], "displacement");
    });
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, FourBodiesOf, ::testing::Values(1, 2, 3, 4, 5, 8, 11), named_by_value);

}  // namespace
}  // namespace lamprey::tests
