#include "certificate/replay.hpp"

#include <algorithm>
#include <memory>

#include "algebra/row_space.hpp"
#include "certificate/servo_replay.hpp"
#include "evidence/control_space.hpp"
#include "integrator/feedback_law.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/motor_limits.hpp"

namespace lamprey::certificate {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using evidence::Largest;
using integrator::ReferenceIntegrator;
using integrator::ReferenceState;
using integrator::State;

constexpr int work_samples = 8;          // in a step
constexpr int growth_samples = 200;      // over the duration
constexpr double window_share = 0.05;    // of the duration
constexpr double most_log_growth = 2.0;  // of small perturbations in a window

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
  const MatrixXd basis = evidence::control_space(motion).basis;
  const MatrixXd points = algebra::least_squares(basis, moments.transpose());
  return {maneuver::Interpolation::natural_cubic,
          VectorXd::LinSpaced(motion.problem.points, times[0], times[motion.steps]), points.transpose()};
}

// What is replayed: states at the nodes, and moments in each step.
struct Course {
  const StoredMotion& motion;
  std::vector<State> states;
  integrator::ControlFunction control;
  std::shared_ptr<int> step = std::make_shared<int>(0);  // that runs now
  std::function<bool()> stopped = {};
};

integrator::ControlFunction control_function(const StoredMotion& motion) {
  return [path = control_path(motion), joints = motion.system.joint_count()](double t) {
    const VectorXd u = path.value(t);
    mechanics::Moments moments(at(joints));
    for (int j = 0; j < joints; ++j) moments[at(j)] = u.segment<3>(3 * j);
    return moments;
  };
}

Course course_of(const StoredMotion& motion, const StageMotion& stages) {
  Course course{motion, stages.node, {}};
  course.control = [&motion, &stages, step = course.step](double t) {
    const double fraction = (t - motion.solution.time[at(*step)]) / motion.time_step;
    return evidence::moments_of_step(motion, stages, *step, fraction);
  };
  return course;
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
bool carry(const Course& course, int from, int to, ReferenceIntegrator& integrator, ReferenceState& state) {
  const std::vector<double>& time = course.motion.solution.time;
  for (int k = from; k < to; ++k) {
    *course.step = k;
    if (course.stopped && course.stopped()) return false;
    if (!integrator.advance(time[at(k)], time[at(k + 1)], state)) return false;
  }
  return true;
}

// W: Σ |u·ω| over the drives.
double power(const Course& course, double time, const ReferenceState& state) {
  const model::System& system = course.motion.system;
  const mechanics::Vectors control = course.control(time);
  const mechanics::Vectors moments = mechanics::applied_moments(system, state.rotation, control);
  const mechanics::Vectors velocities = mechanics::angular_velocities(system, state.rotation, state.velocity);
  double sum = 0.0;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    if (joint.kind == model::JointKind::universal) {  // a drive for each axis
      const auto rates = state.velocity.segment<2>(system.body(joint.child).velocity_offset);
      sum += control[at(j)].head<2>().cwiseProduct(rates).lpNorm<1>();
      continue;
    }
    const Vector3d rate =
        mechanics::child_to_parent(state.rotation, joint) * velocities[at(joint.child)] - velocities[at(joint.parent)];
    sum += std::abs(moments[at(j)].dot(rate));
  }
  return sum;
}

// J, over each step from its stored state: what moments do between the nodes, too.
double work(const Course& course, ReferenceIntegrator& integrator) {
  const std::vector<double>& time = course.motion.solution.time;
  double sum = 0.0;
  for (int k = 0; k < course.motion.steps; ++k) {
    *course.step = k;
    if (course.stopped && course.stopped()) return unset;
    ReferenceState state = reference_state(course.motion.system, course.states[at(k)]);
    const double length = (time[at(k + 1)] - time[at(k)]) / work_samples;
    for (int sample = 0; sample < work_samples; ++sample) {
      const double t = time[at(k)] + sample * length;
      sum += 0.5 * length * power(course, t, state);
      if (!integrator.advance(t, t + length, state)) return unset;
      sum += 0.5 * length * power(course, t + length, state);
    }
  }
  return sum;
}

void replay_windows(const Course& course, int length, ReferenceIntegrator& integrator, Replay& result) {
  Largest rotation, position;
  const int steps = course.motion.steps;
  for (int from = 0; from < steps; from += length) {
    const int to = std::min(from + length, steps);
    ReferenceState state = reference_state(course.motion.system, course.states[at(from)]);
    if (!carry(course, from, to, integrator, state)) return;
    const Distance miss = distance(state, course.states[at(to)]);
    rotation.add(miss.rotation);
    position.add(miss.position);
  }
  result.rotation_error = rotation.value();
  result.position_error = position.value();
}

void replay_whole(const Course& course, ReferenceIntegrator& integrator, Replay& result) {
  ReferenceState state = reference_state(course.motion.system, course.states.front());
  if (!carry(course, 0, course.motion.steps, integrator, state)) return;
  const Distance miss = distance(state, course.states.back());
  result.whole_rotation_error = miss.rotation;
  result.whole_position_error = miss.position;
}

// Steps of a window: a share of the duration, and not so long that perturbations grow by much.
int window_steps(const StoredMotion& motion, double growth) {
  double steps = window_share * motion.steps;
  if (growth > 0.0) steps = std::min(steps, most_log_growth / (growth * motion.time_step));
  return static_cast<int>(std::clamp(std::round(steps), 1.0, double(motion.steps)));
}

