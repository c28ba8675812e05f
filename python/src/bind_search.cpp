// search: the Solver that goes on from its last answer.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <mutex>
#include <string_view>

#include "arrays.hpp"
#include "bound.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "long_call.hpp"
#include "model/input_error.hpp"
#include "module.hpp"
#include "result/resolve.hpp"
#include "search/solver.hpp"
#include "task/tasks.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;
using model::InputError;
using optimizer::Termination;

namespace {

struct Outcome {
  std::string status;
  std::string reason;
  int iterations;
  int evaluations;
  double wall_seconds;
};

std::array<std::optional<double>, 3> moves(const nb::object& move) {
  constexpr std::string_view allowed = "three entries, each a number (m) or \"free\"";
  if (!nb::isinstance<nb::sequence>(move))
    throw InputError("move",
                     fmt::format("found {}; allowed: {}; give three", nb::cast<std::string>(nb::repr(move)), allowed));
  if (nb::len(move) != 3)
    throw InputError("move", fmt::format("found {} entries; allowed: {}; give three", nb::len(move), allowed));
  std::array<std::optional<double>, 3> entries;
  for (std::size_t c = 0; c < 3; ++c) {
    const nb::object entry = move[c];
    if (nb::isinstance<nb::str>(entry) && nb::cast<std::string>(entry) == "free") continue;
    double number = 0.0;
    if (!nb::try_cast(entry, number))
      throw InputError("move", fmt::format("found {} as entry {}; allowed: {}; mend it",
                                           nb::cast<std::string>(nb::repr(entry)), c, allowed));
    entries[c] = number;
    if (!std::isfinite(*entries[c]))
      throw InputError("move",
                       fmt::format("found {}; allowed: finite numbers (m) or \"free\"; mend entry {}", *entries[c], c));
  }
  return entries;
}

// Without Python's lock; where Ctrl-C came meanwhile it is raised once the work is done.
void without_lock(const std::function<void()>& work) {
  if (const auto signal = run_long([&](const Interrupted&) { work(); })) throw nb::python_error(*signal);
}

// A search::Solver, the problem it began at, and its last answer as Python sees it.
class Solver {
 public:
  Solver(const Problem& problem, const Solution& solution)
      : file_(problem.file),
        system_(task::system_of(file_)),
        begun_(task::begun_results(file_, system_, "lamprey.Solver.solve()")),
        answer_(solution) {
    without_lock(
        [&] { solver_ = std::make_unique<search::Solver>(system_, file_.problem, answer_.results().solution); });
    goal_ = *file_.problem.goal;  // a problem without one is refused
    look();
  }
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  void set_goal(const nb::object& move, const nb::object& turn, const std::map<std::string, nb::object>& rotation,
                const std::map<std::string, nb::object>& angle) {
    const std::unique_lock lock = taken();
    maneuver::Goal goal = goal_;
    if (!move.is_none()) goal.move = moves(move);
    if (!turn.is_none()) {
      if (goal.rotation.size() == model::at(system_.body_count()))
        throw InputError("turn",
                         "found it where the goal gives every body's rotation, which a turn leaves as it is; give "
                         "rotation = {...} of those that are to move");
      goal.turn = three(turn, "turn", "a rotation vector (rad)");
    }
    for (const auto& [body, vector] : rotation) {
      require_body(body);
      goal.rotation[body] = three(vector, "rotation." + body, "a rotation vector (rad)");
    }
    for (const auto& [joint, angles] : angle) goal.angle[joint] = angles_of(joint, angles);
    solver_->set_goal(goal);
    goal_ = goal;
    look();
  }

  void set_start(nb::handle rotation, nb::handle position, nb::handle angular_velocity, nb::handle linear_velocity) {
    const std::unique_lock lock = taken();
    const auto bodies = model::at(system_.body_count());
    maneuver::Start start;
    for (const Eigen::Matrix3d& R : rotations(rotation, bodies, "rotation")) start.rotation.push_back(lie::log(R));
    start.position = three(position, "position", "a position (m)");
    start.angular_velocity.assign(bodies, Eigen::Vector3d::Zero());
    if (!angular_velocity.is_none()) start.angular_velocity = vectors(angular_velocity, bodies, "angular_velocity");
    if (linear_velocity.is_none()) {
      solver_->set_start(maneuver::start_without_momentum(system_, start));
    } else {
      if (angular_velocity.is_none())
        throw InputError("angular_velocity",
                         "missing beside linear_velocity; give that of each body, (bodies, 3) rad/s, which momentum "
                         "depends on, too");
      start.linear_velocity = three(linear_velocity, "linear_velocity", "a velocity (m/s)");
      solver_->set_start(maneuver::start_as_seen(system_, start));
    }
    look();
  }

  void set_duration(double duration) {
    const std::unique_lock lock = taken();
    solver_->set_duration(duration);
    look();
  }

