// task: what `lamprey solve`, `simulate` and `verify` do.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <unistd.h>

#include <cmath>
#include <functional>
#include <thread>
#include <vector>

#include "arrays.hpp"
#include "bound.hpp"
#include "file/problem_file.hpp"
#include "file/words.hpp"
#include "long_call.hpp"
#include "march_input.hpp"
#include "model/input_error.hpp"
#include "module.hpp"
#include "result/solution_file.hpp"
#include "task/choices.hpp"
#include "task/finer_steps.hpp"
#include "task/tasks.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;
using model::InputError;

namespace {

// What a call was given beside its problem, for provenance.
class Call {
 public:
  explicit Call(const char* name) : text_(std::string("lamprey.") + name + "(problem") {}
  template <class Value>
  void add(const char* word, const std::optional<Value>& value) {
    if (value) text_ += fmt::format(", {}={}", word, *value);
  }
  std::string text() const { return text_ + ")"; }

 private:
  std::string text_;
};

void require_positive(const char* key, const std::optional<double>& value) {
  if (value && !(*value > 0.0 && std::isfinite(*value)))
    throw InputError(key, fmt::format("found {}; allowed: finite numbers > 0 (s); change it", *value));
}

int threads(const std::optional<int>& workers) {
  if (!workers) return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  if (*workers < 1 || *workers > task::most_workers)
    throw InputError("workers",
                     fmt::format("found {}; allowed: from 1 to {}; change it", *workers, task::most_workers));
  return *workers;
}

// Lines to a Python function, from any thread of this process, until it raises.
std::function<void(const std::string&)> told_to(const nb::object& progress, Raised& raised) {
  if (progress.is_none()) return {};
  if (!nb::isinstance<nb::callable>(progress))
    throw nb::type_error("progress: found no function; allowed: a function of one line of text, or None");
  return [&progress, &raised, process = getpid(), ended = std::make_shared<bool>(false)](const std::string& line) {
    if (getpid() != process) return;  // a forked worker has no Python
    const nb::gil_scoped_acquire lock;
    if (*ended) return;
    try {
      progress(line);
    } catch (nb::python_error& error) {
      *ended = true;
      raised.emplace(std::move(error));
    }
  };
}

// Adds what there is to an exception that ended the work, as its attribute `solution`, and throws it.
[[noreturn]] void throw_with(const nb::python_error& signal, const nb::object& found) {
  try {
    nb::setattr(signal.value(), "solution", found);
  } catch (nb::python_error& refused) {  // of a class that has no room for it
    refused.discard_as_unraisable("lamprey.solve");
  }
  throw nb::python_error(signal);
}

// A motion, or the directory of one; `word` is the argument.
std::optional<task::EarlierMotion> stored_motion(const nb::object& motion, const char* word) {
  if (motion.is_none()) return std::nullopt;
  if (nb::isinstance<Trajectory>(motion))
    return task::EarlierMotion{nb::cast<const Trajectory&>(motion).results(), word};
  std::filesystem::path folder;
  if (!nb::try_cast(motion, folder))
    throw nb::type_error((std::string(word) +
                          ": found neither a motion nor a path; allowed: a Solution, a Trajectory, or "
                          "the directory of one")
                             .c_str());
  const std::string directory = folder.string();
  return task::EarlierMotion{result::read_solution(directory), directory + "/solution.json"};
}

Solution solve(nb::handle asked, const std::optional<int>& workers, const std::optional<std::string>& solver,
               const std::optional<bool>& refinement, const std::optional<double>& time_limit, const nb::object& first,
               const nb::object& progress, bool resolve) {
  const Problem problem = problem_or_loaded(asked);
  Call call("solve");
  call.add("workers", workers);
  call.add("solver", solver);
  call.add("refinement", refinement);
  call.add("time_limit", time_limit);
  require_positive("time_limit", time_limit);
  file::ProblemFile file = problem.file;
  if (time_limit) file.problem.search.time_limit = time_limit;
  search::SolveOptions options;
  if (solver) options.solver = task::backend_named("solver", *solver);
  options.workers = threads(workers);
  options.refinement = refinement;
  Raised raised;
  options.progress = told_to(progress, raised);
  std::optional<result::Results> results;
  const std::optional<task::EarlierMotion> begin = stored_motion(first, "first");
  if (begin) call.add("first", std::optional(begin->path));
  if (resolve) call.add("resolve", std::optional<std::string>("True"));
  const auto task = resolve ? task::resolve_task : task::solve_task;
  const auto work = [&](const Interrupted& interrupted) {
    options.interrupted = interrupted;
    options.hurried = [interrupted] { return interrupted.again(); };
    results = task(file, options, call.text(), begin);
  };
  const Raised signal = run_long(work, &raised);
  if (signal && results) throw_with(*signal, nb::cast(Solution(std::move(*results))));
  if (signal) throw nb::python_error(*signal);
  return Solution(std::move(*results));
}

void take_followed(const nb::object& feedback, task::MarchOptions& options) {
  if (std::optional<task::EarlierMotion> followed = stored_motion(feedback, "feedback")) {
    options.followed = std::move(followed->results);
    options.followed_path = followed->path;
  }
}

Trajectory simulate(nb::handle asked, const nb::object& controls, const std::optional<std::string>& scheme,
                    const std::optional<int>& steps, const std::optional<double>& duration, int cycles, bool adaptive,
                    bool reference, const nb::object& feedback, double perturb, std::uint64_t seed,
                    const nb::object& angles, double feedback_from, double perturb_inertia) {
  const Problem problem = problem_or_loaded(asked);
  Call call("simulate");
  call.add("scheme", scheme);
  call.add("steps", steps);
  call.add("duration", duration);
  if (cycles != 1) call.add("cycles", std::optional(cycles));
  if (adaptive) call.add("adaptive", std::optional(adaptive));
  if (reference) call.add("reference", std::optional(reference));
  if (feedback_from > 0.0) call.add("feedback_from", std::optional(feedback_from));
  if (perturb > 0.0) call.add("perturb", std::optional(perturb));
  if (perturb_inertia > 0.0) call.add("perturb_inertia", std::optional(perturb_inertia));
  if (perturb > 0.0 || perturb_inertia > 0.0) call.add("seed", std::optional(seed));
  if (steps && (*steps < 1 || *steps > file::step_limit))
    throw InputError("steps", fmt::format("found {}; allowed: from 1 to {}; change it", *steps, file::step_limit));
  require_positive("duration", duration);
  if (cycles < 1 || cycles > task::most_cycles)
    throw InputError("cycles", fmt::format("found {}; allowed: from 1 to {}; change it", cycles, task::most_cycles));
  if (!(perturb >= 0.0 && perturb <= 3.0))
    throw InputError("perturb", fmt::format("found {}; allowed: from 0 to 3 (rad); change it", perturb));
  if (!(perturb_inertia >= 0.0 && perturb_inertia <= 0.9))
    throw InputError("perturb_inertia", fmt::format("found {}; allowed: from 0 to 0.9; change it", perturb_inertia));
  if (!(feedback_from >= 0.0 && std::isfinite(feedback_from)))
    throw InputError("feedback_from", fmt::format("found {}; allowed: from 0 on (s); change it", feedback_from));
  if (feedback_from > 0.0 && feedback.is_none())
    throw InputError("feedback_from",
                     "found without feedback; allowed: the time of a maneuver in feedback; leave it out");
  if (!controls.is_none() && !feedback.is_none())
    throw InputError("feedback", "found beside controls; allowed: one of them; leave one out");
  if (!angles.is_none() && (!controls.is_none() || !feedback.is_none() || reference || adaptive || perturb > 0.0))
    throw InputError("angles",
                     "found beside controls, feedback, reference, adaptive or perturb; allowed: without "
                     "them; leave them out");
  if (reference && (scheme || adaptive))
    throw InputError("reference", "found beside scheme or adaptive; allowed: without them; leave them out");
  task::MarchOptions options{.steps = steps.value_or(0),
                             .duration = duration.value_or(0.0),
                             .cycles = cycles,
                             .adaptive = adaptive,
                             .reference = reference,
                             .perturb = perturb,
                             .perturb_inertia = perturb_inertia,
                             .seed = seed};
  if (scheme) options.scheme = task::scheme_named("scheme", *scheme);
  take_controls(controls, problem.file.problem.swimmer.joints, options);
  take_angles(angles, problem.file.problem.swimmer.joints, options);
  take_followed(feedback, options);
  options.followed_from = feedback_from;
  std::optional<result::Results> results;
  const auto signal = run_long([&](const Interrupted& interrupted) {
    options.interrupted = interrupted;
    results = task::march_task(problem.file, options, call.text());
  });
  if (signal && results) throw_with(*signal, nb::cast(Trajectory(std::move(*results))));
  if (signal) throw nb::python_error(*signal);
  return Trajectory(std::move(*results));
}

template <class Motion>
Motion certify(const Motion& motion) {
  std::optional<result::Results> results;
  const auto signal = run_long([&](const Interrupted&) { results = task::certified(motion.results()); });
  if (signal) throw nb::python_error(*signal);
  return Motion(std::move(*results));
}

nb::object number_or_none(double value) { return std::isnan(value) ? nb::none() : nb::cast(value); }

nb::object verdict_or_none(const result::Results& results) {
  const bool judged = results.certificate && results.certificate->verdict;
  return judged ? nb::cast(std::string(file::word(*results.certificate->verdict))) : nb::none();
}

nb::tuple verify(const std::filesystem::path& directory, const nb::object& problem) {
  std::optional<file::ProblemFile> asked;
  if (!problem.is_none()) asked = problem_or_loaded(problem).file;
  std::optional<task::Verification> is;
  const auto signal = run_long([&](const Interrupted&) { is = task::verify_task(directory.string(), asked); });
  if (signal) throw nb::python_error(*signal);
  nb::list claims;
  for (const certificate::FalseClaim& claim : is->claims) {
    const bool verdict = claim.field == "verdict", yes_or_no = claim.field.ends_with(".positive");
    const auto told = [&](double value) -> nb::object {
      return yes_or_no && !std::isnan(value) ? nb::cast(value > 0.0) : number_or_none(value);
    };
    nb::dict one;
    one["field"] = claim.field;
    one["stored"] = verdict ? verdict_or_none(is->stored) : told(claim.stored);
    one["found"] = verdict ? verdict_or_none(is->found) : told(claim.found);
    one["contradiction"] = claim.contradiction.empty() ? nb::none() : nb::cast(claim.contradiction);
    claims.append(one);
  }
  nb::list differences;
  for (const std::string& difference : is->problem_differences) differences.append(difference);
  return nb::make_tuple(Trajectory(is->found), is->holds(), claims, is->trajectory_difference, differences);
}

}  // namespace

