#include "certificate/stage_motion.hpp"

#include <cstdint>

#include "algebra/row_space.hpp"
#include "certificate/balance.hpp"
#include "certificate/goal_check.hpp"
#include "certificate/optimality.hpp"
#include "integrator/march.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/step_polynomial.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::certificate {

namespace {

using mechanics::Moments;
using model::at;
using model::System;

constexpr double dependent_stage_row = 1e-11;  // of the largest pivot
constexpr int most_stage_segments = 20;        // a growth of 1e20 over the whole is 10 over each

// Of the moments of joints, and those along the actuation axes.
double distance_from(const System& system, const Moments& control, const VectorXd& moments) {
  Largest distance;
  const Moments exerted = mechanics::joint_moments(system, moments);
  for (std::size_t j = 0; j < exerted.size(); ++j) distance.add((control[j] - exerted[j]).norm());
  return distance.value();
}

bool has_stages(const StoredMotion& motion, std::size_t nodes) {
  const maneuver::Solution& stored = motion.solution;
  if (integrator::single_step(motion.problem.scheme) || stored.divided.steps > 0 || !stored.marched_by.empty())
    return false;
  if (stored.control_stages.size() != at(motion.steps) || stored.angular_velocity.size() != stored.time.size() ||
      stored.linear_velocity.size() != stored.time.size())
    return false;
  for (const auto& step : stored.control_stages)
    if (step.size() != nodes) return false;
  return true;
}

class Marcher {
 public:
  Marcher(const StoredMotion& motion, bool keeps_all, StageMotion& stages)
      : motion_(motion),
        stages_(stages),
        keeps_all_(keeps_all),
        march_(motion.system, motion.problem.scheme),
        none_(at(motion.system.joint_count()), Vector3d::Zero()),
        basis_(stages.stages + 1, stages.terms) {
    for (int s = 0; s <= stages.stages; ++s)
      basis_.row(s) = maneuver::legendre(stages.fraction[at(s)], stages.terms).transpose();
  }

  // Step k; false where a stage does not converge.
  bool march(int k) {
    const System& system = motion_.system;
    const auto& moments = motion_.solution.control_stages[at(k)];
    integrator::State state = stages_.node[at(k)];
    stages_.control.push_back(mechanics::moments_of_applied(system, state.rotation, moments.front()));
    Moments begin = stages_.control.back();
    int stage = 0;
    // how the joints stand at a stage's end tells which moment acts there: its impulse is added then
    const auto control = [&](int node) -> const Moments& { return node == stage ? begin : none_; };
    const auto witness = [&](const mechanics::Interval& interval, integrator::State& there) {
      if (keeps_all_) stages_.interval.push_back(interval);
      begin = mechanics::moments_of_applied(system, there.rotation, moments[at(stage + 1)]);
      stages_.control.push_back(begin);
      there.momentum += 0.5 * stages_.time_step[at(stage)] *
                        (mechanics::generalized_force(system, there.rotation, begin) -
                         mechanics::generalized_force(system, there.rotation, none_));  // springs have had theirs
      ++stage;
    };
    if (!march_.advance(motion_.time_step, control, state, witness).converged) return false;
    compare(k, state);
    compare_node(k);
    if (k + 1 == motion_.steps) compare_node(k + 1);
    compare_times(k);
    compare_moments(k);
    return true;
  }

  void fail() { momentum_.add(unset); }

  void finish() {
    stages_.momentum_error = momentum_.value();
    stages_.configuration_error = configuration_.value();
    stages_.actuation_error = outside_.relative_to(largest_.value());
    stages_.polynomial_error = beside_.relative_to(largest_.value());
    stages_.time_error = time_.value();
  }

 private:
  void compare(int k, const integrator::State& state) {
    const integrator::State& next = stages_.node[at(k + 1)];
    momentum_.add(largest_part(motion_.system, state.momentum - next.momentum));
    for (std::size_t i = 0; i < next.rotation.size(); ++i)
      configuration_.add(lie::rotation_angle(next.rotation[i].transpose() * state.rotation[i]));
    configuration_.add((state.position - next.position).norm() / motion_.system.length_unit());
  }

  // Nodes have the mean of what acts on both sides.
  void compare_node(int k) {
    const int nodes = stages_.stages + 1;
    const Moments& after = stages_.control[at(k < motion_.steps ? k * nodes : k * nodes - 1)];
    const Moments& before = k > 0 ? stages_.control[at(k * nodes - 1)] : after;
    for (std::size_t j = 0; j < after.size(); ++j)
      outside_.add((motion_.control[at(k)][j] - 0.5 * (before[j] + after[j])).norm());
  }

