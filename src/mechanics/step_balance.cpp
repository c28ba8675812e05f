#include "mechanics/step_balance.hpp"

#include "mechanics/second_momenta.hpp"

namespace lamprey::mechanics {

namespace {

using lie::hat;
using model::at;
using model::Body;
using model::Joint;
using model::System;

void add(const Vectors& terms, Vectors& sum) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += terms[i];
}

// Displacement of each mass centre when both ends of the step turn.
void centre_rates(const System& system, const Interval& step, const Vector3d& root, const Vectors& left,
                  const Vectors& right, Vectors& centre) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.parent < 0) {
      centre[at(i)] = root;
      continue;
    }
    const Joint& up = system.joint(body.joint);
    const auto moved = [&](int b, const Vector3d& offset) {
      return Vector3d(step.next_rotation[at(b)] * right[at(b)].cross(offset) -
                      step.rotation[at(b)] * left[at(b)].cross(offset));
    };
    centre[at(i)] = centre[at(up.parent)] + moved(up.parent, up.parent_offset) - moved(i, up.child_offset);
  }
}

// Which bodies a direction leaves where they are: their rates vanish.
void find_still(const System& system, StepRate& rate) {
  for (int i : system.root_to_leaves()) {
    const std::size_t n = at(i);
    const int parent = system.body(i).parent;
    rate.still[n] = (parent < 0 || rate.still[at(parent)]) && rate.turn[n].isZero(0.0) &&
                    rate.turn_next[n].isZero(0.0) && rate.centre[n].isZero(0.0);
  }
}

// The same to second order: turns along `first` change by `changes` when the ends turn along `second`.
void centre_second_rates(const System& system, const Interval& step, const StepRate& first, const StepRate& second,
                         const Vectors& change, const Vectors& change_next, Vectors& centre) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (body.parent < 0) {
      centre[at(i)].setZero();
      continue;
    }
    const Joint& up = system.joint(body.joint);
    const auto moved = [&](int b, const Vector3d& offset) {
      const std::size_t n = at(b);
      const Vector3d right = second.turn_next[n].cross(first.turn_next[n].cross(offset)) + change_next[n].cross(offset);
      const Vector3d left = second.turn[n].cross(first.turn[n].cross(offset)) + change[n].cross(offset);
      return Vector3d(step.next_rotation[n] * right - step.rotation[n] * left);
    };
    centre[at(i)] = centre[at(up.parent)] + moved(up.parent, up.parent_offset) - moved(i, up.child_offset);
  }
}

// Bodies that turn on their own: e·(w × p) is what left-invariant fields that do not commute leave.
void add_brackets(const System& system, const Freedoms& turn, const Freedoms& momentum, double weight,
                  Freedoms& result) {
  for (int i = 0; i < system.body_count(); ++i)
    if (system.body(i).freedoms == 3) result[at(i)] += weight * turn[at(i)].cross(momentum[at(i)]);
}

// Blocks of bodies whose translation is weighed at the ends of the step alone (equation 4.15).
void four_blocks(const System& system, DiscreteLagrangian lagrangian, double time_step, const Interval& interval,
                 const DiscreteMomenta& p, const FourBodies& four, std::vector<BodyBlock>& blocks) {
  const FourShares of(system, lagrangian, time_step, interval, four);
  const Four33 R_next = four.read(interval.next_rotation);
  const Four3 w = four.read(p.shift);
  const double left = of.rate * of.weights.left, right = of.rate * of.weights.right;
  const Four3 w_next = transposed(of.F) * w;
  const Four33 X = of.F * of.trace_weight;
  const Four33 RM = left * (of.R * of.mass);
  const Four33 RM_next = right * (R_next * of.mass);
  four.write(of.rate * (trace(X) * of.F - X * of.F), blocks, &BodyBlock::moment_by_turn);
  four.write(RM * transposed(of.R) + RM_next * transposed(R_next), blocks, &BodyBlock::force_by_shift);
  four.write(times_hat(RM_next, w_next) - times_hat(R_next, right * (of.mass * w_next)), blocks,
             &BodyBlock::force_by_turn);
  // (ŵ M − (M w)^) Rᵀ, transposed
  four.write(transposed(times_hat(of.R, left * (of.mass * w)) - times_hat(RM, w)), blocks, &BodyBlock::moment_by_shift);
}

}  // namespace