void bind_task(nb::module_& module) {
  module.def(
      "solve", &solve, "problem"_a, nb::kw_only(), "workers"_a = nb::none(), "solver"_a = nb::none(),
      "refinement"_a = nb::none(), "time_limit"_a = nb::none(), "first"_a = nb::none(), "progress"_a = nb::none(),
      "resolve"_a = false,
      nb::sig("def solve(problem: Problem | dict[str, typing.Any] | str | os.PathLike, *, workers: int | None = None, "
              "solver: "
              "typing.Literal['newton', 'ipopt', 'both'] | None = None, refinement: bool | None = None, time_limit: "
              "float | "
              "None = None, first: Trajectory | str | os.PathLike | None = None, progress: typing.Callable[[str], "
              "object] | None = None, resolve: bool = False) -> Solution"),
      "Finds the maneuver and proves it: what `lamprey solve` does. Releases the GIL.\n\n"
      "problem: a Problem, its settings as a dict, or the path of a problem file. workers: threads of the search "
      "(default: one for each core); "
      "without a time limit the answer does not depend on it.\n"
      "solver: \"newton\", \"ipopt\" or \"both\" from the same first guesses (default: newton where it takes the "
      "problem).\n"
      "refinement: solve on half and twice the steps too, for the certificate (default: where that is cheap).\n"
      "time_limit: s, wall clock, instead of the problem's. first: a motion of the same bodies and joints, or its "
      "directory: the first\nguess, in the place of a random one; its goal, limits, bodies' sizes and steps may have "
      "been "
      "others. progress: called with\nlines for people, from any thread; what it raises ends the search as Ctrl-C "
      "does. "
      "resolve: where the problem's steps do not "
      "resolve the answer, solve from it on "
      "again on more,\nuntil they do: the answer then has more steps than the problem.\n\n"
      "Not arriving is a status, no exception. Raises InputError for problems that cannot be solved. Ctrl-C raises\n"
      "KeyboardInterrupt once the search has stopped; its attribute `solution` then holds the best point so far, with "
      "status\n\"interrupted\": `except KeyboardInterrupt as stop: stop.solution`.");
  module.def(
      "simulate", &simulate, "problem"_a, "controls"_a = nb::none(), nb::kw_only(), "scheme"_a = nb::none(),
      "steps"_a = nb::none(), "duration"_a = nb::none(), "cycles"_a = 1, "adaptive"_a = false, "reference"_a = false,
      "feedback"_a = nb::none(), "perturb"_a = 0.0, "seed"_a = 1, "angles"_a = nb::none(), "feedback_from"_a = 0.0,
      "perturb_inertia"_a = 0.0,
      nb::sig(
          "def simulate(problem: Problem | dict[str, typing.Any] | str | os.PathLike, controls: Trajectory | str | "
          "os.PathLike | "
          "tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike] | typing.Callable[[float], "
          "numpy.typing.ArrayLike] | None = None, *, scheme: str | None = None, steps: int | None = None, "
          "duration: float | None = None, cycles: int = 1, adaptive: bool = False, reference: bool = False, feedback: "
          "Solution | str | os.PathLike | None = None, perturb: float = 0.0, seed: int = 1, "
          "angles: Trajectory | str | os.PathLike | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike] | "
          "typing.Callable[[float], numpy.typing.ArrayLike] | None = None, feedback_from: float = 0.0, "
          "perturb_inertia: float = 0.0) -> Trajectory"),
      "Marches from the problem's start, after a stored gait from where that begins: what `lamprey simulate` does. "
      "Releases the GIL.\n\n"
      "problem: a Problem, its settings as a dict, or the path of a problem file. controls: None (no moments), a "
      "Solution or Trajectory (its "
      "moments), a path (solution.json or CSV), a pair "
      "(time "
      "(rows,) s,\ncontrol (rows, joints, 3) N m; not-a-knot cubic between rows), or a function of time in s that "
      "returns "
      "(joints, 3) N m:\nmoments on the parents, parents' frames with the joints at zero angle; of hinges alone, fixed "
      "joints left out, (rows, "
      "joints) and (joints,) "
      "will do, about the parents' axes.\n"
      "scheme, steps, duration: instead of the problem's. cycles: how often the gait of controls or feedback, or "
      "the period of a table, is "
      "repeated; steps and duration are of all\ncycles together. adaptive: divide steps that do not converge.\n"
      "reference: by a Runge-Kutta method on the continuous equations. feedback: a Solution or its directory, followed "
      "by "
      "its\nmoments and gains; feedback_from: s of its time, at which the march begins, from the problem's start, "
      "without a duration for the rest of it. perturb: rad, by which each body is turned at the start about a random "
      "axis drawn by "
      "`seed`. perturb_inertia: share of itself by which each body's mass and inertia, fluid included, differ at most "
      "from the problem's, drawn by `seed`. In either case total momentum stays that of the start.\nangles: joint "
      "angles to "
      "march along, in the place of moments, which are "
      "then found: a Solution or "
      "Trajectory, a path (solution.json or CSV),\na pair (time (rows,) s, angles (rows, joints, 3) rad as "
      "Trajectory.joint_angle has them), or a function of time in s, asked at the nodes; of hinges alone, fixed joints "
      "left out,\n(rows, "
      "joints) and (joints,) will do. Joints with actuated = false whose angles are NaN in all rows, or left out of a "
      "CSV's header, and all such joints of a stored motion move as they do. Root and total momentum begin as the "
      "problem says, steps are as long as the problem's up to the last row; cycles repeats angles that close.\n\n"
      "A march that does not get on ends with status \"stalled\" and the nodes before. Ctrl-C raises "
      "KeyboardInterrupt; "
      "its attribute\n`solution` holds the nodes so far.");
  const char* about =
      "The same motion with its certificate made anew from its own numbers, and the status that this gives it. "
      "Releases the "
      "GIL; Ctrl-C waits for its end.";
  module.def("certify", &certify<Solution>, "solution"_a, about);
  module.def("certify", &certify<Trajectory>, "trajectory"_a, about);
  module.def(
      "_verify", &verify, "directory"_a, "problem"_a.none(),
      nb::sig("def _verify(directory: str | os.PathLike, problem: Problem | dict[str, typing.Any] | str | os.PathLike "
              "| None) -> "
              "tuple[Trajectory, bool, list[dict], str, list[str]]"),
      "The motion as certify gives it, whether all holds, claims that do not, and how trajectory.h5 and the problem "
      "differ.");
}

}  // namespace lamprey::python
