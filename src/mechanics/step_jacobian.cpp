#include "mechanics/step_jacobian.hpp"

#include <algorithm>

namespace lamprey::mechanics {

namespace {

using Eigen::Index;
using lie::hat;
using model::at;
using model::Body;
using model::Joint;
using model::System;

// Which rows turn the left end, which turn the right end and displace the root, and all of them.
struct Ends {
  RowRange left, right, all;
};

// Displacement that turns at one node (sign +1: the next one, −1: this one) give a mass centre, seen from its parent's.
void add_centre_turns(const System& system, const Rotations& R, int i, double sign,
                      const std::vector<SparseRows>& turns, RowRange range, Rows3& centre) {
  const Joint& up = system.joint(system.body(i).joint);
  add_product(lie::times_hat(R[at(up.parent)], -sign * up.parent_offset), turns[at(up.parent)], range, centre);
  add_product(lie::times_hat(R[at(i)], sign * up.child_offset), turns[at(i)], range, centre);
}

// Displacements of the mass centres, and the forces that come of all motions.
void add_up_forces(const System& system, const Interval& interval, const std::vector<BodyBlock>& blocks,
                   const std::vector<BodyRates>& rates, const StepDirections& d, const Ends& ends, StepJacobian& J) {
  for (int i : system.root_to_leaves()) {
    const std::size_t n = at(i);
    const int parent = system.body(i).parent;
    if (parent < 0) {
      clear_rows(ends.all, J.centre[n]);
      copy_rows(d.displacement, ends.right, J.centre[n]);
    } else {
      copy_rows(J.centre[at(parent)], ends.all, J.centre[n]);
      add_centre_turns(system, interval.rotation, i, -1.0, J.turn, ends.left, J.centre[n]);
      add_centre_turns(system, interval.next_rotation, i, 1.0, J.turn_next, ends.right, J.centre[n]);
    }
    set_product(blocks[n].force_by_shift, J.centre[n], ends.all, J.force[n]);
    add_product(blocks[n].force_by_turn, J.turn_next[n], ends.right, J.force[n]);
    add_product(rates[n].force_by_left, J.turn[n], ends.left, J.force[n]);
  }
  sum_row_subtrees(system, ends.all, J.force);
}

// Controls and springs at a node.
void add_node_rows(const System& system, const Rotations& R, const Moments& control, double weight,
                   const FreedomRows& freedoms, const std::vector<SparseRows>& turns, RowRange range, Rows3& relative,
                   FreedomRows& moment, FreedomRows& along) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    Rows3& on_child = moment[at(joint.child)];
    if (!joint.free()) {
      if (joint.stiffness > 0.0)
        add_rows(-weight * joint.stiffness, freedoms[at(joint.child)], range, along[at(joint.child)]);
      continue;
    }
    const Matrix3d Q = child_to_parent(R, joint);
    // −y on the child turns by ρ × y; the parent's moment stays
    const Matrix3d y = hat(weight * (Q.transpose() * control[at(j)]));
    add_product(-y, turns[at(joint.child)], range, on_child);
    add_product(y * Q.transpose(), turns[at(joint.parent)], range, on_child);
    if (joint.stiffness == 0.0) continue;
    const Vector3d phi = lie::log(joint.reference_rotation.transpose() * Q);
    const double k = weight * joint.stiffness;
    const Matrix3d T = -k * lie::log_tangent(phi);
    relative_rows(joint, Q, turns, range, relative);
    add_product(T, relative, range, on_child);
    add_product(-Q * (T + k * hat(phi)), relative, range, moment[at(joint.parent)]);
  }
}

// Rate of a damped ball joint's impulse along turns ρ and ρ' is `left` ρ + `right` ρ'.
struct DampedBall {
  DampedBall(const Interval& step, const Joint& joint)
      : Q(child_to_parent(step.rotation, joint)), Q_next(child_to_parent(step.next_rotation, joint)) {
    const Matrix3d D = Q.transpose() * Q_next;
    impulse = 0.5 * joint.damping * lie::log(D);
    right = 0.5 * joint.damping * lie::log_tangent(lie::log(D));
    left = -right * D.transpose();
  }
  Matrix3d Q, Q_next, left, right;
  Vector3d impulse;
};