  void advance(double elapsed) {
    const std::unique_lock lock = taken();
    solver_->advance(elapsed);
    look();
  }

  Outcome solve(std::optional<int> max_iterations, std::optional<double> time_limit) {
    const std::unique_lock lock = taken();
    if (max_iterations && *max_iterations < 0)
      throw InputError("max_iterations",
                       fmt::format("found {}; allowed: whole numbers from 0; choose one", *max_iterations));
    if (time_limit && !(*time_limit > 0.0))
      throw InputError("time_limit", fmt::format("found {}; allowed: a number > 0 (s); choose one", *time_limit));
    optimizer::Options options = search::Solver::newton_options();
    if (max_iterations) options.most_iterations = *max_iterations;
    if (time_limit) options.time_limit = *time_limit;
    optimizer::Outcome outcome;
    std::optional<result::Results> found;
    double seconds = 0.0;
    const auto signal = run_long([&](const Interrupted& interrupted) {
      options.interrupted = interrupted;
      const auto begin = std::chrono::steady_clock::now();
      outcome = solver_->solve(options);
      seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      if (outcome.termination == Termination::converged) found = described(outcome, seconds);
    });
    if (found) answer_ = Solution(std::move(*found));
    look();
    if (signal) throw nb::python_error(*signal);
    return {std::string(file::word(search::status_of(outcome))), outcome.reason, outcome.iterations,
            outcome.evaluations, seconds};
  }

  const Solution& answer() const { return answer_; }
  Solution solution(bool feedback) {
    const std::unique_lock lock = taken();
    if (!feedback || !answer_.results().solution.feedback.gain.empty()) return answer_;
    result::Results results = answer_.results();
    without_lock([&] { results.solution.feedback = solver_->feedback(); });
    return Solution(std::move(results));
  }
  bool answered() const { return answered_; }
  double passed() const { return passed_; }

  nb::dict path() const {
    nb::dict words;
    for (const char* key : {"time", "position", "rotation", "control"}) words[key] = answer_.array(key);
    return words;
  }

 private:
  std::unique_lock<std::mutex> taken() {
    std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) throw std::runtime_error("a Solver is for one thread at a time; make another one for this thread");
    return lock;
  }

  // What other threads may ask while this one solves.
  void look() {
    answered_ = solver_->answers();
    passed_ = solver_->passed();
  }

  std::vector<double> angles_of(const std::string& name, nb::handle given) const {
    std::string known;
    for (const model::Joint& joint : system_.joints()) {
      const auto freedoms = static_cast<std::size_t>(model::freedoms_of(joint.kind));
      if (joint.name == name && freedoms > 0)
        return several(given, freedoms, "angle." + name,
                       freedoms == 3   ? "three numbers, a ball joint's rotation vector (rad)"
                       : freedoms == 2 ? "two numbers, an angle about each axis (rad)"
                                       : "one number, a hinge's angle (rad)");
      if (freedoms > 0) known += (known.empty() ? "" : ", ") + joint.name;
    }
    throw InputError("angle." + name,
                     "found a name of no joint that turns; allowed: " + known + "; choose one of them");
  }

  void require_body(const std::string& name) const {
    std::string known;
    for (const model::Body& body : system_.bodies()) {
      if (body.name == name) return;
      known += (known.empty() ? "" : ", ") + body.name;
    }
    throw InputError("rotation." + name, "found a name of no body; allowed: " + known + "; choose one of them");
  }

  // Waypoints stay where they are in the world while the start that they are seen from moves.
  void keep_waypoints(const Eigen::Vector3d& start, result::ResolvedProblem& problem) const {
    for (maneuver::Waypoint& waypoint : problem.waypoints) {
      for (int c = 0; c < 3; ++c)
        if (auto& move = waypoint.move[static_cast<std::size_t>(c)]) *move += problem.start->position[c] - start[c];
      if (!waypoint.turn) continue;
      for (std::size_t i = 0; i < problem.bodies.size(); ++i)  // with a free shape the root alone turns
        if (waypoint.turns(problem.bodies[i].name, i == 0, problem.free_shape))
          waypoint.rotation.try_emplace(problem.bodies[i].name,
                                        lie::log(lie::exp(*waypoint.turn) * problem.start->rotation[i]));
      waypoint.turn.reset();
    }
  }

