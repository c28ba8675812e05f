#include "mechanics/compliant_time.hpp"

namespace lamprey::mechanics {

namespace {

using model::at;

void add_along(const Freedoms& terms, Freedoms& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += terms[i];
}

void negate(Vectors& terms) {
  for (Vector3d& term : terms) term = -term;
}

}  // namespace

CompliantTime::Shares::Shares(int bodies)
    : joint_minus(bodies),
      joint_plus(bodies),
      moment(at(bodies)),
      moment_next(at(bodies)),
      minus(at(bodies)),
      plus(at(bodies)) {}

void CompliantTime::Shares::set_zero() {
  joint_minus.set_zero();
  joint_plus.set_zero();
}

CompliantTime::CompliantTime(const model::System& system)
    : system_(system),
      no_control_(at(system.joint_count()), Vector3d::Zero()),
      no_force_(at(system.body_count()), Vector3d::Zero()),
      timed_(system.body_count()),
      rate_(system.body_count()),
      damped_minus_(at(system.body_count())),
      damped_plus_(at(system.body_count())),
      turn_(at(system.body_count())),
      turn_next_(at(system.body_count())) {}

void CompliantTime::gather_ends(const Interval& interval, Shares& shares) const {
  shares.moment = shares.joint_minus.body;
  shares.moment_next = shares.joint_plus.body;
  gather(system_, interval.rotation, no_force_, shares.moment, shares.minus);
  gather(system_, interval.next_rotation, no_force_, shares.moment_next, shares.plus);
  add_along(shares.joint_minus.along, shares.minus);
  add_along(shares.joint_plus.along, shares.plus);
}

void CompliantTime::evaluate(double time_step, const Interval& interval) {
  timed_.set_zero();
  damping_momenta(system_, interval, timed_.joint_minus, timed_.joint_plus);
  negate(timed_.joint_plus.body);  // E⁺ has −ψ⁺
  negate(timed_.joint_plus.along);
  gather_ends(interval, timed_);
  damped_minus_ = timed_.minus;
  damped_plus_ = timed_.plus;
  // of springs half a step's impulse at each end, twice
  add_node_moments(system_, interval.rotation, no_control_, -time_step, timed_.joint_minus);
  add_node_moments(system_, interval.next_rotation, no_control_, time_step, timed_.joint_plus);
  gather_ends(interval, timed_);
}

// As evaluate_rate for the adjoint, bodies without inertia.
void CompliantTime::differentiate(double time_step, const Interval& interval, const Freedoms& left,
                                  const Freedoms& right) {
  body_turns(system_, interval.rotation, left, turn_);
  body_turns(system_, interval.next_rotation, right, turn_next_);
  const NodeTurns at_left{left, turn_}, at_right{right, turn_next_};
  rate_.set_zero();
  add_damping_rates(system_, interval, at_left, at_right, -1.0, 1.0, 1.0, rate_.joint_minus, rate_.joint_plus);
  add_node_moment_rates(system_, interval.rotation, no_control_, at_left, {}, RateKind::adjoint, -time_step,
                        rate_.joint_minus);
  add_node_moment_rates(system_, interval.next_rotation, no_control_, at_right, {}, RateKind::adjoint, time_step,
                        rate_.joint_plus);
  rate_.moment = rate_.joint_minus.body;
  rate_.moment_next = rate_.joint_plus.body;
  gather_rate(system_, interval.rotation, no_force_, timed_.moment, {left, turn_, no_force_}, rate_.moment,
              rate_.minus);
  gather_rate(system_, interval.next_rotation, no_force_, timed_.moment_next, {right, turn_next_, no_force_},
              rate_.moment_next, rate_.plus);
  add_along(rate_.joint_minus.along, rate_.minus);
  add_along(rate_.joint_plus.along, rate_.plus);
  // left-invariant fields that do not commute
  for (int i = 0; i < system_.body_count(); ++i) {
    if (system_.body(i).freedoms != 3) continue;
    rate_.minus[at(i)] += left[at(i)].cross(timed_.minus[at(i)]);
    rate_.plus[at(i)] += right[at(i)].cross(timed_.plus[at(i)]);
  }
  negate(rate_.minus);
}

}  // namespace lamprey::mechanics