// Adds `sign` × the rates of dampers' momenta at one node: there their moments turn with `turned` rows of turns.
void add_damping_rows(const System& system, const Interval& step, const StepDirections& d, const Ends& ends,
                      double sign, bool at_end, StepJacobian& J, FreedomRows& moment, FreedomRows& along) {
  for (const Joint& joint : system.joints()) {
    if (joint.damping == 0.0) continue;
    const std::size_t c = at(joint.child);
    if (!joint.free()) {
      add_rows(-sign * 0.5 * joint.damping, d.left[c], ends.left, along[c]);
      add_rows(sign * 0.5 * joint.damping, d.right[c], ends.right, along[c]);
      continue;
    }
    const DampedBall ball(step, joint);
    const Matrix3d& Q = at_end ? ball.Q_next : ball.Q;
    relative_rows(joint, ball.Q, J.turn, ends.left, J.relative);
    relative_rows(joint, ball.Q_next, J.turn_next, ends.right, J.relative_next);
    clear_rows(ends.all, J.rate);
    add_product(ball.left, J.relative, ends.left, J.rate);
    add_product(ball.right, J.relative_next, ends.right, J.rate);
    // a moment of the impulse on the child, its opposite on the parent
    add_rows(sign, J.rate, ends.all, moment[c]);
    add_product(-sign * Q, J.rate, ends.all, moment[at(joint.parent)]);
    add_product(sign * (Q * hat(ball.impulse)), at_end ? J.relative_next : J.relative, at_end ? ends.right : ends.left,
                moment[at(joint.parent)]);
  }
}

// Rates of gather's result, added to `result`; of all rows, of which `turned` turn the bodies at this node.
void gather_rows(const System& system, const Rotations& R, const Vectors& force, const Vectors& moment,
                 const FreedomRows& freedoms, const std::vector<SparseRows>& turns, RowRange all, RowRange turned,
                 const FreedomRows& force_rows, FreedomRows& moment_rows, FreedomRows& result) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    Rows3& rows = moment_rows[at(i)];
    Rows3& out = result[at(i)];
    if (body.parent < 0) {
      add_rows(1.0, rows, all, out);
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const std::size_t p = at(body.parent);
    Rows3& parent_rows = moment_rows[p];
    const auto add_lever = [&](std::size_t b, const Vector3d& lever, Rows3& sum) {  // lever × rate of RᵀP
      add_product(-lie::times_hat(R[b], lever).transpose(), force_rows[at(i)], all, sum);
      add_product(lie::times_hat(hat(lever), R[b].transpose() * force[at(i)]), turns[b], turned, sum);
    };
    add_lever(at(i), -joint.child_offset, rows);
    add_lever(p, joint.parent_offset, parent_rows);
    if (joint.free()) {
      add_rows(1.0, rows, all, out);
      continue;
    }
    const JointFrame frame = joint_frame(joint, R[p], R[at(i)]);
    add_product(frame.axes.transpose(), rows, all, out);
    if (joint.kind == model::JointKind::universal) {  // the first axis moves with the second angle
      const Eigen::Index count = turned.end - turned.first;
      const double moved = frame.axes.col(0).cross(joint.child_axis).dot(moment[at(i)]);
      algebra::add_multiple(moved, freedoms[at(i)].col(1).segment(turned.first, count),
                            out.col(0).segment(turned.first, count));
    }
    add_product(frame.child_to_parent, rows, all, parent_rows);
    add_product(-frame.child_to_parent * hat(moment[at(i)]) * frame.axes, freedoms[at(i)], turned, parent_rows);
  }
}

void minus_rows(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
                const std::vector<BodyRates>& rates, const StepDirections& d, const Ends& ends, StepJacobian& J) {
  const System& system = step.system;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    set_product(blocks[n].moment_by_shift, J.centre[n], ends.all, J.moment[n]);
    add_product(rates[n].moment_by_left, J.turn[n], ends.left, J.moment[n]);
    add_product(blocks[n].moment_by_turn, J.turn_next[n], ends.right, J.moment[n]);
    clear_rows(ends.all, J.minus[n]);
  }
  const Rotations& R = step.interval.rotation;
  add_node_rows(system, R, step.control, -0.5 * step.time_step, d.left, J.turn, ends.left, J.relative, J.moment,
                J.minus);
  add_damping_rows(system, step.interval, d, ends, 1.0, false, J, J.moment, J.minus);
  gather_rows(system, R, balance.momenta.subtree_linear, balance.moment, d.left, J.turn, ends.all, ends.left, J.force,
              J.moment, J.minus);
}

void plus_rows(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
               const std::vector<BodyRates>& rates, const StepDirections& d, const Ends& ends, StepJacobian& J) {
  const System& system = step.system;
  for (std::size_t n = 0; n < blocks.size(); ++n) {
    set_product(rates[n].next_by_shift, J.centre[n], ends.all, J.moment_next[n]);
    add_product(rates[n].next_by_left, J.turn[n], ends.left, J.moment_next[n]);
    add_product(rates[n].hessian.turn_by_turn, J.turn_next[n], ends.right, J.moment_next[n]);
    clear_rows(ends.all, J.plus[n]);
  }
  const Rotations& R = step.interval.next_rotation;
  add_node_rows(system, R, step.control_next, 0.5 * step.time_step, d.right, J.turn_next, ends.right, J.relative,
                J.moment_next, J.plus);
  add_damping_rows(system, step.interval, d, ends, -1.0, true, J, J.moment_next, J.plus);
  gather_rows(system, R, balance.momenta.subtree_linear, balance.moment_next, d.right, J.turn_next, ends.all,
              ends.right, J.force, J.moment_next, J.plus);
}

