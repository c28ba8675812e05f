#include "maneuver/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "integrator/march.hpp"
#include "lie/so3.hpp"
#include "maneuver/end_rows.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/motion.hpp"

namespace lamprey::maneuver {

namespace {

using integrator::exerted;
using integrator::March;
using integrator::State;
using integrator::StepReport;
using model::at;
using model::System;

constexpr int most_halvings = 12;    // of a step that is divided
constexpr int probed_halvings = 20;  // of a step that failed, to say what would have worked

bool finite(const State& state) {
  bool all = state.position.allFinite() && state.momentum.allFinite();
  for (const Matrix3d& R : state.rotation) all = all && R.allFinite();
  return all;
}

// A stretch of time, s.
struct Span {
  double begin;
  double end;
  double at(double fraction) const { return fraction == 1.0 ? end : begin + fraction * (end - begin); }
  /// The same, at the ends a hair within: moments may jump from one span to the next.
  double within(double fraction) const {
    if (fraction == 0.0) return std::nextafter(begin, end);
    return fraction == 1.0 ? std::nextafter(end, begin) : at(fraction);
  }
};

integrator::ReferenceState measured(const System& system, const State& state) {
  return {state.rotation, state.position, integrator::velocity_of_state(system, state)};
}

mechanics::Moments given_of(const integrator::MotorFunction& given, const mechanics::Moments& asked) {
  return given ? given(asked) : asked;
}

// Steps of a scheme under moments that run through time, or under a controller that answers the state.
class ControlledMarch {
 public:
  ControlledMarch(const System& system, Scheme scheme, const ControlFunction& control,
                  const integrator::StateControl& feedback, const integrator::MotorFunction& given)
      : system_(system),
        march_(system, scheme),
        control_(control),
        feedback_(feedback),
        given_(given),
        sample_(march_.nodes().size()) {}

  /// One step of the scheme; on failure the state is left as it was.
  StepReport advance(const Span& span, double time_step, State& state, const integrator::StageWitness& witness = {}) {
    for (std::size_t s = 0; s < sample_.size(); ++s)
      sample_[s] = exerted(system_, control_(span.within(march_.nodes()[s])));
    if (feedback_) sample_.front() = moments(span.begin, state);
    saved_ = state;
    std::size_t stage = 0;
    integrator::StageWitness settle;
    if (feedback_)
      settle = [&](const mechanics::Interval& interval, State& reached) {
        const double length = time_step * (march_.nodes()[stage + 1] - march_.nodes()[stage]);
        ++stage;
        sample_[stage] = integrator::settled_moments(system_, feedback_, given_, span.at(march_.nodes()[stage]), length,
                                                     sample_[stage], reached);
        if (witness) witness(interval, reached);
      };
    StepReport report = march_.advance(
        time_step, [&](int node) -> const mechanics::Moments& { return sample_[at(node)]; }, state,
        feedback_ ? settle : witness);
    if (report.converged && !finite(state)) {
      report.converged = false;
      state = saved_;
    }
    if (feedback_ && report.converged) {
      settled_ = sample_.back();
      settled_momentum_ = state.momentum;
    }
    return report;
  }

  /// Moments at a time and a state; where a step has ended, those that it has settled there, for a node has one.
  mechanics::Moments moments(double time, const State& state) const {
    if (!feedback_) return exerted(system_, control_(time));
    if (settled_momentum_.size() > 0 && settled_momentum_ == state.momentum) return settled_;
    return given_of(given_, exerted(system_, feedback_(time, measured(system_, state))));
  }
  /// Moments at a stage's node of the latest step.
  const mechanics::Moments& sample(std::size_t node) const { return sample_[node]; }

  void begin_at(const mechanics::Interval& motion) { march_.begin_at(motion); }
  void restart() { march_.restart(); }
  const std::vector<double>& nodes() const { return march_.nodes(); }

 private:
  const System& system_;
  March march_;
  const ControlFunction& control_;
  const integrator::StateControl& feedback_;
  const integrator::MotorFunction& given_;
  std::vector<mechanics::Moments> sample_;  // [stages + 1] of the latest step
  mechanics::Moments settled_;              // at its end, and the momentum there; empty: not yet
  VectorXd settled_momentum_;
  State saved_;
};

// Where the bodies stand at a scheme's stages within a step, and the moments there: along joints' axes they become
// vectors where the axes stand.
class StageNodes {
 public:
  struct Node {
    mechanics::Rotations rotation;
    mechanics::Moments moments;
  };
  explicit StageNodes(const std::vector<double>& nodes) : nodes_(nodes), kept_(nodes.size()), passed_(nodes.size()) {}