StepBalance::StepBalance(int bodies)
    : momenta(bodies),
      minus(at(bodies)),
      plus(at(bodies)),
      moment(at(bodies)),
      moment_next(at(bodies)),
      joint_minus(bodies),
      joint_plus(bodies) {}

StepVariation::StepVariation(const System& system)
    : left(at(system.body_count())),
      right(at(system.body_count())),
      control(at(system.joint_count())),
      control_next(at(system.joint_count())) {
  set_zero();
}

void StepVariation::set_zero() {
  for (Vectors* v : {&left, &right, &control, &control_next})
    for (Vector3d& entry : *v) entry.setZero();
  displacement.setZero();
}

StepRate::StepRate(int bodies)
    : turn(at(bodies)),
      turn_next(at(bodies)),
      centre(at(bodies)),
      seen(at(bodies)),
      still(at(bodies)),
      gradient(at(bodies)),
      force(at(bodies)),
      moment(at(bodies)),
      moment_next(at(bodies)),
      minus(at(bodies)),
      plus(at(bodies)),
      joint_minus(bodies),
      joint_plus(bodies) {}

SecondRateWorkspace::SecondRateWorkspace(int bodies)
    : turn_change(at(bodies)),
      turn_change_next(at(bodies)),
      centre_change(at(bodies)),
      force(at(bodies)),
      moment(at(bodies)),
      moment_next(at(bodies)),
      joint_minus(bodies),
      joint_plus(bodies) {}

void evaluate_balance(const ForcedStep& step, StepBalance& balance) {
  body_momenta(step.system, step.lagrangian, step.time_step, step.interval, balance.momenta);
  gather_balance(step, balance);
}

void gather_balance(const ForcedStep& step, StepBalance& balance) {
  const System& system = step.system;
  const DiscreteMomenta& p = balance.momenta;
  balance.linear = p.linear;
  balance.joint_minus.set_zero();
  balance.joint_plus.set_zero();
  damping_momenta(system, step.interval, balance.joint_minus, balance.joint_plus);
  for (Vectors* v : {&balance.joint_plus.body, &balance.joint_plus.along})
    for (Vector3d& m : *v) m = -m;  // E⁺ has −ψ⁺
  add_node_moments(system, step.interval.rotation, step.control, -0.5 * step.time_step, balance.joint_minus);
  add_node_moments(system, step.interval.next_rotation, step.control_next, 0.5 * step.time_step, balance.joint_plus);
  for (int i = 0; i < system.body_count(); ++i) {
    balance.moment[at(i)] = p.own_minus[at(i)] + balance.joint_minus.body[at(i)];
    balance.moment_next[at(i)] = p.turn[at(i)] + balance.joint_plus.body[at(i)];
  }
  gather(system, step.interval.rotation, p.subtree_linear, balance.moment, balance.minus);
  gather(system, step.interval.next_rotation, p.subtree_linear, balance.moment_next, balance.plus);
  add(balance.joint_minus.along, balance.minus);
  add(balance.joint_plus.along, balance.plus);
}