// As body_rates, the Hessian's blocks put in (equations 4.15 and 8.29).
void four_rates(const ForcedStep& step, const DiscreteMomenta& p, const FourBodies& four,
                std::vector<BodyBlock>& blocks, std::vector<BodyRates>& rates) {
  const FourShares of(step.system, step.lagrangian, step.time_step, step.interval, four);
  const Four3 w = four.read(p.shift);
  const Four3 turn = four.read(p.turn), impulse = four.read(p.impulse);
  const Four33 Ft = transposed(of.F), Rt = transposed(of.R);
  const auto translation = of.with_shift(w).translation_hessian();
  const Four33 Xt = Ft * of.trace_weight;
  const Four33 turn_by_turn = of.rate * (translation.turn_by_turn + minus_diagonal(-1.0 * Xt, -trace(Xt)));
  const Four33 shift_by_turn = of.rate * translation.shift_by_turn;
  const Four33 turn_by_shift = transposed(shift_by_turn);
  const Four33 shift_by_shift = of.rate * translation.shift_by_shift;
  four.write(turn_by_turn, rates, &BodyRates::hessian, &BodyHessian::turn_by_turn);
  four.write(turn_by_shift, rates, &BodyRates::hessian, &BodyHessian::turn_by_shift);
  four.write(shift_by_turn, rates, &BodyRates::hessian, &BodyHessian::shift_by_turn);
  four.write(shift_by_shift, rates, &BodyRates::hessian, &BodyHessian::shift_by_shift);

  const Four33 moment_by_turn = of.F * plus_hat(turn_by_turn, -turn) + hat_times(w, shift_by_turn);
  const Four33 moment_by_shift = plus_hat(of.F * turn_by_shift + hat_times(w, shift_by_shift), -impulse) * Rt;
  const Four33 force_by_turn = of.R * shift_by_turn;
  const Four33 force_by_shift = of.R * shift_by_shift * Rt;
  four.write(moment_by_turn, blocks, &BodyBlock::moment_by_turn);
  four.write(moment_by_shift, blocks, &BodyBlock::moment_by_shift);
  four.write(force_by_turn, blocks, &BodyBlock::force_by_turn);
  four.write(force_by_shift, blocks, &BodyBlock::force_by_shift);

  const Four33 Rw = times_hat(of.R, w);  // w × η as a displacement
  four.write(force_by_shift * Rw - force_by_turn * Ft - times_hat(of.R, impulse), rates, &BodyRates::force_by_left);
  four.write(moment_by_shift * Rw - moment_by_turn * Ft, rates, &BodyRates::moment_by_left);
  four.write(turn_by_shift * Rt, rates, &BodyRates::next_by_shift);
  four.write(times_hat(turn_by_shift, w) - turn_by_turn * Ft, rates, &BodyRates::next_by_left);
}

}  // namespace

StepDirections::StepDirections(int bodies, Index directions)
    : left(at(bodies), Rows3::Zero(rows_for(directions), 3)),
      right(left),
      displacement(Rows3::Zero(rows_for(directions), 3)),
      left_support(at(bodies)),
      right_support(at(bodies)) {}

StepJacobian::StepJacobian(int bodies, Index directions)
    : minus(at(bodies), Rows3::Zero(rows_for(directions), 3)),
      plus(minus),
      linear(Rows3::Zero(rows_for(directions), 3)),
      turn(at(bodies), SparseRows{linear, Support()}),
      turn_next(turn),
      centre(minus),
      force(minus),
      moment(minus),
      moment_next(minus),
      relative(linear),
      relative_next(linear),
      rate(linear) {}