  void begin(const Node& node) {
    distance_.assign(nodes_.size(), std::numeric_limits<double>::infinity());
    take(0.0, node);
  }
  /// Told of the node after each stage of a part of the step that may yet fail.
  void pass(std::size_t stage, const Node& node) { passed_[stage] = node; }
  /// The part, one of `parts`, has not failed.
  void commit(int part, int parts) {
    for (std::size_t s = 1; s < nodes_.size(); ++s) take((part + nodes_[s]) / parts, passed_[s]);
  }
  const Node& at_node(std::size_t s) const { return kept_[s]; }

 private:
  // Each node keeps what is nearest to it, which is its own in a whole step.
  void take(double fraction, const Node& node) {
    for (std::size_t s = 0; s < nodes_.size(); ++s) {
      const double distance = std::abs(fraction - nodes_[s]);
      if (distance >= distance_[s]) continue;
      distance_[s] = distance;
      kept_[s] = node;
    }
  }

  const std::vector<double>& nodes_;
  std::vector<double> distance_;  // of kept_, in steps
  std::vector<Node> kept_;        // [stages + 1]
  std::vector<Node> passed_;      // [stages + 1] of the present part
};

class Simulation {
 public:
  Simulation(const System& system, const Problem& problem, const ControlFunction& control,
             const SimulateOptions& options)
      : system_(system),
        scheme_(problem.scheme),
        control_(control),
        feedback_(options.feedback),
        given_(options.given),
        known_(options.motion),
        known_interval_(system.body_count()),
        adaptive_(options.adaptive),
        h_(problem.time_step()),
        march_(system, problem.scheme, control, feedback_, given_),
        stages_(march_.nodes()) {}

  /// Node k as files have it: of moments that jump there the mean, which with equal steps is what both sides exert, and the state
  /// half way through it; but where files tell the moments of stages on both sides, the state between them.
  void append(int k, int steps, const State& reached, Solution& solution) const {
    const double time = k * h_;
    State state = reached;
    mechanics::Moments moments;
    if (feedback_ || steps == 0) {
      moments = march_.moments(time, state);
    } else if (k == 0) {
      moments = exerted(system_, control_(time));
    } else {
      moments = exerted(system_, control_(std::nextafter(time, time - h_)));
      if (k < steps) add_half_of_jump(exerted(system_, control_(std::nextafter(time, time + h_))), state, moments);
    }
    append_node(system_, time, state, moments, solution);
  }

  /// Step k, whole or, if allowed, in pieces; on failure the state is where it last was.
  bool advance(int k, State& state, Solution& solution) {
    const Span span{k * h_, (k + 1) * h_};
    if (keeps_stages()) stages_.begin({state.rotation, march_.moments(span.begin, state)});
    if (stands_as_known(k, state)) begin_as_known(k, state);
    const bool done =
        advance_part(span, 0, 1, state) || (adaptive_ && advance_in_pieces(span, state, solution.divided));
    if (done && keeps_stages()) append_stages(span, solution);
    return done;
  }

  /// Why step k failed, and what would have worked.
  std::string failure(int k, double duration, const State& state) const {
    std::ostringstream text;
    text << "step " << k << " at t = " << failed_.begin << " s did not converge (";
    if (std::isfinite(report_.residual) && report_.residual > 0.0) {
      text << "relative residual " << report_.residual;
    } else {
      text << "a residual beyond all numbers";
    }
    text << " after " << report_.iterations << " Newton iterations)";
    if (failed_step_ != h_) text << ", not even in pieces of " << failed_step_ << " s";
    const double works = shorter_working_step(state);
    if (works > 0.0) {
      text << "; a step of " << works << " s works from there: try " << std::ceil(duration / works) << " steps"
           << (adaptive_ ? "" : ", or --adaptive, which divides such steps");
    } else {
      text << "; no step down to " << std::ldexp(failed_step_, -probed_halvings)
           << " s works from there: look at the moments and the joints' angles at that time";
    }
    return text.str();
  }

 private:
  void add_half_of_jump(const mechanics::Moments& after, State& state, mechanics::Moments& moments) const {
    const VectorXd before = mechanics::generalized_force(system_, state.rotation, moments);
    for (std::size_t j = 0; j < moments.size(); ++j) moments[j] = 0.5 * (moments[j] + after[j]);
    if (keeps_stages()) return;
    state.momentum += 0.5 * last_step_ * (mechanics::generalized_force(system_, state.rotation, moments) - before);
  }

  // The step of the known motion, which is gone through again and again.
  std::size_t known_step(int k) const { return at(k) % (known_->position.size() - 1); }

  // The bodies stand to each other as they do in the known motion.
  bool stands_as_known(int k, const State& state) const {
    constexpr double near = 1e-2;  // rad, where the motion's own step is a guess as good as any
    if (!known_ || known_->position.size() < 2 || keeps_stages()) return false;
    const mechanics::Rotations& known = known_->rotation[known_step(k)];
    const Matrix3d heading = state.rotation[0] * known[0].transpose();
    for (std::size_t i = 0; i < known.size(); ++i)
      if (lie::rotation_angle(state.rotation[i].transpose() * (heading * known[i])) > near) return false;
    return true;
  }

