#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "file/words.hpp"
#include "integrator/scheme.hpp"
#include "lie/so3.hpp"
#include "maneuver/feedback.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/motor_limits.hpp"
#include "maneuver/random.hpp"
#include "maneuver/tracking.hpp"
#include "result/followed_file.hpp"
#include "result/resolve.hpp"
#include "result/sampled_functions.hpp"
#include "shape/gait_cycles.hpp"
#include "task/march_remarks.hpp"
#include "task/tasks.hpp"

namespace lamprey::task {

namespace {

using maneuver::Problem;

// A function of time becomes its values at the march's nodes, of one cycle.
void sample_angles(MarchOptions& options, const Problem& problem) {
  if (!options.angle) return;
  const double duration = options.duration > 0.0 ? options.duration / options.cycles : problem.duration.value;
  const int steps = options.steps > 0 ? options.steps : problem.steps;
  const bool of_one_cycle = options.steps == 0 && options.duration == 0.0;  // and the march takes as many in each
  if (!of_one_cycle && steps % options.cycles != 0)
    throw model::InputError("cycles", fmt::format("found {} in {} steps; allowed: as many steps in each cycle of a "
                                                  "function of time; set steps to a multiple of {}",
                                                  options.cycles, steps, options.cycles));
  const int nodes = of_one_cycle ? steps : steps / options.cycles;
  result::AngleSamples samples;
  for (int k = 0; k <= nodes; ++k) {
    samples.time.push_back(k * duration / nodes);
    const bool ends = k > 0 && options.interrupted && options.interrupted();  // the march will not come so far
    samples.angle.push_back(ends ? samples.angle.back() : options.angle(samples.time.back()));
  }
  options.angles = std::move(samples);
}

// Angles are marched along from their first time to their last one, in steps as long as the problem's, or with a free duration in as
// many, where nothing else is asked for.
void take_span_of_angles(const MarchOptions& options, Problem& problem) {
  if (!options.angles || options.duration > 0.0) return;
  const double span = options.angles->time.back() - options.angles->time.front();
  if (options.steps == 0) {
    const double step = problem.duration.free ? span / options.cycles / problem.steps : problem.time_step();
    const double steps = std::round(span / step);
    if (!(steps <= static_cast<double>(file::step_limit)))
      throw model::InputError(
          options.angles_path, "t",
          fmt::format("found {} s in steps of {} s; allowed: at most {} steps; march fewer cycles or "
                      "--steps fewer",
                      span, step, file::step_limit));
    problem.steps = std::max(1, static_cast<int>(steps));
  }
  problem.duration = {.free = false, .value = span};
}

void override_march(const MarchOptions& options, Problem& problem) {
  if (options.steps > 0) problem.steps = options.steps;
  if (options.duration > 0.0) problem.duration = {.free = false, .value = options.duration};
  if (options.scheme) problem.scheme = *options.scheme;
}

// A free duration is that of the maneuver whose moments are marched, where no other is asked for.
void take_duration(const MarchOptions& options, Problem& problem) {
  if (!problem.duration.free) return;
  if (options.followed && !options.followed->solution.time.empty())
    problem.duration = {.free = false, .value = options.followed->solution.time.back()};
  if (options.controls) problem.duration = {.free = false, .value = options.controls->time.back()};
}

// A march that begins in the midst of a maneuver takes what is left of it, in as large a share of the problem's steps, where nothing
// else is asked for.
void take_rest(const MarchOptions& options, Problem& problem) {
  if (options.followed_from == 0.0) return;
  const double whole = options.followed->solution.time.empty() ? 0.0 : options.followed->solution.time.back();
  const double left = whole - options.followed_from;
  if (!(left > 0.0))
    throw model::InputError(
        "feedback_from",
        fmt::format("found {} s of a maneuver that takes {} s; allowed: less than that; set a smaller --feedback-from",
                    options.followed_from, whole));
  if (options.duration > 0.0) return;
  if (options.steps == 0)
    problem.steps = std::max(1, static_cast<int>(std::round(left / whole * static_cast<double>(problem.steps))));
  problem.duration = {.free = false, .value = left};
}

// Several cycles are those of a stored gait.
void require_gait(const MarchOptions& options) {
  const auto refuse = [](const std::string& found) {
    throw model::InputError("cycles",
                            "found " + found +
                                "; allowed: more than one with the controls or the feedback of a stored gait "
                                "(goal.periodic = true), or with a table of moments or angles that ends where it "
                                "begins; leave it out");
  };
  if (!options.controls && !options.followed) refuse("a march without a stored motion");
  const bool gait = options.controls ? options.controls->gait
                                     : options.followed->problem.goal && options.followed->problem.goal->periodic;
  if (!gait)
    refuse("a motion that is not a gait in " + (options.controls ? options.controls_path : options.followed_path));
  if (options.followed && options.followed->solution.time.size() < 2) refuse("no motion in " + options.followed_path);
}

void require_few_rows(const MarchOptions& options, std::size_t rows) {
  if (static_cast<double>(rows) * options.cycles <= static_cast<double>(file::step_limit)) return;
  throw model::InputError(
      "cycles", fmt::format("found {} of {} rows each; allowed: at most {} rows in all; march fewer", options.cycles,
                            rows, file::step_limit));
}

// A stored gait, or the period of a table, again and again, and the march as long.
void repeat_gait(MarchOptions& options, Problem& problem) {
  if (options.cycles == 1) return;
  if (options.angles) require_few_rows(options, options.angles->time.size());
  if (options.controls) require_few_rows(options, options.controls->time.size());
  if (options.angles)
    return result::repeat(options.cycles, options.angles_path, problem.swimmer.joints, *options.angles);
  const bool of_table = options.controls && (options.controls->source == result::ControlSource::table ||
                                             options.controls->source == result::ControlSource::lines);
  if (of_table)
    result::require_period(options.controls_path, problem.swimmer.joints, *options.controls);
  else
    require_gait(options);
  const double steps_of_cycle =
      of_table ? std::max(1.0, std::round(options.controls->time.back() / problem.time_step())) : problem.steps;
  const double steps = steps_of_cycle * options.cycles;
  if (options.steps == 0 && !(steps <= static_cast<double>(file::step_limit)))
    throw model::InputError("cycles", fmt::format("found {} of {} steps each; allowed: at most {} steps in all; march "
                                                  "fewer, or --steps fewer",
                                                  options.cycles, steps_of_cycle, file::step_limit));
  if (options.controls) result::repeat(options.cycles, *options.controls);
  if (options.followed) options.followed->solution = shape::repeated(options.followed->solution, options.cycles);
  if (options.steps == 0) problem.steps = static_cast<int>(steps);
  if (options.duration == 0.0)
    problem.duration = {
        .free = false,
        .value = options.controls ? options.controls->time.back() : options.followed->solution.time.back()};
}

// Beyond its first and last rows nobody knows what moments or angles do.
void require_whole_march(const std::vector<double>& time, const std::string& what, const std::string& path,
                         double duration) {
  const double first = time.front(), last = time.back(), round_off = 1e-9 * duration;
  if (first <= round_off && last >= duration - round_off) return;
  throw model::InputError(
      path, "t",
      fmt::format("found {} from {} s to {} s; allowed: those of the whole march, from 0 to {} s; {}", what, first,
                  last, std::max(last, duration),
                  first > round_off ? "add a row at 0 s" : "add rows, or set a shorter --duration"));
}

// How fast a gait begins, and with a free shape how it is bent, is part of its answer, not of the problem: where the problem
// asks for one its first node does, placed and headed as the problem says.
void begin_as(const std::optional<maneuver::Start>& gait, Problem& problem) {
  maneuver::Start& start = problem.start;
  if (!gait || !problem.goal || !problem.goal->periodic || gait->rotation.size() != start.rotation.size()) return;
  const Eigen::Matrix3d heading = lie::exp(start.rotation[0]) * lie::exp(gait->rotation[0]).transpose();
  for (std::size_t i = 0; i < start.rotation.size(); ++i)
    start.rotation[i] = lie::log(heading * lie::exp(gait->rotation[i]));
  start.angular_velocity = gait->angular_velocity;
  start.linear_velocity = heading * gait->linear_velocity;
  start.free_shape = false;
}

// And where it is followed, the plan begins there.
void place_gait(const Problem& problem, result::Results& gait) {
  if (!problem.goal || !problem.goal->periodic || !gait.problem.goal || !gait.problem.goal->periodic) return;
  gait.solution = shape::begun_at(gait.solution, problem.start.position, lie::exp(problem.start.rotation[0]));
}

// A maneuver to follow, and the swimmer that it was made for.
struct Followed {
  const result::Results& results;
  double from;  // s of its time, at which the march begins
  model::System system;
  result::ControlSamples plan;
  integrator::FeedbackLaw law;

