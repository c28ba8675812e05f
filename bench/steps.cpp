// Marching: one step, a step with its tangent, a rollout and the gradient by the adjoint.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <stdexcept>
#include <string>

#include "integrator/adjoint.hpp"
#include "integrator/march.hpp"
#include "integrator/step_derivatives.hpp"
#include "measured.hpp"
#include "swimmers.hpp"

namespace lamprey::bench {

namespace {

using integrator::State;
using integrator::StepReport;
using mechanics::DiscreteLagrangian;

using model::at;

// Marches step by step and begins again at the end.
class Marching {
 public:
  explicit Marching(const March& march) : march_(march), state_(march.start), work_(march.system) {}

  int step() {
    if (k_ == march_.steps()) restart();
    const StepReport report = advance(march_.system, march_.lagrangian, March::time_step, march_.moments[at(k_)],
                                      march_.moments[at(k_ + 1)], state_, work_);
    if (!report.converged) throw std::runtime_error("a step of the march did not converge");
    ++k_;
    return report.iterations;
  }

  int node() const { return k_; }
  const integrator::StepWorkspace& work() const { return work_; }

 private:
  void restart() {
    state_ = march_.start;
    work_.predictor.forget();
    k_ = 0;
  }

  const March& march_;
  State state_;
  integrator::StepWorkspace work_;
  int k_ = 0;
};

void step(benchmark::State& state, const model::SwimmerDescription& swimmer, DiscreteLagrangian lagrangian) {
  const March march(swimmer, lagrangian, swimmer.bodies.size() > 20 ? 100 : 1000);
  Marching marching(march);
  double newton = 0.0;
  for (auto _ : state) newton += marching.step();
  state.counters["newton"] = newton / static_cast<double>(state.iterations());
}

void step_of_maneuver(benchmark::State& state, bool tangent_too) {
  const March march = rotation_march();
  Marching marching(march);
  integrator::TangentWorkspace work(march.system);
  integrator::StepTangent tangent(march.system);
  double newton = 0.0;
  for (auto _ : state) {
    newton += marching.step();
    if (!tangent_too) continue;
    const int k = marching.node();
    integrator::linearize_step(march.system, march.lagrangian, March::time_step, marching.work().interval,
                               march.moments[at(k - 1)], march.moments[at(k)], work, tangent);
    benchmark::DoNotOptimize(tangent.A.data());
  }
  state.counters["newton"] = newton / static_cast<double>(state.iterations());
}

void step_with_tangent(benchmark::State& state, const model::SwimmerDescription& swimmer,
                       DiscreteLagrangian lagrangian) {
  const March march(swimmer, lagrangian);
  Marching marching(march);
  integrator::TangentWorkspace work(march.system);
  integrator::StepTangent tangent(march.system);
  for (auto _ : state) {
    marching.step();
    const int k = marching.node();
    integrator::linearize_step(march.system, lagrangian, March::time_step, marching.work().interval,
                               march.moments[at(k - 1)], march.moments[at(k)], work, tangent);
    benchmark::DoNotOptimize(tangent.A.data());
  }
}

// The march from its start to its end, every step kept.
std::vector<mechanics::Interval> rolled_out(const March& march) {
  Marching marching(march);
  std::vector<mechanics::Interval> steps;
  steps.reserve(at(march.steps()));
  for (int k = 0; k < march.steps(); ++k) {
    marching.step();
    steps.push_back(marching.work().interval);
  }
  return steps;
}

void rollout(benchmark::State& state) {
  const March march(paper_chain(), DiscreteLagrangian::trapezoid);
  for (auto _ : state) benchmark::DoNotOptimize(rolled_out(march).data());
}

// Processor time of a call, in ticks of the clock.
template <typename Function>
double ticks(Function&& function) {
  const std::clock_t begin = std::clock();
  function();
  return static_cast<double>(std::clock() - begin);
}

// Gradients of `rows` functionals of the end by all moments; "rollouts": time as a multiple of the rollout's.
void gradient(benchmark::State& state) {
  const March march(paper_chain(), DiscreteLagrangian::trapezoid);
  const std::vector<mechanics::Interval> steps = rolled_out(march);
  const auto source = [&steps](int k, mechanics::Interval& interval) { interval = steps[at(k)]; };
  const integrator::StateLayout layout{march.system};
  const Eigen::MatrixXd end_rows = Eigen::MatrixXd::Random(state.range(0), layout.size());
  double least = 1e300, least_rollout = 1e300;
  for (auto _ : state)
    least = std::min(least, ticks([&] {
                       const integrator::SweptGradients swept =
                           integrator::gradient_sweep(march.system, march.lagrangian, March::time_step, source,
                                                      march.moments, {0, march.steps()}, end_rows);
                       benchmark::DoNotOptimize(swept.by_control.data());
                     }));
  for (int trial = 0; trial < 5; ++trial)
    least_rollout = std::min(least_rollout, ticks([&] { benchmark::DoNotOptimize(rolled_out(march).data()); }));
  state.counters["rollouts"] = least / least_rollout;
}

// Effort over the march and the place where it ends: what a maneuver is judged by.
class Effort : public integrator::Objective {
 public:
  explicit Effort(int last) : last_(last) {}
  void add_gradient(int k, const State& state, const mechanics::Moments& u, integrator::StateGradient& by_state,
                    mechanics::Moments& by_control) const override {
    for (std::size_t j = 0; j < u.size(); ++j) by_control[j] += u[j];
    if (k == last_) by_state.position += state.position;
  }
  void add_gradient_rate(int k, const State&, const mechanics::Moments&, const integrator::StateGradient& along,
                         const mechanics::Moments& u, integrator::StateGradient& by_state,
                         mechanics::Moments& by_control) const override {
    for (std::size_t j = 0; j < u.size(); ++j) by_control[j] += u[j];
    if (k == last_) by_state.position += along.position;
  }