  void compare_times(int k) {
    const maneuver::Solution& stored = motion_.solution;
    const bool told = at(k) < stored.stage_time.size() && stored.stage_time[at(k)].size() == stages_.fraction.size();
    if (!told) time_.add(unset);
    for (std::size_t s = 0; told && s < stages_.fraction.size(); ++s)
      time_.add(std::abs(stored.stage_time[at(k)][s] - (stored.time[at(k)] + stages_.fraction[s] * motion_.time_step)));
  }

  void compare_moments(int k) {
    const int nodes = stages_.stages + 1, controls = motion_.system.control_count();
    MatrixXd samples(nodes, controls);
    for (int s = 0; s < nodes; ++s)
      samples.row(s) = mechanics::along_actuation(motion_.system, stages_.control[at(k * nodes + s)]).transpose();
    for (int s = 0; s < nodes; ++s) {
      const Moments& control = stages_.control[at(k * nodes + s)];
      outside_.add(distance_from(motion_.system, control, samples.row(s).transpose()));
      for (const Vector3d& u : control) largest_.add(u.norm());
    }
    if (keeps_all_) fit(k, samples);
  }

  void fit(int k, const MatrixXd& samples) {
    const MatrixXd coefficients = algebra::least_squares(basis_, samples);  // [terms][controls]
    stages_.polynomial.push_back(coefficients.transpose().reshaped());
    const MatrixXd fitted = basis_ * coefficients;
    for (Eigen::Index s = 0; s < fitted.rows(); ++s)
      beside_.add(distance_from(motion_.system, stages_.control[at(k * (stages_.stages + 1) + static_cast<int>(s))],
                                fitted.row(s).transpose()));
  }

  const StoredMotion& motion_;
  StageMotion& stages_;
  bool keeps_all_;
  integrator::March march_;
  Moments none_;
  MatrixXd basis_;  // [stages + 1][terms]
  Largest momentum_, configuration_, outside_, beside_, largest_, time_;
};

// Rows by the state at the end of a range of steps, carried to its beginning and to the coefficients on the way.
struct StageSweep {
  MatrixXd by_start;         // [rows][2 velocity_count]
  MatrixXd by_coefficients;  // [rows][steps · inputs]
};

StageSweep sweep(const StoredMotion& motion, const StageMotion& stages, integrator::StepRange range,
                 const MatrixXd& end_rows) {
  const int controls = motion.system.control_count(), inputs = stages.terms * controls;
  StageSweep result{end_rows, MatrixXd::Zero(end_rows.rows(), inputs * (range.last - range.first))};
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  std::vector<VectorXd> value;
  for (double fraction : stages.fraction) value.push_back(maneuver::legendre(fraction, stages.terms));
  for (int k = range.last - 1; k >= range.first; --k)
    for (int s = stages.stages - 1; s >= 0; --s) {
      const mechanics::ForcedStep stage = forced_stage(motion, stages, k, s);
      integrator::linearize_step(motion.system, motion.lagrangian, stage.time_step, stage.interval, stage.control,
                                 stage.control_next, work, tangent);
      integrator::PulledBack pulled = integrator::pull_back(tangent, result.by_start);
      for (int term = 0; term < stages.terms; ++term)
        result.by_coefficients.middleCols(inputs * (k - range.first) + term * controls, controls) +=
            value[at(s)][term] * pulled.by_control + value[at(s + 1)][term] * pulled.by_next_control;
      result.by_start.swap(pulled.by_state);
    }
  return result;
}

// Rows that span those of the end rows by all coefficients, as optimality.cpp's by the moments at the nodes.
MatrixXd spanning_rows(const StoredMotion& motion, const StageMotion& stages, const MatrixXd& end_rows) {
  const int inputs = stages.terms * motion.system.control_count();
  const int segments = std::min(most_stage_segments, motion.steps);
  const auto node = [&](int s) { return static_cast<int>(std::int64_t{motion.steps} * s / segments); };
  const VectorXd scale = state_scale(motion, motion.time_step * node(1));
  const int size = static_cast<int>(scale.size());
  // unknowns: scaled costates at the inner segment ends, then the goal's multipliers
  const auto unknowns = static_cast<int>(end_rows.rows()) + size * (segments - 1);
  MatrixXd ties = MatrixXd::Zero(size * (segments - 1), unknowns);
  MatrixXd rows_of_all = MatrixXd::Zero(unknowns, inputs * motion.steps);
  for (int s = 0; s < segments; ++s) {
    const bool last = s + 1 == segments;
    const MatrixXd rows = last ? end_rows : MatrixXd(scale.cwiseInverse().asDiagonal());
    const StageSweep swept = sweep(motion, stages, {node(s), node(s + 1)}, rows);
    rows_of_all.block(size * s, inputs * node(s), rows.rows(), swept.by_coefficients.cols()) = swept.by_coefficients;
    if (s == 0) continue;
    ties.block(size * (s - 1), size * (s - 1), size, size).setIdentity();
    ties.block(size * (s - 1), size * s, size, rows.rows()) = -(scale.asDiagonal() * swept.by_start.transpose());
  }
  return algebra::null_space(ties).transpose() * rows_of_all;
}

std::optional<StageMotion> march(const StoredMotion& motion, bool keeps_all) {
  if (integrator::single_step(motion.problem.scheme)) return std::nullopt;
  const integrator::Composition& composed = integrator::composition(motion.problem.scheme);
  if (!has_stages(motion, at(composed.stages() + 1))) return std::nullopt;
  StageMotion stages{};
  stages.stages = composed.stages();
  stages.terms = maneuver::polynomial_terms(motion.problem.scheme);
  stages.fraction = maneuver::stage_fractions(motion.problem.scheme);
  for (double fraction : composed.fractions) stages.time_step.push_back(fraction * motion.time_step);
  for (int k = 0; k <= motion.steps; ++k) stages.node.push_back(stored_state(motion, k));
  Marcher marcher(motion, keeps_all, stages);
  for (int k = 0; k < motion.steps; ++k)
    if (!marcher.march(k)) {
      if (keeps_all) return std::nullopt;
      marcher.fail();
      break;
    }
  marcher.finish();
  return stages;
}

}  // namespace