void evaluate_rate(const ForcedStep& step, const StepBalance& balance, const StepVariation& d, RateKind kind,
                   StepRate& rate) {
  const System& system = step.system;
  const Interval& interval = step.interval;
  const DiscreteMomenta& p = balance.momenta;
  const bool adjoint = kind == RateKind::adjoint;
  body_turns(system, interval.rotation, d.left, rate.turn);
  body_turns(system, interval.next_rotation, d.right, rate.turn_next);
  centre_rates(system, interval, d.displacement, rate.turn, rate.turn_next, rate.centre);
  find_still(system, rate);

  const NodeTurns left{d.left, rate.turn};
  const NodeTurns right{d.right, rate.turn_next};
  rate.joint_minus.set_zero();
  rate.joint_plus.set_zero();
  add_damping_rates(system, interval, left, right, adjoint ? -1.0 : 1.0, 1.0, adjoint ? 1.0 : -1.0, rate.joint_minus,
                    rate.joint_plus);
  const double half = 0.5 * step.time_step;
  add_node_moment_rates(system, interval.rotation, step.control, left, d.control, kind, -half, rate.joint_minus);
  add_node_moment_rates(system, interval.next_rotation, step.control_next, right, d.control_next, kind, half,
                        rate.joint_plus);

  for (int i = 0; i < system.body_count(); ++i) {
    const std::size_t n = at(i);
    if (rate.still[n]) {
      rate.seen[n] = {Vector3d::Zero(), Vector3d::Zero()};
      rate.gradient[n] = {Vector3d::Zero(), Vector3d::Zero()};
      rate.force[n].setZero();
      rate.moment[n] = rate.joint_minus.body[n];
      rate.moment_next[n] = rate.joint_plus.body[n];
      continue;
    }
    const Matrix3d& R = interval.rotation[n];
    const Matrix3d& F = interval.relative_rotation[n];
    const Vector3d& w = p.shift[n];
    const Vector3d& eta = rate.turn[n];
    rate.seen[n] = {rate.turn_next[n] - F.transpose() * eta, w.cross(eta) + R.transpose() * rate.centre[n]};
    const auto& [a, b] = rate.seen[n];
    rate.gradient[n] = BodyLagrangian(system, step.lagrangian, step.time_step, i)
                           .gradient_rate(body_step(interval, p, i), rate.seen[n]);
    const auto& [turn, shift] = rate.gradient[n];
    rate.force[n] = R * (eta.cross(p.impulse[n]) + shift);
    rate.moment[n] =
        F * (a.cross(p.turn[n]) + turn) + b.cross(p.impulse[n]) + w.cross(shift) + rate.joint_minus.body[n];
    rate.moment_next[n] = turn + rate.joint_plus.body[n];
  }
  sum_subtrees(system, rate.force);
  rate.linear = rate.force[0];
  gather_rate(system, interval.rotation, p.subtree_linear, balance.moment, {d.left, rate.turn, rate.force}, rate.moment,
              rate.minus);
  gather_rate(system, interval.next_rotation, p.subtree_linear, balance.moment_next,
              {d.right, rate.turn_next, rate.force}, rate.moment_next, rate.plus);
  add(rate.joint_minus.along, rate.minus);
  add(rate.joint_plus.along, rate.plus);
  if (!adjoint) return;
  add_brackets(system, d.left, balance.minus, 1.0, rate.minus);
  add_brackets(system, d.right, balance.plus, 1.0, rate.plus);
  for (Vector3d& entry : rate.minus) entry = -entry;
}