 private:
  int last_;
};

// Gradient of one objective by start, controls, duration and all parameters, and a Hessian product; counters: with the
// rollout they need, as multiples of it.
void adjoint(benchmark::State& state, bool second_order) {
  const March march(paper_chain(), DiscreteLagrangian::trapezoid);
  const auto roll_out = [&] {
    return integrator::roll_out(march.system, integrator::Scheme::trapezoid, march.steps() * March::time_step,
                                march.steps(), march.start, march.moments);
  };
  const integrator::Trajectory trajectory = roll_out();
  const Effort effort(trajectory.steps());
  integrator::AdjointSweep sweep(trajectory);
  integrator::TrajectoryGradient gradient(trajectory);
  integrator::TrajectoryDirection direction(trajectory);
  for (mechanics::Moments& u : direction.control)
    for (Eigen::Vector3d& entry : u) entry.setOnes();
  integrator::HessianProduct product(trajectory);
  double least = 1e300, least_rollout = 1e300;
  for (auto _ : state)
    least = std::min(least, ticks([&] {
                       sweep.gradient(effort, gradient);
                       if (second_order) sweep.hessian_product(effort, direction, product);
                     }));
  for (int trial = 0; trial < 5; ++trial)
    least_rollout = std::min(least_rollout, ticks([&] { benchmark::DoNotOptimize(roll_out().interval.data()); }));
  state.counters["rollouts"] = 1.0 + least / least_rollout;
}

}  // namespace

void register_steps() {
  using benchmark::kMicrosecond;
  const auto trapezoid = DiscreteLagrangian::trapezoid;
  measured("step, paper", kMicrosecond, step, paper_chain(), DiscreteLagrangian::paper);
  measured("step, trapezoid", kMicrosecond, step, paper_chain(), trapezoid);
  for (int bodies : {5, 10, 20, 50, 200, 1000})
    measured("step, trapezoid, " + std::to_string(bodies) + " bodies", kMicrosecond, step, outer_body_chain(bodies),
             trapezoid);
  measured("step, trapezoid, the rotation maneuver", kMicrosecond, step_of_maneuver, false);
  measured("step with tangent, the rotation maneuver", kMicrosecond, step_of_maneuver, true);
  measured("step, midpoint", kMicrosecond, step, paper_chain(), DiscreteLagrangian::midpoint);
  measured("step with tangent, paper", kMicrosecond, step_with_tangent, paper_chain(), DiscreteLagrangian::paper);
  measured("step with tangent, trapezoid", kMicrosecond, step_with_tangent, paper_chain(), trapezoid);
  for (int bodies : {5, 10, 20})
    measured("step with tangent, trapezoid, " + std::to_string(bodies) + " bodies", kMicrosecond, step_with_tangent,
             outer_body_chain(bodies), trapezoid);
  measured("gradient by the adjoint, 1000 steps", kMicrosecond, adjoint, false);
  measured("gradient and Hessian product, 1000 steps", kMicrosecond, adjoint, true);
  measured("rollout, 1000 steps", kMicrosecond, rollout);
  measured("gradients of the end, dense, 1000 steps, rows:", kMicrosecond, gradient)->Arg(1)->Arg(16);
}

}  // namespace lamprey::bench
