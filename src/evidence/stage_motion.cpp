#include "evidence/stage_motion.hpp"

#include "algebra/row_space.hpp"
#include "evidence/balance.hpp"
#include "integrator/march.hpp"
#include "maneuver/step_polynomial.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::evidence {

namespace {

using mechanics::Moments;
using model::at;
using model::System;

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

}  // namespace lamprey::evidence