  // The next step is sought from step k of the known motion on, as it is seen from the state.
  void begin_as_known(int k, const State& state) {
    const std::size_t n = known_step(k);
    const Matrix3d heading = state.rotation[0] * known_->rotation[n][0].transpose();
    mechanics::interval_between(system_, known_->rotation[n], known_->rotation[n + 1],
                                heading * (known_->position[n + 1] - known_->position[n]), known_interval_);
    march_.begin_at(known_interval_);
  }

  bool keeps_stages() const { return !integrator::single_step(scheme_); }

  // One of `pieces` equal parts of a step.
  bool advance_part(const Span& whole, int part, int pieces, State& state) {
    const double length = h_ / pieces;
    const Span span{part == 0 ? whole.begin : whole.begin + part * length,
                    part + 1 == pieces ? whole.end : whole.begin + (part + 1) * length};
    std::size_t stage = 0;
    integrator::StageWitness witness;
    if (keeps_stages())
      witness = [&](const mechanics::Interval&, const State& reached) {
        ++stage;
        stages_.pass(stage, {reached.rotation, march_.sample(stage)});
      };
    const StepReport report = march_.advance(span, length, state, witness);
    if (report.converged && keeps_stages()) stages_.commit(part, pieces);
    if (report.converged) {
      last_step_ = length;
      return true;
    }
    report_ = report;
    failed_ = span;
    failed_step_ = length;
    return false;
  }

  // Halves the piece that fails and goes on with pieces of that size.
  bool advance_in_pieces(const Span& whole, State& state, DividedSteps& divided) {
    int pieces = 1;
    int done = 0;
    int taken = 0;
    while (done < pieces) {
      if (pieces > 1 && advance_part(whole, done, pieces, state)) {
        ++done;
        ++taken;
        continue;
      }
      if (pieces >= 1 << most_halvings) return false;
      pieces *= 2;
      done *= 2;
      march_.restart();
    }
    march_.restart();
    const double piece = h_ / pieces;
    divided.smallest_step = divided.steps > 0 ? std::min(divided.smallest_step, piece) : piece;
    ++divided.steps;
    divided.substeps += taken;
    return true;
  }

  void append_stages(const Span& span, Solution& solution) const {
    std::vector<double> times;
    std::vector<Vectors> moments;
    for (std::size_t s = 0; s < march_.nodes().size(); ++s) {
      times.push_back(span.at(march_.nodes()[s]));
      const StageNodes::Node& node = stages_.at_node(s);
      const mechanics::Moments u =
          feedback_ ? node.moments : exerted(system_, control_(span.within(march_.nodes()[s])));
      moments.push_back(mechanics::applied_moments(system_, node.rotation, u));
    }
    solution.stage_time.push_back(times);
    solution.control_stages.push_back(moments);
  }

  // The first that works of those that are halved again and again; 0: none.
  double shorter_working_step(const State& state) const {
    ControlledMarch probe(system_, scheme_, control_, feedback_, given_);
    double length = failed_step_;
    for (int n = 0; n < probed_halvings; ++n) {
      length *= 0.5;
      State reached = state;
      probe.restart();
      if (probe.advance({failed_.begin, failed_.begin + length}, length, reached).converged) return length;
    }
    return 0.0;
  }

  const System& system_;
  Scheme scheme_;
  const ControlFunction& control_;
  const integrator::StateControl& feedback_;
  const integrator::MotorFunction& given_;
  const NodePath* known_;
  mechanics::Interval known_interval_;
  bool adaptive_;
  double h_;                // s, of whole steps
  double last_step_ = 0.0;  // s, of the latest one, or of the latest part of one
  ControlledMarch march_;
  StageNodes stages_;
  StepReport report_;         // of the part that failed last
  Span failed_{0.0, 0.0};     // its time
  double failed_step_ = 0.0;  // s, its length
};

std::string summary(const Solution& solution, int steps) {
  std::string text = "Marched " + std::to_string(steps) + " steps of the scheme.";
  if (solution.divided.steps > 0) {
    std::ostringstream pieces;
    pieces << " " << solution.divided.steps << " of them did not converge whole and were divided into "
           << solution.divided.substeps << " substeps, the smallest of " << solution.divided.smallest_step << " s.";
    text += pieces.str();
  }
  return text;
}

}  // namespace

ControlFunction no_control(const System& system) {
  const mechanics::Moments none(at(system.joint_count()), Vector3d::Zero());
  return [none](double) { return none; };
}

mechanics::Moments moments_at_zero_angle(const System& system, const Vectors& on_parent) {
  mechanics::Rotations zero(at(system.body_count()), Matrix3d::Identity());
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent >= 0) zero[at(i)] = zero[at(body.parent)] * system.joint(body.joint).reference_rotation;
  }
  return mechanics::moments_of_applied(system, zero, on_parent);
}