  // The solver's answer, its goal as seen from its own start.
  result::Results described(const optimizer::Outcome& outcome, double seconds) const {
    result::Results results = begun_;
    results.solution = solver_->solution();
    results.solution.status = maneuver::Status::optimal;
    results.solution.message = "Stationary by the solver's own measure; certify says what it is worth.";
    results.solution.solver.name = "lamprey newton";
    results.solution.solver.iterations = outcome.iterations;
    results.solution.solver.evaluations = outcome.evaluations;
    results.solution.solver.wall_seconds = seconds;
    const maneuver::Maneuver& maneuver = solver_->answered();
    results.problem.duration = solver_->duration();
    results.problem.time_step = solver_->duration() / maneuver.steps;
    if (maneuver.free_duration) results.problem.between = solver_->between();
    const Eigen::VectorXd velocity = integrator::velocity_of_state(system_, maneuver.start);
    keep_waypoints(maneuver.start.position, results.problem);
    results.problem.start = {maneuver.start.rotation, maneuver.start.position, velocity.tail<3>(),
                             mechanics::angular_velocities(system_, maneuver.start.rotation, velocity)};
    maneuver::Goal& goal = *results.problem.goal;
    goal.turn.reset();
    goal.rotation.clear();
    const std::size_t told = goal.periodic ? 1 : maneuver.end_rotation.size();  // bodies of a gait turn with the root
    for (std::size_t i = 0; i < told; ++i)
      if (const auto& end = maneuver.end_rotation[i]) goal.rotation[results.problem.bodies[i].name] = lie::log(*end);
    goal.angle.clear();
    goal.shape_of_start = false;
    for (int j = 0; j < system_.joint_count(); ++j) {
      const model::Joint& joint = system_.joint(j);
      if (!maneuver.tells_joint(j)) continue;
      const Eigen::Vector3d turn =
          mechanics::turn_from_zero(joint, *maneuver.end_joint[model::at(j)], Eigen::Vector3d::Zero());
      goal.angle[joint.name].assign(turn.data(), turn.data() + model::freedoms_of(joint.kind));
    }
    for (std::size_t c = 0; c < 3; ++c) {
      goal.move[c] = maneuver.end_position[c];
      if (goal.move[c]) *goal.move[c] -= maneuver.start.position[static_cast<Eigen::Index>(c)];
    }
    return results;
  }

  file::ProblemFile file_;
  model::System system_;
  result::Results begun_;
  std::unique_ptr<search::Solver> solver_;
  maneuver::Goal goal_;
  Solution answer_;
  bool answered_ = false;
  double passed_ = 0.0;
  std::mutex mutex_;
};

std::string shown(const Outcome& outcome) {
  return fmt::format("<lamprey.Outcome {}: {} iterations, {:.2g} s{}{}>", outcome.status, outcome.iterations,
                     outcome.wall_seconds, outcome.reason.empty() ? "" : ", ", outcome.reason);
}

}  // namespace