  Followed(const result::Results& read, const std::string& path, double begin)
      : results(read),
        from(begin),
        system(result::problem_of(results).swimmer),
        plan(result::controls_of_results(results, path, result::problem_of(results).swimmer.joints)),
        law(maneuver::feedback_law(system, results.solution, result::control_function(plan, system))) {}
  Followed(const Followed&) = delete;
  Followed& operator=(const Followed&) = delete;
};

void perturb(const MarchOptions& options, const model::System& system, const Followed* followed, Problem& problem) {
  if (options.perturb == 0.0) return;
  const int turns = system.velocity_count() - 3;
  problem.start =
      maneuver::turned_start(system, problem.start, options.perturb, options.seed,
                             followed ? maneuver::answered_turns(system, followed->results.solution.feedback)
                                      : Eigen::MatrixXd(Eigen::MatrixXd::Identity(turns, turns)));
}

// The stored motion that moments belong to, where the march takes the same steps with as many bodies joined alike.
const maneuver::NodePath* motion_of(const result::ControlSamples& samples, const model::System& system,
                                    const Problem& problem) {
  constexpr double round_off = 1e-9;  // of a step
  if (samples.motion.position.size() < 2 || samples.scheme != problem.scheme) return nullptr;
  bool same_tree = samples.motion.rotation.front().size() == static_cast<std::size_t>(system.body_count()) &&
                   samples.links.size() == static_cast<std::size_t>(system.joint_count());
  for (int j = 0; j < system.joint_count() && same_tree; ++j)
    same_tree = samples.links[static_cast<std::size_t>(j)] == std::pair(system.joint(j).parent, system.joint(j).child);
  const double step = samples.time[1] - samples.time[0];
  return same_tree && std::abs(step - problem.time_step()) <= round_off * step ? &samples.motion : nullptr;
}

// By more than the round-off of a plan that stands at its limits.
bool cuts(const mechanics::Moments& asked, const mechanics::Moments& given) {
  constexpr double round_off = 1e-6;
  for (std::size_t j = 0; j < asked.size(); ++j)
    if ((asked[j] - given[j]).norm() > round_off * asked[j].norm()) return true;
  return false;
}

// By the scheme or the reference integrator, under moments in time or under feedback.
maneuver::Solution march(const MarchOptions& options, const model::System& system, const Problem& problem,
                         const Followed* followed) {
  maneuver::SimulateOptions simulation{.adaptive = options.adaptive, .interrupted = options.interrupted};
  maneuver::ControlFunction control = maneuver::no_control(system);
  const maneuver::MotorLimits motors(system, problem);
  double asked = 0.0, cut = 0.0;   // how often moments were
  double asked_at = 0.0;           // s, the last time
  std::optional<double> cut_from;  // s
  if (options.control)
    control = [&](double time) { return maneuver::moments_at_zero_angle(system, options.control(time)); };
  if (options.controls) {
    control = result::control_function(*options.controls, system);
    simulation.motion = motion_of(*options.controls, system, problem);
  }
  if (followed) {
    if (followed->from == 0.0) simulation.motion = motion_of(followed->plan, system, problem);
    control = [followed](double time) { return followed->law.planned(followed->from + time); };
    simulation.feedback = [followed, &asked_at](double time, const integrator::ReferenceState& state) {
      asked_at = time;
      return followed->law.moments(followed->from + time, state);
    };
    if (motors.any())
      simulation.given = [&](const mechanics::Moments& moments) {
        mechanics::Moments given = motors.within(moments);
        ++asked;
        if (!cuts(moments, given)) return given;
        ++cut;
        cut_from = std::min(asked_at, cut_from.value_or(asked_at));
        return given;
      };
  }
  maneuver::Solution solution = options.reference
                                    ? maneuver::simulate_by_reference(system, problem, control, simulation)
                                    : maneuver::simulate(system, problem, control, simulation);
  if (followed) {
    solution.tracking = maneuver::tracking_of(followed->law, solution, followed->from);
    solution.tracking->maneuver = followed->results.name;
    if (asked > 0.0) solution.tracking->cut_share = cut / asked;
    solution.tracking->cut_from = cut_from;
  }
  return solution;
}

// And the problem begins as they do.
guess::JointAngles angles_to_follow(const MarchOptions& options, const model::System& system, bool gait,
                                    file::ProblemFile& file) {
  Problem& problem = file.problem;
  if (!guess::follows_angles(problem.scheme)) {
    const std::string message = fmt::format(
        "found {}; allowed where a march follows joint angles: paper, trapezoid, midpoint; choose one of them "
        "(--scheme)",
        file::word(problem.scheme));
    throw options.scheme ? model::InputError("scheme", message)
                         : file::located(model::InputError("integrator.scheme", message), file);
  }
  result::require_freedoms(*options.angles, options.angles_path, problem.swimmer.joints);
  guess::JointAngles along = result::angle_function(*options.angles);
  if (gait) along.passive_start = options.angles->first;
  problem.start = guess::start_along(system, problem, along);
  return along;
}

// Scheme, steps, duration and what is marched under, of so many cycles.
void lay_out(MarchOptions& options, Problem& problem) {
  sample_angles(options, problem);
  override_march(options, problem);
  repeat_gait(options, problem);
  take_span_of_angles(options, problem);
  take_duration(options, problem);
  take_rest(options, problem);
  const double duration = problem.duration.value;
  if (options.controls) require_whole_march(options.controls->time, "moments", options.controls_path, duration);
  if (options.angles) require_whole_march(options.angles->time, "angles", options.angles_path, duration);
}

// A swimmer whose bodies weigh other than the file says, fluid included: what a plan or its gains bear. Returns the factors, [bodies].
std::vector<double> perturb_inertia(const MarchOptions& options, file::ProblemFile& file) {
  std::vector<double> factors;
  if (options.perturb_inertia == 0.0) return factors;
  result::ResolvedProblem resolved = result::resolve(system_of(file), file.problem);
  maneuver::Random random(options.seed);
  for (result::ResolvedBody& body : resolved.bodies) {
    factors.push_back(1.0 + options.perturb_inertia * (2.0 * random.uniform() - 1.0));
    body.mass *= factors.back();
    for (Eigen::Matrix3d* part : {&body.body_inertia, &body.mass_matrix, &body.inertia_matrix, &body.coupling_matrix})
      *part *= factors.back();
  }
  file.problem.swimmer = result::swimmer_of(resolved);
  return factors;
}

std::string perturbed_words(const std::vector<double>& factors, const Problem& problem) {
  std::string words;
  for (std::size_t i = 0; i < factors.size(); ++i)
    words += fmt::format("{}{} {:.4g}", i == 0 ? "" : ", ", problem.swimmer.bodies[i].name, factors[i]);
  return words.empty() ? "" : " Inertia of bodies, fluid included, times what the file says: " + words + ".";
}

// The maneuver to follow, from where it begins.
std::unique_ptr<Followed> followed_from_start(MarchOptions& options, const model::System& system, Problem& problem) {
  if (!options.followed) return nullptr;
  result::require_followed(*options.followed, options.followed_path, system, options.followed_from,
                           problem.duration.value);
  place_gait(problem, *options.followed);
  auto followed = std::make_unique<Followed>(*options.followed, options.followed_path, options.followed_from);
  begin_as(followed->plan.first, problem);
  return followed;
}

// The nodes reached are the result, and one value at each where no spline ran through all of them.
void describe_as_marched(bool spline, result::Results& results) {
  const std::size_t nodes = results.solution.time.size();
  const bool ended = results.solution.status == maneuver::Status::simulated;
  if (!ended && nodes > 0) {
    results.problem.steps = static_cast<int>(nodes) - 1;
    results.problem.duration = results.solution.time.back();
  }
  if (ended && spline && results.problem.points <= results.problem.steps + 1) return;
  results.problem.control = maneuver::ControlKind::steps;
  results.problem.points = 0;
}

}  // namespace

result::Results march_task(file::ProblemFile file, MarchOptions options, const std::string& command) {
  const maneuver::Duration asked = file.problem.duration;
  lay_out(options, file.problem);
  const model::System as_planned = system_of(file);
  const std::vector<double> factors = perturb_inertia(options, file);
  const model::System system = system_of(file);
  const std::unique_ptr<Followed> followed = followed_from_start(options, system, file.problem);
  if (options.controls) begin_as(options.controls->first, file.problem);
  const Problem with_goal = file.problem;
  file.problem.goal.reset();  // marching seeks no goal
  perturb(options, system, followed.get(), file.problem);
  if (options.perturb != 0.0 || !factors.empty())
    file.problem.start = maneuver::with_momentum_of(as_planned, with_goal.start, system, file.problem.start);
  std::optional<guess::JointAngles> along;
  if (options.angles) along = angles_to_follow(options, system, with_goal.goal && with_goal.goal->periodic, file);
  result::Results results = begun_results(file, system, command);
  results.solution = along ? guess::march_along(system, file.problem, *along, options.interrupted)
                           : march(options, system, file.problem, followed.get());
  const std::string remarks =
      perturbed_words(factors, file.problem) + march_remarks(options, system, file.problem, with_goal, asked, results);
  if (std::string& message = results.solution.message; !remarks.empty())
    message += (message.ends_with('.') ? "" : ".") + remarks;
  describe_as_marched(!along && !options.control && !followed &&
                          (!options.controls || options.controls->source == result::ControlSource::spline),
                      results);
  return results;
}

}  // namespace lamprey::task
