#include "integrator/reference_integrator.hpp"

#include <cmath>
#include <cstdio>

#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "lie/so3.hpp"

namespace lamprey::integrator {

namespace {

namespace odeint = boost::numeric::odeint;
using Eigen::Vector3d;
using Eigen::VectorXd;
using lie::Vector4;
using model::System;
using Flat = ReferenceIntegrator::Flat;

constexpr long max_trials = 20'000;
constexpr double first_step = 1e-3;  // s

Eigen::Map<const VectorXd> part(const Flat& y, int from, int size) { return {y.data() + from, size}; }

template <typename Vector>
void put(Flat& y, int from, const Vector& v) {
  Eigen::Map<VectorXd>(y.data() + from, v.size()) = v;
}

Flat flatten(const ReferenceState& state) {
  const int bodies = static_cast<int>(state.rotation.size());
  Flat y(static_cast<std::size_t>(4 * bodies + 3 + state.velocity.size()));
  for (int i = 0; i < bodies; ++i)
    put(y, 4 * i, lie::quaternion_of_rotation(state.rotation[static_cast<std::size_t>(i)]));
  put(y, 4 * bodies, state.position);
  put(y, 4 * bodies + 3, state.velocity);
  return y;
}

void read(const Flat& y, ReferenceState& state) {
  const auto bodies = static_cast<int>(state.rotation.size());
  for (int i = 0; i < bodies; ++i)
    state.rotation[static_cast<std::size_t>(i)] = lie::rotation_of_quaternion(part(y, 4 * i, 4));
  state.position = part(y, 4 * bodies, 3);
  state.velocity = part(y, 4 * bodies + 3, static_cast<int>(state.velocity.size()));
}

}  // namespace

std::string reference_scheme(double tolerance) {
  char text[80];
  std::snprintf(text, sizeof text, "runge_kutta_fehlberg78, tolerance %.0e", tolerance);
  return text;
}

ReferenceIntegrator::ReferenceIntegrator(const System& system, StateControl control, double tolerance)
    : control_(std::move(control)),
      tolerance_(tolerance),
      equations_(system),
      stage_{mechanics::Rotations(static_cast<std::size_t>(system.body_count())), Vector3d::Zero(),
             VectorXd(system.velocity_count())} {}

ReferenceIntegrator::ReferenceIntegrator(const System& system, ControlFunction control, double tolerance)
    : ReferenceIntegrator(
          system, [control = std::move(control)](double t, const ReferenceState&) { return control(t); }, tolerance) {}

// q̇_i = ½ q_i ∘ (0, Ω_i), ẋ, ξ̇. Bodies that their joints lead turn by their own quaternions too: how far they leave
// their joints is part of the error that the tolerance bounds.
void ReferenceIntegrator::rate(const Flat& y, Flat& dydt, double t) {
  read(y, stage_);
  const auto bodies = static_cast<int>(stage_.rotation.size());
  equations_.evaluate(stage_.rotation, stage_.velocity, control_(t, stage_));
  for (int i = 0; i < bodies; ++i) {
    Vector4 spin = Vector4::Zero();
    spin.tail<3>() = equations_.motion().turn[model::at(i)];
    put(dydt, 4 * i, Vector4(0.5 * lie::quaternion_product(part(y, 4 * i, 4), spin)));
  }
  put(dydt, 4 * bodies, Vector3d(stage_.velocity.tail<3>()));
  put(dydt, 4 * bodies + 3, equations_.acceleration());
}

bool ReferenceIntegrator::advance(double begin, double end, ReferenceState& state) {
  using Stepper = odeint::runge_kutta_fehlberg78<Flat>;
  using Checker = odeint::default_error_checker<double, odeint::range_algebra, odeint::default_operations>;
  odeint::controlled_runge_kutta<Stepper> stepper(Checker(tolerance_, tolerance_));
  const auto system_rate = [this](const Flat& y, Flat& dydt, double t) { rate(y, dydt, t); };
  Flat y = flatten(state);
  double time = begin;
  double step = step_ > 0.0 ? step_ : first_step;
  for (long trial = 0; time < end; ++trial) {
    const double left = end - time;
    const bool last = step >= left * (1.0 - 1e-12);
    double tried = last ? left : step;
    const bool held = stepper.try_step(system_rate, y, time, tried) == odeint::success;
    if (held && last) time = end;  // not the sum of steps, which rounds
    if (!held || !last) step = tried;
    if (held) step_ = std::max(step, tried);
    const bool finite = std::isfinite(part(y, 0, static_cast<int>(y.size())).sum());
    if (!finite || trial >= max_trials || !(step > 1e-14 * std::max(1.0, std::abs(end)))) return false;
  }
  read(y, state);
  return true;
}

}  // namespace lamprey::integrator