void evaluate_adjoint_rate(const ForcedStep& step, const StepBalance& balance, const StepVariation& first,
                           const StepRate& first_rate, const StepVariation& second, const StepRate& second_rate,
                           SecondRateWorkspace& work, Freedoms& minus, Freedoms& plus, Vector3d& linear) {
  const System& system = step.system;
  const Interval& interval = step.interval;
  const DiscreteMomenta& p = balance.momenta;
  body_turn_changes(system, interval.rotation, first.left, first_rate.turn, second.left, work.turn_change);
  body_turn_changes(system, interval.next_rotation, first.right, first_rate.turn_next, second.right,
                    work.turn_change_next);
  centre_second_rates(system, interval, first_rate, second_rate, work.turn_change, work.turn_change_next,
                      work.centre_change);

  const NodeTurns left_1{first.left, first_rate.turn}, right_1{first.right, first_rate.turn_next};
  const NodeTurns left_2{second.left, second_rate.turn}, right_2{second.right, second_rate.turn_next};
  work.joint_minus.set_zero();
  work.joint_plus.set_zero();
  add_damping_second_rates(system, interval, {left_1, right_1, -1.0}, {left_2, right_2, 1.0}, work.turn_change,
                           work.turn_change_next, 1.0, 1.0, work.joint_minus, work.joint_plus);
  const double half = 0.5 * step.time_step;
  add_node_moment_second_rates(system, interval.rotation, step.control, left_1, left_2, work.turn_change,
                               second.control, -half, work.joint_minus);
  add_node_moment_second_rates(system, interval.next_rotation, step.control_next, right_1, right_2,
                               work.turn_change_next, second.control_next, half, work.joint_plus);

  for (int i = 0; i < system.body_count(); ++i) {
    const std::size_t n = at(i);
    if (second_rate.still[n]) {
      work.force[n].setZero();
      work.moment[n] = work.joint_minus.body[n];
      work.moment_next[n] = work.joint_plus.body[n];
      continue;
    }
    const BodyLagrangian body(system, step.lagrangian, step.time_step, i);
    const BodyStep moved = body_step(interval, p, i);
    const SecondMomenta<Vector3d> momenta = second_momenta(
        first_motion(interval, p, first_rate, n),
        SecondMotion<Vector3d>{second_rate.turn[n], second_rate.seen[n], second_rate.gradient[n], work.turn_change[n],
                               work.turn_change_next[n], work.centre_change[n]},
        [&](const BodyDirection& along) { return body.gradient_second_rate(moved, first_rate.seen[n], along); },
        [&](const BodyDirection& along) { return body.gradient_rate(moved, along); });
    work.force[n] = momenta.force;
    work.moment[n] = momenta.moment + work.joint_minus.body[n];
    work.moment_next[n] = momenta.next + work.joint_plus.body[n];
  }
  sum_subtrees(system, work.force);
  linear = work.force[0];
  gather_second_rate(system, interval.rotation, p.subtree_linear, balance.moment,
                     {first.left, first_rate.turn, first_rate.force}, first_rate.moment,
                     {second.left, second_rate.turn, second_rate.force}, second_rate.moment, work.turn_change,
                     work.force, work.moment, minus);
  gather_second_rate(system, interval.next_rotation, p.subtree_linear, balance.moment_next,
                     {first.right, first_rate.turn_next, first_rate.force}, first_rate.moment_next,
                     {second.right, second_rate.turn_next, second_rate.force}, second_rate.moment_next,
                     work.turn_change_next, work.force, work.moment_next, plus);
  add(work.joint_minus.along, minus);
  add(work.joint_plus.along, plus);
  add_brackets(system, first.left, second_rate.minus, 1.0, minus);
  add_brackets(system, first.right, second_rate.plus, 1.0, plus);
  for (Vector3d& entry : minus) entry = -entry;
}

void set_block(const Interval& interval, const DiscreteMomenta& p, const BodyHessian& H, std::size_t n,
               BodyBlock& block) {
  const Matrix3d& R = interval.rotation[n];
  const Matrix3d& F = interval.relative_rotation[n];
  const Matrix3d w = hat(p.shift[n]);
  block.moment_by_turn = F * (H.turn_by_turn - hat(p.turn[n])) + w * H.shift_by_turn;
  block.moment_by_shift = (F * H.turn_by_shift - hat(p.impulse[n]) + w * H.shift_by_shift) * R.transpose();
  block.force_by_turn = R * H.shift_by_turn;
  block.force_by_shift = R * H.shift_by_shift * R.transpose();
}

void step_blocks(const System& system, DiscreteLagrangian lagrangian, double time_step, const Interval& interval,
                 const DiscreteMomenta& p, std::vector<BodyBlock>& blocks) {
  if (all_plain(system, lagrangian)) {
    for_each_four(blocks.size(), [&](const FourBodies& four) {
      four_blocks(system, lagrangian, time_step, interval, p, four, blocks);
    });
    return;
  }
  for (int i = 0; i < system.body_count(); ++i) {
    const BodyLagrangian body(system, lagrangian, time_step, i);
    set_block(interval, p, body.hessian(body_step(interval, p, i)), at(i), blocks[at(i)]);
  }
}

}  // namespace lamprey::mechanics