// A small goal is not met by steps whose error is as large.
void set_marks(const maneuver::Problem& problem, Replay& result) {
  if (!problem.goal) return;
  double way = 0.0;
  for (const auto& along : problem.goal->move) way = std::hypot(way, along.value_or(0.0));
  if (way > 0.0) result.position_mark = asked_share * way;
  const double turn = problem.goal->turn ? problem.goal->turn->norm() : 0.0;
  if (turn > 0.0) result.rotation_mark = std::min(replay_mark, asked_share * turn);
}

Replay replayed(Course course, double growth, const ReplayOptions& options) {
  course.stopped = options.stopped;
  const StoredMotion& motion = course.motion;
  const int length = window_steps(motion, growth);
  Replay result;
  set_marks(motion.problem, result);
  result.growth_rate = growth;
  result.scheme = integrator::reference_scheme(options.tolerance);
  result.window = length * motion.time_step;
  ReferenceIntegrator integrator(motion.system, course.control, options.tolerance);
  replay_windows(course, length, integrator, result);
  result.cut_short = std::isnan(result.rotation_error) && course.stopped && course.stopped();
  replay_whole(course, integrator, result);
  if (motion.problem.cost_weights.any()) result.work = work(course, integrator);
  return result;
}

// Steepest slope of the growth, `advance` carrying perturbations through a step.
double steepest_growth(const StoredMotion& motion, const std::function<void(int, MatrixXd&)>& advance) {
  const int stride = std::max(1, motion.steps / growth_samples);
  const int turns = motion.system.velocity_count() - 3;
  MatrixXd perturbed = MatrixXd::Identity(2 * motion.system.velocity_count(), turns);
  double log_size = 0.0;                   // of what was divided off
  std::vector<double> log_growth = {0.0};  // ln G at every stride-th node
  for (int k = 0; k < motion.steps; ++k) {
    advance(k, perturbed);
    if ((k + 1) % stride != 0) continue;
    log_growth.push_back(log_size + std::log(algebra::largest_singular_value(perturbed.topRows(turns))));
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

}  // namespace

double growth_rate(const StoredMotion& motion) {
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  mechanics::Interval interval(motion.system.body_count());
  return steepest_growth(motion, [&](int k, MatrixXd& perturbed) {
    evidence::read_interval(motion, k, interval);
    integrator::linearize_step(motion.system, motion.lagrangian, motion.time_step, interval, motion.control[at(k)],
                               motion.control[at(k + 1)], work, tangent);
    perturbed = tangent.A * perturbed;
  });
}

double growth_rate(const StoredMotion& motion, const StageMotion& stages) {
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  return steepest_growth(motion, [&](int k, MatrixXd& perturbed) {
    for (int s = 0; s < stages.stages; ++s) {
      const std::size_t node = at(k * (stages.stages + 1) + s);
      integrator::linearize_step(motion.system, motion.lagrangian, stages.time_step[at(s)],
                                 stages.interval[at(k * stages.stages + s)], stages.control[node],
                                 stages.control[node + 1], work, tangent);
      perturbed = tangent.A * perturbed;
    }
  });
}

namespace {

Course course_of(const StoredMotion& motion) {
  return {motion, evidence::node_states(motion), control_function(motion)};
}

void follow(Course course, const ReplayOptions& options, Replay& result) {
  course.stopped = options.stopped;
  const StoredMotion& motion = course.motion;
  const maneuver::Feedback& feedback = motion.solution.feedback;
  if (feedback.gain.empty()) return;
  integrator::NodeMotion nodes{motion.solution.time, {}};
  for (const State& state : course.states) nodes.state.push_back(reference_state(motion.system, state));
  const integrator::FeedbackLaw law(integrator::MotionPath(motion.system, nodes), course.control, feedback.time,
                                    feedback.gain);
  const maneuver::MotorLimits motors(motion.system, motion.problem);
  ReferenceIntegrator integrator(motion.system, integrator::StateControl([&](double t, const ReferenceState& state) {
                                   return motors.within(law.moments(t, state));
                                 }),
                                 options.tolerance);
  ReferenceState state = nodes.state.front();
  if (!carry(course, 0, motion.steps, integrator, state)) return;
  const Distance miss = distance(state, course.states.back());
  result.feedback_rotation_error = miss.rotation;
  result.feedback_position_error = miss.position;
}

}  // namespace

void replay_with_feedback(const StoredMotion& motion, const ReplayOptions& options, Replay& result) {
  follow(course_of(motion), options, result);
}

void replay_with_feedback(const StoredMotion& motion, const StageMotion& stages, const ReplayOptions& options,
                          Replay& result) {
  follow(course_of(motion, stages), options, result);
}

Replay replay(const StoredMotion& motion, const ReplayOptions& options) {
  Replay result = replayed(course_of(motion), growth_rate(motion), options);
  replay_with_feedback(motion, options, result);
  replay_with_servos(motion, result);
  return result;
}

Replay replay(const StoredMotion& motion, const StageMotion& stages, const ReplayOptions& options) {
  Replay result = replayed(course_of(motion, stages), growth_rate(motion, stages), options);
  replay_with_feedback(motion, stages, options, result);
  return result;
}

}  // namespace lamprey::certificate
