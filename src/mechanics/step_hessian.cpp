#include "mechanics/step_hessian.hpp"

#include "mechanics/second_momenta.hpp"

namespace lamprey::mechanics {

namespace {

using Eigen::Index;
using lie::hat;
using model::at;
using model::Body;
using model::Joint;
using model::System;

// Columns of the momenta's rates, one unit direction after the other; `of` gives a direction's second momenta.
template <typename Of>
BodyMomentaRates three_columns(const Of& of) {
  BodyMomentaRates by;
  const SecondMomenta<Four3> momenta = of();
  read_columns(momenta.force, by.force);
  read_columns(momenta.moment, by.moment);
  read_columns(momenta.next, by.next);
  return by;
}

// Rates of what a body's momenta's rates along the first direction are (constant turns), by a second direction: its part
// in evaluate_adjoint_rate as matrices. Its share has this Hessian.
void body_second_rates(const ForcedStep& step, const StepBalance& balance, const StepRate& first_rate,
                       const BodyHessian& H, int i, BodySecondRates& rates) {
  const std::size_t n = at(i);
  const BodyLagrangian body(step.system, step.lagrangian, step.time_step, i);
  const BodyStep moved = body_step(step.interval, balance.momenta, i);
  const auto first = first_motion(step.interval, balance.momenta, first_rate, n);
  const Four3 none = Four3::zero();
  const auto along = [&](const Four3& turn, const TurnAndShift<Four3>& seen, const TurnAndShift<Four3>& rate) {
    return three_columns([&] {
      return second_momenta(
          first, SecondMotion<Four3>{turn, seen, rate, none, none, none},
          [&](const TurnAndShift<Four3>& d) { return body.gradient_second_rate(moved, first_rate.seen[n], d); },
          [&](const TurnAndShift<Four3>& d) {
            return TurnAndShift<Four3>{H.turn_by_turn * d.turn + H.turn_by_shift * d.shift,
                                       H.shift_by_turn * d.turn + H.shift_by_shift * d.shift};
          });
    });
  };
  const Matrix3d Ft = first.F.transpose();
  const Matrix3d Rt = first.R.transpose();
  const Matrix3d w = hat(first.w);
  const Four3 unit = columns(Matrix3d::Identity());
  rates.by_left =
      along(unit, {columns(-Ft), columns(w)},
            {columns(H.turn_by_shift * w - H.turn_by_turn * Ft), columns(H.shift_by_shift * w - H.shift_by_turn * Ft)});
  rates.by_right = along(none, {unit, none}, {columns(H.turn_by_turn), columns(H.shift_by_turn)});
  rates.by_shift = along(none, {none, columns(Rt)}, {columns(H.turn_by_shift * Rt), columns(H.shift_by_shift * Rt)});
}

// The same of four bodies, a direction after the other.
void four_second_rates(const ForcedStep& step, const StepBalance& balance, const StepRate& first_rate,
                       const std::vector<BodyRates>& body_rates, const FourBodies& four,
                       std::vector<BodySecondRates>& rates) {
  const DiscreteMomenta& p = balance.momenta;
  const FourShares of(step.system, step.lagrangian, step.time_step, step.interval, four);
  const Four3 w = four.read(p.shift);
  const FirstMotion<Four33, Four3> first(of.R, of.F, w, {four.read(p.turn), four.read(p.impulse)},
                                         four.read(first_rate.turn), four.read(first_rate.centre),
                                         four.read(first_rate.seen), four.read(first_rate.gradient));
  const PlainShare<Four33, Four3> share = of.with_shift(w);
  const PlainSecondRate<Four33, Four3> second_rate(share, first.seen);
  const auto hessian = [&](Matrix3d BodyHessian::*part) { return four.read(body_rates, &BodyRates::hessian, part); };
  const Four33 turn_by_turn = hessian(&BodyHessian::turn_by_turn), turn_by_shift = hessian(&BodyHessian::turn_by_shift),
               shift_by_turn = hessian(&BodyHessian::shift_by_turn),
               shift_by_shift = hessian(&BodyHessian::shift_by_shift);
  const auto rate = [&](const TurnAndShift<Four3>& d) {
    return TurnAndShift<Four3>{turn_by_turn * d.turn + turn_by_shift * d.shift,
                               shift_by_turn * d.turn + shift_by_shift * d.shift};
  };
  const Four3 none = Four3::zero();
  const auto along = [&](const Four33& turn, const Four33& a, const Four33& b, BodyMomentaRates BodySecondRates::*by) {
    Four33 force, moment, next;
    for (const auto column : {&Four33::x, &Four33::y, &Four33::z}) {
      const TurnAndShift<Four3> seen{a.*column, b.*column};
      const SecondMomenta<Four3> momenta = second_momenta(
          first, SecondMotion<Four3>{turn.*column, seen, rate(seen), none, none, none},
          [&](const TurnAndShift<Four3>& d) { return second_rate.along_second(d); }, rate);
      force.*column = momenta.force;
      moment.*column = momenta.moment;
      next.*column = momenta.next;
    }
    four.write(force, rates, by, &BodyMomentaRates::force);
    four.write(moment, rates, by, &BodyMomentaRates::moment);
    four.write(next, rates, by, &BodyMomentaRates::next);
  };
  const Four33 zero{none, none, none}, unit = plus_identity(zero);
  along(unit, -1.0 * transposed(of.F), plus_hat(zero, w), &BodySecondRates::by_left);
  along(zero, unit, zero, &BodySecondRates::by_right);
  along(zero, zero, transposed(of.R), &BodySecondRates::by_shift);
}

// A node of the step: where the bodies are, how the first direction turns them, and what turns them in rows.
struct NodeRows {
  const Rotations& R;
  const Freedoms& first;                // freedoms
  const Vectors& first_turn;            // [bodies]
  const Vectors& first_moment;          // [bodies] through the joints
  const Vectors& moment;                // [bodies] through the joints
  const FreedomRows& freedoms;          // of the rows
  const std::vector<SparseRows>& turn;  // [bodies]
  const FreedomRows& second_moment;     // [bodies] rates of `moment`
  RowRange turned;                      // rows that turn the bodies here
};

// Whether turns along the first direction change when the bodies turn.
bool turn_changes(const Body& body) { return body.freedoms < 3; }

// Equation 8.4 for rows: body_turn_changes of the first direction along each.
void turn_change_rows(const System& system, const NodeRows& node, FreedomRows& changes) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    if (!turn_changes(body)) continue;
    const Joint& joint = system.joint(body.joint);
    const std::size_t p = at(body.parent);
    const JointFrame frame = joint_frame(joint, node.R[p], node.R[at(i)]);
    const Matrix3d Qt = frame.child_to_parent.transpose();
    Matrix3d by_freedoms = hat(Qt * node.first_turn[p]) * frame.axes;
    if (joint.kind == model::JointKind::universal)
      by_freedoms.col(1) += node.first[at(i)][0] * frame.axes.col(0).cross(joint.child_axis);
    set_product(by_freedoms, node.freedoms[at(i)], node.turned, changes[at(i)]);
    if (turn_changes(system.body(body.parent))) add_product(Qt, changes[p], node.turned, changes[at(i)]);
  }
}

