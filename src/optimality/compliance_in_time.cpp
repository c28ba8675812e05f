#include "optimality/compliance_in_time.hpp"

#include "mechanics/compliant_time.hpp"
#include "optimality/step_curvature.hpp"

namespace lamprey::optimality {

namespace {

using mechanics::Freedoms;
using model::at;
using model::System;

// Freedoms of all bodies, one after the other; 0 for the root's position.
VectorXd generalized(const System& system, const Freedoms& freedoms) {
  VectorXd result = VectorXd::Zero(system.velocity_count());
  for (int i = 0; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    result.segment(body.velocity_offset, body.freedoms) = freedoms[at(i)].head(body.freedoms);
  }
  return result;
}

Freedoms freedoms_of(const System& system, const VectorXd& velocity) {
  Freedoms freedoms(at(system.body_count()), Vector3d::Zero());
  mechanics::unpack(system, velocity, freedoms);
  return freedoms;
}

// −minus·λ_k + plus·λ_{k+1} of a step: second derivatives by the duration's logarithm and the turns at both ends, and by it twice.
struct TimedForm {
  VectorXd by_turns;  // [2 turns]
  double twice;
};

TimedForm timed_form(const System& system, double time_step, const mechanics::Interval& interval,
                     const VectorXd& costate, const VectorXd& costate_next, mechanics::CompliantTime& time) {
  const Eigen::Index momenta = system.velocity_count(), turns = momenta - 3;
  const VectorXd left = costate.tail(momenta), right = costate_next.tail(momenta);
  time.evaluate(time_step, interval);
  time.differentiate(time_step, interval, freedoms_of(system, left), freedoms_of(system, right));
  TimedForm form;
  form.by_turns.resize(2 * turns);
  form.by_turns << generalized(system, time.by_left()).head(turns), generalized(system, time.by_right()).head(turns);
  // dampers once and springs four times: twice what `time` tells, less the dampers
  const auto along = [&](const Freedoms& timed, const Freedoms& damped, const VectorXd& costates) {
    return (2.0 * generalized(system, timed) - generalized(system, damped)).dot(costates);
  };
  form.twice = along(time.plus(), time.damped_plus(), right) - along(time.minus(), time.damped_minus(), left);
  return form;
}

}  // namespace

std::vector<TimedImpulses> timed_impulses(const StoredMotion& motion) {
  std::vector<TimedImpulses> result;
  if (!motion.problem.duration.free || !motion.system.compliant()) return result;
  mechanics::CompliantTime time(motion.system);
  mechanics::Interval interval(motion.system.body_count());
  for (int k = 0; k < motion.steps; ++k) {
    evidence::read_interval(motion, k, interval);
    time.evaluate(motion.time_step, interval);
    result.push_back({generalized(motion.system, time.minus()), generalized(motion.system, time.plus())});
  }
  return result;
}

std::vector<VectorXd> steps_by_duration(const StoredMotion& motion, const StepTangents& tangents) {
  std::vector<VectorXd> result;
  const Eigen::Index momenta = motion.system.velocity_count();
  const VectorXd unit = tangents.scale.tail(momenta).cwiseInverse();
  const std::vector<TimedImpulses> impulses = timed_impulses(motion);
  for (std::size_t k = 0; k < impulses.size(); ++k) {
    VectorXd next = -(tangents.A[k].rightCols(momenta) * unit.cwiseProduct(impulses[k].minus));
    next.tail(momenta) += unit.cwiseProduct(impulses[k].plus);
    result.push_back(std::move(next));
  }
  return result;
}

void add_compliance_in_time(const StoredMotion& motion, const EffortChain& effort,
                            const std::vector<VectorXd>& costates, Chain& chain) {
  if (effort.by_duration.empty()) return;
  const System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3, place = turns + 3, last = chain.end_form.rows() - 1;
  const Eigen::Index reached = effort.basis.back().cols(), controls = system.control_count(), all = reached + controls;
  const auto configuration = [&](int node, Eigen::Index size) {
    return MatrixXd(effort.tangents.scale.head(size).asDiagonal() * effort.basis[at(node)].topRows(size));
  };
  StepCurvature curvature(system);
  mechanics::CompliantTime time(system);
  mechanics::Interval interval(system.body_count());
  for (int k = 0; k < motion.steps; ++k) {
    ChainStage& stage = chain.stage[effort.first + at(k)];
    const VectorXd& next = effort.by_duration[at(k)];
    stage.A.col(last).head(reached) = next;
    // turns at both ends and the displacement, by what arrives and the moments, and by the duration's logarithm
    const MatrixXd there = configuration(k + 1, place);
    MatrixXd motions = MatrixXd::Zero(turns + place, all);
    motions.bottomRows(place) << there * stage.A.topLeftCorner(reached, reached), there * stage.B.topRows(reached);
    if (effort.basis[at(k)].size() > 0) {
      const MatrixXd here = configuration(k, place);
      motions.topLeftCorner(turns, reached) = here.topRows(turns);
      motions.bottomLeftCorner(3, reached) -= here.bottomRows(3);
    }
    VectorXd in_time = VectorXd::Zero(turns + place);
    in_time.tail(place) = there * next;
    evidence::read_interval(motion, k, interval);
    const VectorXd &costate = costates[at(k)], &costate_next = costates[at(k + 1)];
    curvature.evaluate(
        {system, motion.lagrangian, motion.time_step, interval, motion.control[at(k)], motion.control[at(k + 1)]},
        costate, costate_next);
    const TimedForm form = timed_form(system, motion.time_step, interval, costate, costate_next, time);
    VectorXd pulled = curvature.by_motion() * in_time;
    const double twice = in_time.dot(pulled) + 2.0 * in_time.head(2 * turns).dot(form.by_turns) + form.twice;
    pulled.head(2 * turns) += form.by_turns;
    const VectorXd mixed = motions.transpose() * pulled;
    stage.Q.col(last).head(reached) += mixed.head(reached);
    stage.Q.row(last).head(reached) += mixed.head(reached).transpose();
    stage.Q(last, last) += twice;
    stage.S.col(last) += mixed.tail(controls);
  }
}

}  // namespace lamprey::optimality
