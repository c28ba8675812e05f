#include "certificate/replay.hpp"

#include <algorithm>

#include "certificate/optimality.hpp"
#include "integrator/feedback_law.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/row_space.hpp"

namespace lamprey::certificate {

namespace {

using integrator::ReferenceIntegrator;
using integrator::ReferenceState;
using integrator::State;

constexpr int growth_samples = 200;  // over the duration

using model::at;

// Moments at the nodes, [3 · joints][N+1].
MatrixXd node_moments(const StoredMotion& motion) {
  MatrixXd moments(3 * motion.system.joint_count(), motion.steps + 1);
  for (int k = 0; k <= motion.steps; ++k)
    for (int j = 0; j < motion.system.joint_count(); ++j) moments.block<3, 1>(3 * j, k) = motion.control[at(k)][at(j)];
  return moments;
}

maneuver::ControlPath control_path(const StoredMotion& motion) {
  const MatrixXd moments = node_moments(motion);
  const VectorXd times = Eigen::Map<const VectorXd>(motion.solution.time.data(), motion.steps + 1);
  if (motion.problem.control == maneuver::ControlKind::steps) return {maneuver::Interpolation::linear, times, moments};
  const MatrixXd basis = control_space(motion).basis;
  const MatrixXd points = maneuver::least_squares(basis, moments.transpose());
  return {maneuver::Interpolation::natural_cubic,
          VectorXd::LinSpaced(motion.problem.points, times[0], times[motion.steps]), points.transpose()};
}

integrator::ControlFunction control_function(const StoredMotion& motion) {
  return [path = control_path(motion), joints = motion.system.joint_count()](double t) {
    const VectorXd u = path.value(t);
    mechanics::Moments moments;
    for (int j = 0; j < joints; ++j) moments.push_back(u.segment<3>(3 * j));
    return moments;
  };
}

ReferenceState reference_state(const model::System& system, const State& state) {
  return {state.rotation, state.position, integrator::velocity_of_state(system, state)};
}

struct Distance {
  double rotation;  // rad
  double position;  // m
};

Distance distance(const ReferenceState& state, const State& stored) {
  Largest angle, way;
  for (std::size_t i = 0; i < stored.rotation.size(); ++i)
    angle.add(lie::rotation_angle(stored.rotation[i].transpose() * state.rotation[i]));
  way.add((state.position - stored.position).norm());
  return {angle.value(), way.value()};
}

// Carries the state from node to node, where linear moments have their kinks.
bool carry(const StoredMotion& motion, int from, int to, ReferenceIntegrator& integrator, ReferenceState& state) {
  for (int k = from; k < to; ++k)
    if (!integrator.advance(motion.solution.time[at(k)], motion.solution.time[at(k + 1)], state)) return false;
  return true;
}

void replay_windows(const StoredMotion& motion, const std::vector<State>& states, int length,
                    ReferenceIntegrator& integrator, Replay& result) {
  Largest rotation, position;
  for (int from = 0; from < motion.steps; from += length) {
    const int to = std::min(from + length, motion.steps);
    ReferenceState state = reference_state(motion.system, states[at(from)]);
    if (!carry(motion, from, to, integrator, state)) return;
    const Distance miss = distance(state, states[at(to)]);
    rotation.add(miss.rotation);
    position.add(miss.position);
  }
  result.rotation_error = rotation.value();
  result.position_error = position.value();
}

void replay_whole(const StoredMotion& motion, const std::vector<State>& states, ReferenceIntegrator& integrator,
                  Replay& result) {
  ReferenceState state = reference_state(motion.system, states.front());
  if (!carry(motion, 0, motion.steps, integrator, state)) return;
  const Distance miss = distance(state, states.back());
  result.whole_rotation_error = miss.rotation;
  result.whole_position_error = miss.position;
}

}  // namespace

double growth_rate(const StoredMotion& motion) {
  const int stride = std::max(1, motion.steps / growth_samples);
  const int turns = motion.system.velocity_count() - 3;
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  mechanics::Interval interval(motion.system.body_count());
  MatrixXd perturbed = MatrixXd::Identity(2 * motion.system.velocity_count(), turns);
  double log_size = 0.0;                   // of what was divided off
  std::vector<double> log_growth = {0.0};  // ln G at every stride-th node
  for (int k = 0; k < motion.steps; ++k) {
    read_interval(motion, k, interval);
    integrator::linearize_step(motion.system, motion.lagrangian, motion.time_step, interval, motion.control[at(k)],
                               motion.control[at(k + 1)], work, tangent);
    perturbed = tangent.A * perturbed;
    if ((k + 1) % stride != 0) continue;
    log_growth.push_back(log_size + std::log(maneuver::largest_singular_value(perturbed.topRows(turns))));
    const double size = perturbed.norm();
    perturbed /= size;
    log_size += std::log(size);
  }
  const int samples = static_cast<int>(log_growth.size()) - 1;
  const int span = std::max(1, samples / 4);
  double steepest = -std::numeric_limits<double>::infinity();
  for (int s = span; s <= samples; ++s) steepest = std::max(steepest, log_growth[at(s)] - log_growth[at(s - span)]);
  return std::isfinite(steepest) ? steepest / (span * stride * motion.time_step) : unset;
}

void replay_with_feedback(const StoredMotion& motion, double tolerance, Replay& result) {
  const maneuver::Feedback& feedback = motion.solution.feedback;
  if (feedback.gain.empty()) return;
  integrator::NodeMotion nodes{motion.solution.time, {}};
  const std::vector<State> states = node_states(motion);
  for (const State& state : states) nodes.state.push_back(reference_state(motion.system, state));
  const integrator::FeedbackLaw law(integrator::MotionPath(motion.system, nodes), control_function(motion),
                                    feedback.time, feedback.gain);
  ReferenceIntegrator integrator(motion.system, integrator::StateControl([&](double t, const ReferenceState& state) {
                                   return law.moments(t, state);
                                 }),
                                 tolerance);
  ReferenceState state = nodes.state.front();
  if (!carry(motion, 0, motion.steps, integrator, state)) return;
  const Distance miss = distance(state, states.back());
  result.feedback_rotation_error = miss.rotation;
  result.feedback_position_error = miss.position;
}

Replay replay(const StoredMotion& motion, double window, double tolerance) {
  const int length = static_cast<int>(std::clamp(std::round(window / motion.time_step), 1.0, double(motion.steps)));
  const std::vector<State> states = node_states(motion);
  Replay result;
  result.scheme = integrator::reference_scheme(tolerance);
  result.window = length * motion.time_step;
  ReferenceIntegrator integrator(motion.system, control_function(motion), tolerance);
  replay_windows(motion, states, length, integrator, result);
  replay_whole(motion, states, integrator, result);
  replay_with_feedback(motion, tolerance, result);
  result.growth_rate = growth_rate(motion);
  return result;
}

}  // namespace lamprey::certificate