// Second rates of the displacements of mass centres.
void add_centre_changes(const System& system, const NodeRows& node, int i, double sign, const FreedomRows& changes,
                        Rows3& centre) {
  const Joint& up = system.joint(system.body(i).joint);
  const auto add = [&](int b, const Vector3d& offset) {
    const Matrix3d& R = node.R[at(b)];
    add_product(lie::times_hat(R, -node.first_turn[at(b)].cross(offset)), node.turn[at(b)], node.turned, centre);
    if (turn_changes(system.body(b))) add_product(lie::times_hat(R, -offset), changes[at(b)], node.turned, centre);
  };
  add(up.parent, sign * up.parent_offset);
  add(i, -sign * up.child_offset);
}

// ρ_12 = η_12,c − Qᵀη_12,p + ρ_2 × Qᵀη_1,p of a ball joint, its rows of ρ_2 known.
void relative_change_rows(const System& system, const Joint& joint, const Matrix3d& Q, const NodeRows& node,
                          const FreedomRows& changes, const Rows3& relative, Rows3& result) {
  set_product(-hat(Q.transpose() * node.first_turn[at(joint.parent)]), relative, node.turned, result);
  if (turn_changes(system.body(joint.parent)))
    add_product(-Q.transpose(), changes[at(joint.parent)], node.turned, result);
}

// Columns of log_tangent_rate(φ, T e) ρ: how T ρ changes when φ does.
Matrix3d tangent_change(const Vector3d& phi, const Matrix3d& T, const Vector3d& turn) {
  Matrix3d change;
  for (int c = 0; c < 3; ++c) change.col(c) = lie::log_tangent_rate(phi, T.col(c)) * turn;
  return change;
}