ControlFunction stage_polynomials(const std::vector<double>& time, const std::vector<mechanics::Moments>& samples,
                                  std::size_t stages) {
  return [time, samples, stages](double t) {
    std::size_t first = 0;  // of the step that holds t
    std::size_t beyond = time.size() / stages;
    for (std::size_t low = 0; low + 1 < beyond;) {
      const std::size_t middle = (low + beyond) / 2;
      (time[middle * stages] <= t ? low : beyond) = middle;
      first = low * stages;
    }
    t = std::clamp(t, time[first], time[first + stages - 1]);
    mechanics::Moments value(samples[first].size(), Vector3d::Zero());
    for (std::size_t s = 0; s < stages; ++s) {
      if (t == time[first + s]) return samples[first + s];
      double weight = 1.0;  // Lagrange's
      for (std::size_t other = 0; other < stages; ++other)
        if (other != s) weight *= (t - time[first + other]) / (time[first + s] - time[first + other]);
      for (std::size_t j = 0; j < value.size(); ++j) value[j] += weight * samples[first + s][j];
    }
    return value;
  };
}

Solution simulate(const System& system, const Problem& problem, const ControlFunction& control,
                  const SimulateOptions& options) {
  Solution solution;
  solution.status = Status::simulated;
  solution.cost = std::numeric_limits<double>::quiet_NaN();
  const double h = problem.time_step();
  State state = start_state(system, problem.start);
  Simulation simulation(system, problem, control, options);
  const auto append = [&](int k) {
    simulation.append(k, problem.steps, state, solution);
    return std::isfinite(solution.linear_velocity.back().sum());
  };
  const auto stop = [&](Status status, const std::string& message) {
    solution.status = status;
    solution.message = message;
    return solution;
  };
  const std::string no_velocity =
      "the velocity is not defined there: the two axes of a universal joint fall together; start elsewhere, or use a "
      "ball joint";
  if (!append(0)) return stop(Status::stalled, "step 0 at t = 0 s cannot begin: " + no_velocity);
  for (int k = 0; k < problem.steps; ++k) {
    if (options.interrupted && options.interrupted())
      return stop(Status::interrupted, "Interrupted at t = " + in_words(k * h) + " s.");
    if (!simulation.advance(k, state, solution))
      return stop(Status::stalled, simulation.failure(k, problem.duration.value, state));
    if (!append(k + 1)) {
      std::ostringstream text;
      text << "step " << k << " ends at t = " << (k + 1) * h << " s where " << no_velocity;
      return stop(Status::stalled, text.str());
    }
  }
  solution.message = summary(solution, problem.steps);
  return solution;
}

Solution simulate(const System& system, const Problem& problem, const ControlFunction& control,
                  const std::function<bool()>& interrupted) {
  return simulate(system, problem, control, SimulateOptions{.adaptive = false, .interrupted = interrupted});
}

Solution simulate_by_reference(const System& system, const Problem& problem, const ControlFunction& control,
                               const SimulateOptions& options, double tolerance) {
  Solution solution;
  solution.status = Status::simulated;
  solution.cost = std::numeric_limits<double>::quiet_NaN();
  solution.marched_by = integrator::reference_scheme(tolerance);
  const integrator::StateControl applied = [&](double time, const integrator::ReferenceState& state) {
    if (!options.feedback) return exerted(system, control(time));
    return given_of(options.given, exerted(system, options.feedback(time, state)));
  };
  integrator::ReferenceIntegrator integrator(system, applied, tolerance);
  const double h = problem.time_step();
  integrator::ReferenceState state = measured(system, start_state(system, problem.start));
  const auto append = [&](double time) {
    append_node(system, time, integrator::state_of_velocity(system, state.rotation, state.position, state.velocity),
                applied(time, state), solution);
  };
  append(0.0);
  for (int k = 0; k < problem.steps; ++k) {
    std::ostringstream time;
    time << "t = " << k * h << " s";
    if (options.interrupted && options.interrupted()) {
      solution.status = Status::interrupted;
      solution.message = "Interrupted at " + time.str() + ".";
      return solution;
    }
    if (!integrator.advance(k * h, (k + 1) * h, state)) {
      solution.status = Status::stalled;
      solution.message = "the reference integrator finds no way on from " + time.str() +
                         ": its steps fall to nothing or numbers leave the finite; look at the moments and the joints' "
                         "angles at that time";
      return solution;
    }
    append((k + 1) * h);
  }
  solution.message = "Marched by " + solution.marched_by + ".";
  return solution;
}

}  // namespace lamprey::maneuver