void bind_search(nb::module_& module) {
  nb::class_<Outcome>(module, "Outcome", "How Solver.solve ended.")
      .def_ro("status", &Outcome::status,
              "optimal (it converged), feasible (it keeps what is asked, but is not stationary), infeasible (no moment "
              "reaches it), "
              "stalled (none was found from the last answer on), time_limit "
              "or interrupted; unless optimal the last answer stays.")
      .def_ro("reason", &Outcome::reason, "One clause for a person; may be empty where it converged.")
      .def_ro("iterations", &Outcome::iterations, "Newton steps.")
      .def_ro("evaluations", &Outcome::evaluations, "Motions that were looked at.")
      .def_ro("wall_seconds", &Outcome::wall_seconds, "s, without the way through Python.")
      .def("__repr__", &shown);
  nb::class_<Solver>(
      module, "Solver",
      "One maneuver solved again and again as its goal, its start or the time left move, each time from the last "
      "answer on:\n"
      "what a vehicle runs that plans while it swims.\n\n"
      "Owns its workspace; for one thread at a time. Takes limits, waypoints, free durations, periodic goals and all "
      "costs, with schemes\nof order 1 or 2; the number of steps stays what it was. Begins at a solution of the "
      "problem, or of one like it: then `answered` is False.\nRaises InputError where the problem is not one that it "
      "takes "
      "or the solution has other nodes or bodies.")
      .def(
          "__init__",
          [](Solver* self, nb::handle problem, const Solution& solution) {
            new (self) Solver(problem_or_loaded(problem), solution);
          },
          "problem"_a, "solution"_a,
          nb::sig(
              "def __init__(self, problem: Problem | dict[str, typing.Any] | str | os.PathLike, solution: Solution) "
              "-> None"))
      .def("set_goal", &Solver::set_goal, nb::kw_only(), "move"_a = nb::none(), "turn"_a = nb::none(),
           "rotation"_a = std::map<std::string, nb::object>(), "angle"_a = std::map<std::string, nb::object>(),
           nb::sig("def set_goal(self, *, move: typing.Sequence[float | typing.Literal['free']] | None = None, turn: "
                   "numpy.typing.ArrayLike | None = None, rotation: dict[str, numpy.typing.ArrayLike] = {}, angle: "
                   "dict[str, numpy.typing.ArrayLike] = {}) -> None"),
           "Another goal, in the words of [goal] and seen from the problem's own start; what is left out stays.\n\n"
           "move: three entries, m or \"free\", world frame. turn: rotation vector, rad, world frame. rotation: "
           "absolute "
           "rotation vectors,\nbody → world, by body. angle: rad, by joint, as in [goal] angle. Rows stay what they "
           "were, only their values move: InputError "
           "otherwise, and where the goal breaks a limit.\nA goal where the swimmer rests is answered by staying.")
      .def("set_start", &Solver::set_start, "rotation"_a, "position"_a, "angular_velocity"_a = nb::none(),
           "linear_velocity"_a = nb::none(),
           nb::sig(
               "def set_start(self, rotation: numpy.typing.ArrayLike, position: numpy.typing.ArrayLike, "
               "angular_velocity: "
               "numpy.typing.ArrayLike | None = None, linear_velocity: numpy.typing.ArrayLike | None = None) -> None"),
           "Another start, such as the state that was just measured; the goal stays where it is in the world.\n\n"
           "rotation: (bodies, 3, 3), body → world. position: (3,) m, mass centre of the root, world frame.\n"
           "angular_velocity: (bodies, 3) rad/s, body frames; left out: still joints. linear_velocity needs it.\n"
           "linear_velocity: (3,) m/s, mass centre of the root, world frame: the whole moves, and carries momentum, as "
           "it "
           "was seen to; for problems\nwhose own start carries some. Left out: only the joints' rates count, and the "
           "whole "
           "moves as total momentum\nzero demands, which moments cannot change.\nRotations off their joints by less "
           "than "
           "0.1 rad are\nled back onto them, and joints seen beyond a limit of angle, swing or twist by less than that "
           "begin at it, "
           "still;\nInputError beyond, and where bodies are beyond a clearance or a keep-out by more than a hundredth "
           "of "
           "the swimmer's size. After advance, which sets a start of its own. Not for periodic goals.")
      .def("set_duration", &Solver::set_duration, "duration"_a,
           "Another duration in as many steps, s: the time that is left. Moments stretch with it.\n\nInputError where "
           "it "
           "is free or waypoints are tied to times.")
      .def(
          "advance", &Solver::advance, "elapsed"_a,
          "Time has passed, s, with the swimmer on the last answer: asks for what is left of it, in as many steps.\n\n"
          "The start is where the swimmer is now by that answer; set_start after it tells where it was seen. The time "
          "left "
          "is less by\nelapsed, bounds of a free duration are, too, and the next solve begins at the rest of the "
          "answer. "
          "Until one arrives, times\nadd up. A least duration that has passed becomes a thousandth of the most; work "
          "per "
          "distance is that of the rest.\nInputError where nothing is left, for periodic goals and where waypoints are "
          "tied to times.")
      .def(
          "solve", &Solver::solve, nb::kw_only(), "max_iterations"_a = nb::none(), "time_limit"_a = nb::none(),
          "Newton steps from the last answer on; releases the GIL.\n\n"
          "The outcome says whether they arrived; unless they did the last answer stays. max_iterations: Newton steps "
          "in all, "
          "500 and more while they pay where none are given. time_limit: s; where it ended a search the next one goes "
          "on. Ctrl-C raises KeyboardInterrupt; InputError where max_iterations is negative or time_limit not above 0; "
          "RuntimeError where another thread is in this Solver.")
      .def_prop_ro(
          "answered", &Solver::answered,
          "Whether the last answer belongs to the goal, start and duration that were set last: false from then "
          "on until a solve arrives, and after one that does not. Ends that moments do not reach by less than 1e-6 "
          "(rad, units of length), "
          "as of a\nplanar swimmer measured a little out of its plane, count as they are reached.")
      .def_prop_ro(
          "passed", &Solver::passed,
          "s of the last answer that have passed, by advance; 0 from a solve on that arrives. Where one does not, a "
          "vehicle goes on by\nthe rest of what it has: simulate(feedback=solver.solution(feedback=True), "
          "feedback_from=solver.passed).")
      .def_prop_ro(
          "path", &Solver::path, nb::sig("def path(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]"),
          "The last answer's arrays by name: \"time\", \"position\", \"rotation\" and \"control\", as in Solution.")
      .def_prop_ro(
          "cost", [](const Solver& self) { return self.answer().results().solution.cost; },
          "Of the last answer, by the problem's rule.")
      .def("solution", &Solver::solution, nb::kw_only(), "feedback"_a = false,
           "The last answer with velocities and momenta; at first the solution that was given. Its certificate is "
           "None: see certify.\n\n"
           "feedback: with gains about it, for simulate(feedback=) or a vehicle that follows it until the next answer; "
           "ValueError where that answer is no motion.");
}

}  // namespace lamprey::python