// Controls and springs of ball joints at a node (equation 8.19); along axes all rates are constant.
void add_node_second_rows(const System& system, const NodeRows& node, const Moments& control, double weight,
                          const FreedomRows& changes, StepHessian& H, FreedomRows& moment) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    if (!joint.free()) continue;
    const Matrix3d Q = child_to_parent(node.R, joint);
    const Vector3d turn = node.first_turn[at(joint.child)] - Q.transpose() * node.first_turn[at(joint.parent)];
    relative_rows(joint, Q, node.turn, node.turned, H.relative);
    relative_change_rows(system, joint, Q, node, changes, H.relative, H.change);
    Matrix3d by_change = -hat(weight * control[at(j)]) * Q;
    Matrix3d by_relative = -by_change * hat(turn);
    if (const double k = weight * joint.stiffness; k != 0.0) {
      const Vector3d phi = lie::log(joint.reference_rotation.transpose() * Q);
      const Matrix3d T = lie::log_tangent(phi);
      const Vector3d phi_1 = T * turn;
      const Matrix3d T_change = tangent_change(phi, T, turn);
      add_product(-k * T, H.change, node.turned, moment[at(joint.child)]);
      add_product(-k * T_change, H.relative, node.turned, moment[at(joint.child)]);
      by_change += k * Q * (T - hat(phi));
      by_relative += k * Q * (hat(turn) * T + T_change - hat(turn.cross(phi) + phi_1));
    }
    add_product(by_change, H.change, node.turned, moment[at(joint.parent)]);
    add_product(by_relative, H.relative, node.turned, moment[at(joint.parent)]);
  }
}

// Dampers of ball joints.
void add_damping_second_rows(const System& system, const Interval& interval, const NodeRows& left,
                             const NodeRows& right, RowRange all, StepHessian& H) {
  for (const Joint& joint : system.joints()) {
    if (joint.damping == 0.0 || !joint.free()) continue;
    const std::size_t c = at(joint.child), p = at(joint.parent);
    const Matrix3d Q = child_to_parent(interval.rotation, joint);
    const Matrix3d Q_next = child_to_parent(interval.next_rotation, joint);
    const Matrix3d Dt = Q_next.transpose() * Q;
    const Vector3d value = lie::log(Dt.transpose());
    const Matrix3d T = lie::log_tangent(value);
    // the right end of the first direction counts the other way round
    const Vector3d left_1 = left.first_turn[c] - Q.transpose() * left.first_turn[p];
    const Vector3d right_1 = Q_next.transpose() * right.first_turn[p] - right.first_turn[c];
    const Vector3d turn_1 = right_1 - Dt * left_1;
    const Vector3d rate_1 = T * turn_1;
    relative_rows(joint, Q, left.turn, left.turned, H.relative);
    relative_rows(joint, Q_next, right.turn, right.turned, H.relative_next);
    relative_change_rows(system, joint, Q, left, H.turn_change, H.relative, H.change);
    relative_change_rows(system, joint, Q_next, right, H.turn_change_next, H.relative_next, H.change_next);

    // of the turn over the step: Λ (ρ'_12 − Dᵀρ_12 + (ρ'_2 − Dᵀρ_2) × Dᵀρ_1) and what Λ's change adds
    const Matrix3d by_turn = tangent_change(value, T, turn_1) - T * hat(Dt * left_1);
    clear_rows(all, H.rate);
    clear_rows(all, H.rate_change);
    add_product(T, H.relative_next, right.turned, H.rate);
    add_product(-T * Dt, H.relative, left.turned, H.rate);
    add_product(by_turn, H.relative_next, right.turned, H.rate_change);
    add_product(-by_turn * Dt, H.relative, left.turned, H.rate_change);
    add_product(-T, H.change_next, right.turned, H.rate_change);
    add_product(-T * Dt, H.change, left.turned, H.rate_change);

    const double half = 0.5 * joint.damping;
    const auto add = [&](const Matrix3d& attitude, const Vector3d& first, double sign, const Rows3& relative,
                         const Rows3& change, RowRange turned, RowRange asked, FreedomRows& moment) {
      const Matrix3d on_parent = -half * attitude;
      add_rows(half, H.rate_change, asked, moment[c]);
      add_product(on_parent, H.rate_change, asked, moment[p]);
      add_product(on_parent * hat(first), H.rate, asked, moment[p]);
      add_product(-on_parent * hat(first.cross(value) + rate_1), relative, turned, moment[p]);
      add_product(-sign * on_parent * hat(value), change, turned, moment[p]);
    };
    add(Q, left_1, 1.0, H.relative, H.change, left.turned, all, H.moment);
    add(Q_next, right_1, -1.0, H.relative_next, H.change_next, right.turned, right.turned, H.moment_next);
  }
}

