#include "optimality/step_curvature.hpp"

#include "mechanics/joint_moments.hpp"

namespace lamprey::optimality {

namespace {

using mechanics::NodeTurns;
using mechanics::RateKind;
using model::at;

}  // namespace

StepCurvature::StepCurvature(const model::System& system)
    : system_(system),
      turns_(system.velocity_count() - 3),
      balance_(system.body_count()),
      multiplier_(system),
      direction_(system),
      multiplier_rate_(system.body_count()),
      rate_(system.body_count()),
      second_(system.body_count()),
      minus_(at(system.body_count())),
      plus_(at(system.body_count())),
      work_(at(system.joint_count())),
      by_motion_(2 * turns_ + 3, 2 * turns_ + 3),
      by_control_(system.control_count(), turns_),
      by_next_control_(system.control_count(), turns_) {}

void StepCurvature::spread(const VectorXd& generalized, Eigen::Index first, mechanics::Freedoms& freedoms) const {
  for (int i = 0; i < system_.body_count(); ++i) {
    const model::Body& body = system_.body(i);
    freedoms[at(i)].setZero();
    freedoms[at(i)].head(body.freedoms) = generalized.segment(first + body.velocity_offset, body.freedoms);
  }
}

void StepCurvature::evaluate(const mechanics::ForcedStep& step, const VectorXd& costate, const VectorXd& costate_next) {
  const Eigen::Index momenta = turns_ + 3;
  evaluate_balance(step, balance_);
  multiplier_.set_zero();
  spread(costate, momenta, multiplier_.left);
  spread(costate_next, momenta, multiplier_.right);
  multiplier_.displacement = costate_next.tail<3>() - costate.tail<3>();
  evaluate_rate(step, balance_, multiplier_, RateKind::adjoint, multiplier_rate_);

  const double half = 0.5 * step.time_step;
  Eigen::Vector3d linear;
  const auto evaluate_column = [&](Eigen::Index column) {
    evaluate_rate(step, balance_, direction_, RateKind::tangent, rate_);
    evaluate_adjoint_rate(step, balance_, multiplier_, multiplier_rate_, direction_, rate_, second_, minus_, plus_,
                          linear);
    auto result = by_motion_.col(column);
    for (int i = 0; i < system_.body_count(); ++i) {
      const model::Body& body = system_.body(i);
      result.segment(body.velocity_offset, body.freedoms) = minus_[at(i)].head(body.freedoms);
      result.segment(turns_ + body.velocity_offset, body.freedoms) = plus_[at(i)].head(body.freedoms);
    }
    result.tail<3>() = linear;
  };
  for (int i = 0; i < system_.body_count(); ++i)
    for (int entry = 0; entry < system_.body(i).freedoms; ++entry) {
      const Eigen::Index place = system_.body(i).velocity_offset + entry;
      direction_.set_zero();
      direction_.left[at(i)][entry] = 1.0;
      evaluate_column(place);
      mechanics::control_work_rate(system_, step.interval.rotation, {multiplier_.left, multiplier_rate_.turn},
                                   {direction_.left, rate_.turn}, second_.turn_change, work_);
      mechanics::along_actuation(system_, work_, by_control_.col(place));
      direction_.set_zero();
      direction_.right[at(i)][entry] = 1.0;
      evaluate_column(turns_ + place);
      mechanics::control_work_rate(system_, step.interval.next_rotation,
                                   {multiplier_.right, multiplier_rate_.turn_next}, {direction_.right, rate_.turn_next},
                                   second_.turn_change_next, work_);
      mechanics::along_actuation(system_, work_, by_next_control_.col(place));
    }
  direction_.set_zero();
  for (int c = 0; c < 3; ++c) {
    direction_.displacement = Eigen::Vector3d::Unit(c);
    evaluate_column(2 * turns_ + c);
  }
  by_control_ *= half;
  by_next_control_ *= half;
  by_motion_ = (0.5 * (by_motion_ + by_motion_.transpose())).eval();
}

}  // namespace lamprey::optimality