std::optional<StageMotion> march_again(const StoredMotion& motion) { return march(motion, true); }

std::optional<StageMotion> check_march(const StoredMotion& motion) { return march(motion, false); }

mechanics::ForcedStep forced_stage(const StoredMotion& motion, const StageMotion& stages, int k, int s) {
  const std::size_t node = at(k * (stages.stages + 1) + s);
  return {motion.system,           motion.lagrangian,
          stages.time_step[at(s)], stages.interval[at(k * stages.stages + s)],
          stages.control[node],    stages.control[node + 1]};
}

Moments moments_of_step(const StoredMotion& motion, const StageMotion& stages, int k, double fraction) {
  return mechanics::joint_moments(motion.system,
                                  maneuver::moments_at(stages.polynomial[at(k)], fraction, stages.terms));
}

double cost_of_steps(const StoredMotion& motion, const StageMotion& stages) {
  double sum = 0.0;
  for (const VectorXd& coefficients : stages.polynomial) sum += 0.5 * coefficients.squaredNorm();
  return motion.problem.effort * motion.time_step * sum + motion.problem.time_weight * motion.time_step * motion.steps;
}

double step_residual(const StoredMotion& motion, const StageMotion& stages, double scale) {
  const integrator::State start = start_of(motion.system, motion.problem.start);
  Largest momentum;
  momentum.add(stages.momentum_error);
  momentum.add(largest_part(motion.system, start.momentum - stages.node.front().momentum));
  return std::max(momentum.relative_to(scale), stages.configuration_error);
}

MatrixXd coefficient_jacobian(const StoredMotion& motion, const StageMotion& stages, const MatrixXd& end_rows) {
  return sweep(motion, stages, {0, motion.steps}, end_rows).by_coefficients;
}

double kkt_residual(const StoredMotion& motion, const StageMotion& stages, double momentum_scale) {
  const int inputs = stages.terms * motion.system.control_count();
  VectorXd gradient(inputs * motion.steps);
  for (int k = 0; k < motion.steps; ++k)
    gradient.segment(inputs * k, inputs) = motion.problem.effort * motion.time_step * stages.polynomial[at(k)];
  const GoalRows goal = goal_rows(motion.system, motion.problem, stages.node.back(), momentum_scale);
  const MatrixXd rows = spanning_rows(motion, stages, goal.unit.cwiseInverse().asDiagonal() * goal.by_end_state);
  Largest left, whole;
  for (double entry : algebra::beyond_rows(gradient, rows, dependent_stage_row)) left.add(std::abs(entry));
  for (double entry : gradient) whole.add(std::abs(entry));
  return left.relative_to(whole.value());
}

}  // namespace lamprey::certificate