// gather_second_rate for rows (equation 8.7), of `all` rows.
void gather_second_rows(const System& system, const NodeRows& node, const Vectors& force, const Vectors& first_force,
                        const FreedomRows& second_force, const FreedomRows& changes, const FreedomRows& force_rows,
                        RowRange all, FreedomRows& moment_rows, FreedomRows& result) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const std::size_t n = at(i);
    const Body& body = system.body(i);
    Rows3& rows = moment_rows[n];
    if (body.parent < 0) {
      copy_rows(rows, all, result[n]);
      continue;
    }
    const Joint& joint = system.joint(body.joint);
    const std::size_t p = at(body.parent);
    const auto add_lever = [&](std::size_t b, const Vector3d& lever, Rows3& sum) {  // lever × second rate of RᵀP
      const Matrix3d Rt = node.R[b].transpose();
      const Vector3d& turn = node.first_turn[b];
      const Vector3d seen = Rt * force[n];
      const Matrix3d moment_of = hat(lever);
      const Matrix3d pulled = moment_of * Rt;
      add_product(pulled, force_rows[n], all, sum);
      add_product(-lie::times_hat(moment_of, turn) * Rt, second_force[n], all, sum);
      add_product(moment_of * (hat(Rt * first_force[n]) - hat(turn) * hat(seen)), node.turn[b], node.turned, sum);
      if (turn_changes(system.body(static_cast<int>(b))))
        add_product(lie::times_hat(moment_of, seen), changes[b], node.turned, sum);
    };
    add_lever(n, -joint.child_offset, rows);
    add_lever(p, joint.parent_offset, moment_rows[p]);
    if (joint.free()) {
      copy_rows(rows, all, result[n]);
      continue;
    }
    const JointFrame frame = joint_frame(joint, node.R[p], node.R[n]);
    const Matrix3d& Q = frame.child_to_parent;
    const Vector3d& sigma_1 = node.first[n];
    const Vector3d turn_1 = frame.axes * sigma_1;
    Matrix3d by_freedoms = -hat(turn_1.cross(node.moment[n]) + node.first_moment[n]) * frame.axes;
    Matrix3d along_freedoms = Matrix3d::Zero();
    Matrix3d along_moment = Matrix3d::Zero();
    if (joint.kind == model::JointKind::universal) {
      const Vector3d axis = frame.axes.col(0).cross(joint.child_axis);  // its first axis moves by σ[1] times this
      along_freedoms(0, 1) =
          axis.dot(node.first_moment[n]) + sigma_1[1] * axis.cross(joint.child_axis).dot(node.moment[n]);
      along_moment.row(0) = sigma_1[1] * axis.transpose();
      by_freedoms.col(1) += sigma_1[0] * axis.cross(node.moment[n]);
    }
    set_product(frame.axes.transpose(), rows, all, result[n]);
    add_product(along_freedoms, node.freedoms[n], node.turned, result[n]);
    add_product(along_moment, node.second_moment[n], all, result[n]);
    add_product(Q, rows, all, moment_rows[p]);
    add_product(Q * hat(turn_1), node.second_moment[n], all, moment_rows[p]);
    add_product(Q * by_freedoms, node.freedoms[n], node.turned, moment_rows[p]);
  }
}

// Bodies that turn on their own: what fields that do not commute leave.
void add_bracket_rows(const System& system, const Freedoms& turn, const FreedomRows& momentum, RowRange range,
                      FreedomRows& result) {
  for (int i = 0; i < system.body_count(); ++i)
    if (system.body(i).freedoms == 3) add_product(hat(turn[at(i)]), momentum[at(i)], range, result[at(i)]);
}

}  // namespace

StepHessian::StepHessian(int bodies, Index directions)
    : minus(at(bodies), Rows3::Zero(rows_for(directions), 3)),
      plus(minus),
      linear(Rows3::Zero(rows_for(directions), 3)),
      body(at(bodies)),
      turn_change(minus),
      turn_change_next(minus),
      centre_change(minus),
      force(minus),
      moment(minus),
      moment_next(minus),
      relative(linear),
      relative_next(linear),
      change(linear),
      change_next(linear),
      rate(linear),
      rate_change(linear) {}