// With a = η' − Fᵀη and b = w × η + Rᵀδ inserted into the rates of P, π⁻ and π⁺.
void body_rates(const ForcedStep& step, const DiscreteMomenta& p, std::vector<BodyBlock>& blocks,
                std::vector<BodyRates>& rates) {
  if (all_plain(step.system, step.lagrangian)) {
    for_each_four(blocks.size(), [&](const FourBodies& four) { four_rates(step, p, four, blocks, rates); });
    return;
  }
  for (int i = 0; i < step.system.body_count(); ++i) {
    const std::size_t n = at(i);
    const BodyHessian& H = rates[n].hessian =
        BodyLagrangian(step.system, step.lagrangian, step.time_step, i).hessian(body_step(step.interval, p, i));
    set_block(step.interval, p, H, n, blocks[n]);
    const Matrix3d& R = step.interval.rotation[n];
    const Matrix3d Ft = step.interval.relative_rotation[n].transpose();
    const Vector3d& w = p.shift[n];
    const Matrix3d Rw = lie::times_hat(R, w);  // w × η as a displacement
    const BodyBlock& block = blocks[n];
    BodyRates& by = rates[n];
    by.force_by_left = block.force_by_shift * Rw - block.force_by_turn * Ft - lie::times_hat(R, p.impulse[n]);
    by.moment_by_left = block.moment_by_shift * Rw - block.moment_by_turn * Ft;
    by.next_by_shift = H.turn_by_shift * R.transpose();
    by.next_by_left = lie::times_hat(H.turn_by_shift, w) - H.turn_by_turn * Ft;
  }
}

void turns_of_rows(const System& system, const Rotations& R, const FreedomRows& freedoms,
                   const std::vector<Support>& supports, RowRange range, std::vector<SparseRows>& turns) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    SparseRows& turn = turns[at(i)];
    if (body.freedoms == 3) {
      turn.support = supports[at(i)];
      copy_rows(freedoms[at(i)], turn.others(range), turn.rows);
      continue;
    }
    const JointFrame frame = joint_frame(system.joint(body.joint), R[at(body.parent)], R[at(i)]);
    set_product(frame.axes, freedoms[at(i)], range, turn.rows);
    add_product(frame.child_to_parent.transpose(), turns[at(body.parent)], range, turn.rows);
  }
}

void relative_rows(const Joint& joint, const Matrix3d& Q, const std::vector<SparseRows>& turns, RowRange range,
                   Rows3& relative) {
  clear_rows(range, relative);
  add_product(-Q.transpose(), turns[at(joint.parent)], range, relative);
  add_product(Matrix3d::Identity(), turns[at(joint.child)], range, relative);
}

void sum_row_subtrees(const System& system, RowRange range, FreedomRows& force) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position)
    if (system.body(*position).parent >= 0)
      add_rows(1.0, force[at(*position)], range, force[at(system.body(*position).parent)]);
}

void rates_at_both_ends(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
                        const std::vector<BodyRates>& rates, const StepDirections& d, Index left_count, Index count,
                        StepJacobian& J) {
  const Ends ends{left_count, {left_count, count}, count};
  turns_of_rows(step.system, step.interval.rotation, d.left, d.left_support, ends.left, J.turn);
  turns_of_rows(step.system, step.interval.next_rotation, d.right, d.right_support, ends.right, J.turn_next);
  add_up_forces(step.system, step.interval, blocks, rates, d, ends, J);
  copy_rows(J.force[0], ends.all, J.linear);
  minus_rows(step, balance, blocks, rates, d, ends, J);
  plus_rows(step, balance, blocks, rates, d, ends, J);
}

void control_columns(const System& system, const Rotations& R, double weight, Eigen::Ref<Eigen::MatrixXd> columns) {
  columns.setZero();
  Index first = 0;
  for (const Joint& joint : system.joints()) {
    const Index count = joint.actuation.cols();
    const auto add = [&](int b, double sign, const Matrix3d& moments) {
      const Body& body = system.body(b);
      double* column = columns.data() + first * columns.outerStride() + body.velocity_offset;
      for (Index c = 0; c < count; ++c, column += columns.outerStride()) {
        if (body.freedoms == 3) {
          for (int f = 0; f < 3; ++f) column[f] += sign * moments(f, c);
        } else {
          for (int f = 0; f < body.freedoms; ++f) column[f] += sign * moments(f, c);
        }
      }
    };
    Matrix3d moments = Matrix3d::Zero();
    for (Index e = 0; e < 3 * count; ++e) moments.data()[e] = weight * joint.actuation.data()[e];
    if (joint.free()) {
      add(joint.child, -1.0, R[at(joint.child)].transpose() * (R[at(joint.parent)] * moments));
      // the parent's share goes on to where the parent may turn
      int b = joint.parent;
      while (system.body(b).freedoms < 3) {
        const Joint& up = system.joint(system.body(b).joint);
        const JointFrame frame = joint_frame(up, R[at(up.parent)], R[at(b)]);
        add(b, 1.0, frame.axes.transpose() * moments);
        moments = frame.child_to_parent * moments;
        b = up.parent;
      }
      add(b, 1.0, moments);
    } else {
      add(joint.child, -1.0, moments);
    }
    first += count;
  }
}

}  // namespace lamprey::mechanics