void adjoint_rates(const ForcedStep& step, const StepBalance& balance, const std::vector<BodyBlock>& blocks,
                   const std::vector<BodyRates>& rates, const StepVariation& first, const StepRate& first_rate,
                   const StepDirections& d, const StepJacobian& J, Index left_count, Index count, StepHessian& H) {
  const System& system = step.system;
  const Interval& interval = step.interval;
  const RowRange all(count), by_left(left_count), by_right(left_count, count);
  const NodeRows left{interval.rotation, first.left, first_rate.turn, first_rate.moment, balance.moment, d.left, J.turn,
                      J.moment,          by_left};
  const NodeRows right{interval.next_rotation,
                       first.right,
                       first_rate.turn_next,
                       first_rate.moment_next,
                       balance.moment_next,
                       d.right,
                       J.turn_next,
                       J.moment_next,
                       by_right};
  turn_change_rows(system, left, H.turn_change);
  turn_change_rows(system, right, H.turn_change_next);
  if (all_plain(system, step.lagrangian)) {
    for_each_four(H.body.size(),
                  [&](const FourBodies& four) { four_second_rates(step, balance, first_rate, rates, four, H.body); });
  } else {
    for (int i = 0; i < system.body_count(); ++i)
      body_second_rates(step, balance, first_rate, rates[at(i)].hessian, i, H.body[at(i)]);
  }
  for (int i : system.root_to_leaves()) {
    const std::size_t n = at(i);
    const BodySecondRates& by = H.body[n];
    set_product(by.by_shift.force, J.centre[n], all, H.force[n]);
    add_product(by.by_left.force, J.turn[n], by_left, H.force[n]);
    add_product(by.by_right.force, J.turn_next[n], by_right, H.force[n]);
    set_product(by.by_shift.moment, J.centre[n], all, H.moment[n]);
    add_product(by.by_left.moment, J.turn[n], by_left, H.moment[n]);
    add_product(by.by_right.moment, J.turn_next[n], by_right, H.moment[n]);
    set_product(by.by_shift.next, J.centre[n], by_right, H.moment_next[n]);
    add_product(by.by_right.next, J.turn_next[n], by_right, H.moment_next[n]);
    const Body& body = system.body(i);
    if (body.parent < 0) {
      clear_rows(all, H.centre_change[n]);
      continue;
    }
    // the first direction's own changes count as directions do
    copy_rows(H.centre_change[at(body.parent)], all, H.centre_change[n]);
    add_centre_changes(system, left, i, -1.0, H.turn_change, H.centre_change[n]);
    add_centre_changes(system, right, i, 1.0, H.turn_change_next, H.centre_change[n]);
    add_product(blocks[n].force_by_shift, H.centre_change[n], all, H.force[n]);
    add_product(blocks[n].moment_by_shift, H.centre_change[n], all, H.moment[n]);
    add_product(rates[n].next_by_shift, H.centre_change[n], by_right, H.moment_next[n]);
    if (!turn_changes(body)) continue;
    add_product(rates[n].force_by_left, H.turn_change[n], by_left, H.force[n]);
    add_product(blocks[n].force_by_turn, H.turn_change_next[n], by_right, H.force[n]);
    add_product(rates[n].moment_by_left, H.turn_change[n], by_left, H.moment[n]);
    add_product(blocks[n].moment_by_turn, H.turn_change_next[n], by_right, H.moment[n]);
    add_product(rates[n].hessian.turn_by_turn, H.turn_change_next[n], by_right, H.moment_next[n]);
  }
  sum_row_subtrees(system, all, H.force);
  copy_rows(H.force[0], all, H.linear);
  const double half = 0.5 * step.time_step;
  add_node_second_rows(system, left, step.control, -half, H.turn_change, H, H.moment);
  add_node_second_rows(system, right, step.control_next, half, H.turn_change_next, H, H.moment_next);
  add_damping_second_rows(system, interval, left, right, all, H);
  const Vectors& force = balance.momenta.subtree_linear;
  gather_second_rows(system, left, force, first_rate.force, J.force, H.turn_change, H.force, all, H.moment, H.minus);
  gather_second_rows(system, right, force, first_rate.force, J.force, H.turn_change_next, H.force, by_right,
                     H.moment_next, H.plus);
  add_bracket_rows(system, first.left, J.minus, all, H.minus);
  add_bracket_rows(system, first.right, J.plus, by_right, H.plus);
  for (Rows3& rows : H.minus) set_product(-Matrix3d::Identity(), rows, all, rows);
}

}  // namespace lamprey::mechanics
