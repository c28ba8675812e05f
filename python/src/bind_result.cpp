// result: motions and their files, in the words and shapes of solution.json.
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <filesystem>

#include "arrays.hpp"
#include "bound.hpp"
#include "file/words.hpp"
#include "module.hpp"
#include "python_words.hpp"
#include "report/joint_demands.hpp"
#include "report/report.hpp"
#include "report/shape_loop.hpp"
#include "result/result_shapes.hpp"
#include "result/solution_file.hpp"
#include "result/trajectory_file.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Demands = std::vector<report::JointDemand>;

// The results without what lies along the nodes, so that the rest is quick to read as JSON.
result::Results without_arrays(result::Results results) {
  maneuver::Solution& s = results.solution;
  s.time.clear();
  s.rotation.clear();
  s.control.clear();
  s.joint_angle.clear();
  s.angular_velocity.clear();
  s.stage_time.clear();
  s.control_stages.clear();
  s.feedback = {};
  for (auto* momentum : {&s.linear_momentum, &s.angular_momentum}) *momentum = {};
  for (auto* vectors : {&s.position, &s.linear_velocity}) vectors->clear();
  return results;
}

nb::dict velocity(const Trajectory& self) {
  nb::dict words;
  for (const char* key : {"linear", "angular"}) words[key] = self.array(std::string("velocity/") + key);
  return words;
}

nb::dict momentum(const Trajectory& self) {
  nb::dict words;
  for (const char* kind : {"linear", "angular"}) {
    nb::dict parts;
    for (const char* part : {"bodies", "fluid", "total"})
      parts[part] = self.array(std::string("momentum/") + kind + "/" + part);
    words[kind] = parts;
  }
  return words;
}

nb::object feedback(const Trajectory& self) {
  if (self.results().solution.feedback.gain.empty()) return nb::none();
  nb::list controls, states;
  for (const result::ControlCoordinate& of : result::control_coordinates(self.results().problem)) {
    nb::dict coordinate;
    coordinate["joint"] = of.joint;
    coordinate["axis"] = of.axis;
    controls.append(coordinate);
  }
  for (const result::StateCoordinate& of : result::state_coordinates(self.results().problem)) {
    nb::dict coordinate;
    coordinate["quantity"] = of.quantity;
    coordinate["of"] = of.of;
    coordinate["axis"] = of.axis;
    coordinate["unit"] = of.unit;
    states.append(coordinate);
  }
  nb::dict words;
  words["time"] = self.array("feedback/time");
  words["gain"] = self.array("feedback/gain");
  words["control_coordinates"] = controls;
  words["state_coordinates"] = states;
  return words;
}

void save(const Trajectory& self, const std::filesystem::path& directory) {
  const nb::gil_scoped_release unlocked;
  report::write_results(directory.string(), self.results());
}

void write_report(const Trajectory& self, const std::filesystem::path& path) {
  const nb::gil_scoped_release unlocked;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  document::write_files(folder.string(),
                        {document::finished_file(path.filename().string(), report::report_html(self.results()))});
}

nb::object shape_loop(const Trajectory& self) {
  const std::optional<report::ShapeLoop> loop = report::shape_loop(self.results());
  if (!loop) return nb::none();
  nb::dict result;
  result["variables"] = nb::make_tuple(loop->variable[0], loop->variable[1]);
  for (const auto& [key, n] : {std::pair("first", std::size_t{0}), std::pair("second", std::size_t{1})})
    result[key] = array(loop->run[n], {loop->run[n].size()});
  result["heights"] = dict_of(loop->heights);
  const auto planar = [](const mechanics::Planar& of) { return array(Eigen::Vector3d(of)); };
  result["by_volume"] = loop->displacement ? planar(loop->displacement->by_volume) : nb::none();
  result["moved"] = loop->displacement ? planar(loop->displacement->moved) : nb::none();
  nb::dict modes;
  if (loop->modes)
    for (std::size_t a = 0; a < loop->modes->angle.size(); ++a) {
      const auto row = loop->modes->direction.row(static_cast<Eigen::Index>(a));
      modes[loop->modes->angle[a].c_str()] = nb::make_tuple(row[0], row[1]);
    }
  result["modes"] = loop->modes ? nb::object(modes) : nb::none();
  result["beside"] = loop->modes ? loop->modes->beside : 0.0;
  return result;
}

nb::list joint_demands(const Trajectory& self) {
  nb::list all;
  for (const report::JointDemand& demand : report::joint_demands(self.results()).value_or(Demands())) {
    nb::list angles;
    for (const auto& [least, largest] : demand.angles) angles.append(nb::make_tuple(least, largest));
    nb::dict words;
    words["joint"] = demand.joint;
    words["largest_moment"] = demand.largest_moment;
    words["largest_rate"] = demand.largest_rate;
    words["largest_power"] = demand.largest_power;
    words["work"] = demand.work;
    words["angles"] = angles;
    all.append(words);
  }
  return all;
}

nb::object load_solution(const std::filesystem::path& directory) {
  result::Results results;
  {
    const nb::gil_scoped_release unlocked;
    results = result::read_solution(directory.string());
  }
  if (results.marched()) return nb::cast(Trajectory(std::move(results)));
  return nb::cast(Solution(std::move(results)));
}

std::string shown(const char* type, const Trajectory& self) {
  const result::Results& results = self.results();
  std::string text = std::string("<lamprey.") + type + " '" + results.name +
                     "': " + std::string(file::word(results.solution.status)) + ", " +
                     std::to_string(results.solution.time.size()) + " nodes";
  if (std::isfinite(results.solution.cost)) text += ", cost " + std::to_string(results.solution.cost);
  return text + ">";
}

// For pickle: the text of solution.json, as bytes, since it holds all that a motion is.
template <class Motion>
nb::bytes state(const Motion& self) {
  const std::string text = result::solution_text(self.results());
  return nb::bytes(text.data(), text.size());
}

template <class Motion>
void from_state(Motion& self, const nb::bytes& text) {
  new (&self) Motion(result::parse_solution({text.c_str(), text.size()}, "pickle"));
}

}  // namespace

nb::object Trajectory::array(const std::string& path) const {
  if (arrays_.empty()) {  // making them may let other threads in
    std::map<std::string, nb::object> arrays;
    for (result::ShapedArray& made : result::shaped_arrays(*results_))
      arrays[made.path()] = python::array(std::move(made.values), made.shape);
    arrays_ = std::move(arrays);
  }
  const auto found = arrays_.find(path);
  return found == arrays_.end() ? nb::none() : found->second;
}

nb::object Trajectory::entry(const std::string& key) const {
  if (!document_) {
    const std::string text = result::solution_text(without_arrays(*results_));
    document_ = nb::module_::import_("json").attr("loads")(text);
  }
  return nb::module_::import_("copy").attr("deepcopy")(document_.attr("get")(key));  // the caller's own
}

#define LAMPREY_ARRAY(name) "def " name "(self) -> numpy.typing.NDArray[numpy.float64]"

void bind_result(nb::module_& module) {
  const auto at = [](const char* path) { return [path](const Trajectory& self) { return self.array(path); }; };
  const auto said = [](const char* key) { return [key](const Trajectory& self) { return self.entry(key); }; };
  nb::class_<Trajectory>(
      module, "Trajectory",
      "A motion, in the words, shapes and units of solution.json. Arrays are NumPy float64, read-only, C order.\n\n"
      "nodes = steps + 1; bodies and joints in the order of Problem.bodies and Problem.joints.")
      .def_prop_ro(
          "name", [](const Trajectory& self) { return self.results().name; }, "Of its problem.")
      .def_prop_ro(
          "source", [](const Trajectory& self) { return self.results().source; }, "Of its problem.")
      .def_prop_ro(
          "status", [](const Trajectory& self) { return std::string(file::word(self.results().solution.status)); },
          "optimal, simulated, feasible, infeasible, stalled, time_limit or interrupted.")
      .def_prop_ro(
          "message", [](const Trajectory& self) { return in_python_words(self.results().solution.message); },
          "One sentence for a person: what happened and, if not optimal, why and what to try; arguments of solve and "
          "simulate\nin the place of the command line's options, which solution.json has.")
      .def_prop_ro("problem", said("problem"), nb::sig("def problem(self) -> dict[str, typing.Any]"),
                   "The problem as resolved: bodies, joints (indices), scheme, time_step, duration, steps, cost_rule, "
                   "goal, ...")
      .def_prop_ro(
          "duration", [](const Trajectory& self) { return self.results().problem.duration; },
          "s; of a free duration the one found.")
      .def_prop_ro("time", at("time"), nb::sig(LAMPREY_ARRAY("time")), "(nodes,) s.")
      .def_prop_ro("position", at("position"), nb::sig(LAMPREY_ARRAY("position")),
                   "(nodes, 3) m, mass centre of the root, world frame.")
      .def_prop_ro("rotation", at("rotation"), nb::sig(LAMPREY_ARRAY("rotation")),
                   "(nodes, bodies, 3, 3) rotation matrices, body → world.")
      .def_prop_ro("control", at("control"), nb::sig(LAMPREY_ARRAY("control")),
                   "(nodes, joints, 3) N m, moment on the parent, parent's frame; its opposite acts on the child.")
      .def_prop_ro(
          "joint_angle", at("joint_angle"),
          nb::sig("def joint_angle(self) -> numpy.typing.NDArray[numpy.float64] | None"),
          "(nodes, joints, 3) rad from the zero angle: (θ, 0, 0) of a hinge, (θ₁, θ₂, 0) of a universal joint, "
          "rotation vector of a\nball joint, parent's frame. Whole turns add up. None: of files of early versions.")
      .def_prop_ro("control_stages", at("control_stages"),
                   nb::sig("def control_stages(self) -> numpy.typing.NDArray[numpy.float64] | None"),
                   "(steps, stages, joints, 3) N m, of schemes above order 2; None of others.")
      .def_prop_ro("stage_time", at("stage_time"),
                   nb::sig("def stage_time(self) -> numpy.typing.NDArray[numpy.float64] | None"),
                   "(steps, stages) s, of schemes above order 2; None of others.")
      .def_prop_ro("velocity", &velocity,
                   nb::sig("def velocity(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]"),
                   "{linear: (nodes, 3) m/s of the root, root frame; angular: (nodes, bodies, 3) rad/s, body frames}.")
      .def_prop_ro(
          "momentum", &momentum,
          nb::sig("def momentum(self) -> dict[str, dict[str, numpy.typing.NDArray[numpy.float64]]]"),
          "{linear, angular}, each {bodies, fluid, total}: (nodes, 3) kg m/s and kg m²/s, world frame, angular "
          "about the world origin.")
      .def_prop_ro(
          "certificate", said("certificate"), nb::sig("def certificate(self) -> dict[str, typing.Any] | None"),
          "The numbers that prove the answer: goal_error, rest_error, momentum_drift, rotation_drift, kkt, "
          "second_order, replay, refinement, ...\nNone: not computed, as of motions that were marched; see certify.")
      .def_prop_ro("tracking", said("tracking"), nb::sig("def tracking(self) -> dict[str, typing.Any] | None"),
                   "How a march with feedback kept to its maneuver; None of others.")
      .def_prop_ro("marched_by", said("marched_by"), nb::sig("def marched_by(self) -> str | None"),
                   "What marched in place of the scheme; None: the scheme.")
      .def_prop_ro("divided_steps", said("divided_steps"),
                   nb::sig("def divided_steps(self) -> dict[str, typing.Any] | None"),
                   "Where a march divided its steps; None where it did not.")
      .def_prop_ro("provenance", said("provenance"), nb::sig("def provenance(self) -> dict[str, typing.Any]"),
                   "version, build_type, compiler, machine, command, problem_sha256, seed.")
      .def("shape_loop", &shape_loop, nb::sig("def shape_loop(self) -> dict[str, typing.Any] | None"),
           "The loop of shapes of a motion in a plane over its height functions, as the report shows it; else None.\n\n"
           "\"variables\": the two angles that change, or \"s₁\", \"s₂\" of more: coordinates in the plane nearest to "
           "all "
           "shapes, \"modes\" how far each angle turns by them, \"beside\" how far shapes are from it, rad. \"first\", "
           "\"second\" (nodes): the variables along the motion. \"heights\": as of Problem.height_functions. Of a loop "
           "that "
           "closes without total momentum \"by_volume\" and \"moved\" (along, across, turn; m, m, rad): the volumes "
           "over it, "
           "and the twist that takes the frame of the heights once round, on the average over where the loop begins; "
           "else "
           "None.")
      .def("joint_demands", &joint_demands, nb::sig("def joint_demands(self) -> list[dict[str, typing.Any]]"),
           "What the motion asks of each joint, of a universal joint with two moments of each axis: joint (its name, "
           "\"fin 1\" and \"fin 2\" of axes), largest_moment N m, largest_rate rad/s (at nodes, or mean over a step), "
           "largest_power W (at nodes), "
           "work J\n(∫ |u·ω| dt, nothing won back), angles (list of (least, largest) rad: of a hinge or an axis one, "
           "of a universal joint with fewer moments two, of a\nball joint how far it is from its zero angle, over "
           "the nodes); an empty list: no motion.")
      .def("report", &write_report, "path"_a,
           "Writes the report, one HTML file that opens without a server or a network. OSError where it cannot be "
           "written.")
      .def("save", &save, "directory"_a,
           "Writes solution.json, trajectory.h5 and report.html into a directory, as `lamprey solve --out` does; of "
           "other "
           "minima, too, each in a directory minimum_2, minimum_3 ... within it. OSError where they cannot be written.")
      .def("__repr__", [](const Trajectory& self) { return shown("Trajectory", self); })
      .def("__getstate__", &state<Trajectory>)
      .def("__setstate__", &from_state<Trajectory>);
  nb::class_<Solution, Trajectory>(module, "Solution",
                                   "A motion that was sought, with its certificate. Whether it arrived is its status, "
                                   "never an exception.")
      .def_prop_ro(
          "cost", [](const Solution& self) { return self.results().solution.cost; },
          "By the problem's rule; of effort alone in (N m)² s.")
      .def_prop_ro("cost_parts", said("cost_parts"), nb::sig("def cost_parts(self) -> dict[str, float] | None"),
                   "effort, work, power, smoothness, angular_velocity, time, transport before weighting, where more "
                   "than effort and time is asked for.")
      .def_prop_ro("search", said("search"), nb::sig("def search(self) -> dict[str, typing.Any] | None"),
                   "starts, solved, minima [{cost, count, by_ipopt where both solvers searched}]; where there are "
                   "such, strokes and "
                   "hops (first guesses among them) and set_aside {cost, steps}.")
      .def_prop_ro(
          "others",
          [](const Solution& self) {
            nb::list all;
            for (const result::Results& other : self.results().others) all.append(nb::cast(Solution(other)));
            return all;
          },
          nb::sig("def others(self) -> list[Solution]"),
          "Of other minima, by rising cost, where search.keep of the problem is more than 1; not kept by pickle and "
          "load_solution.")
      .def_prop_ro(
          "solver", said("solver"), nb::sig("def solver(self) -> dict[str, typing.Any] | None"),
          "name, iterations, evaluations, wall_seconds (of the search), processor_seconds (of all workers), "
          "total_wall_seconds (of the whole answer), history; limit_weight, (N m)², and work_weight, 1/W, {value, "
          "largest}, where there are such multipliers.")
      .def_prop_ro("feedback", &feedback, nb::sig("def feedback(self) -> dict[str, typing.Any] | None"),
                   "Gains about the motion: time (times,), gain (times, controls, states), control_coordinates, "
                   "state_coordinates.")
      .def_prop_ro(
          "limit_multipliers", said("limit_multipliers"),
          nb::sig("def limit_multipliers(self) -> list[dict[str, typing.Any]] | None"),
          "What the limits that hold somewhere cost: a dict for each with key (of the problem file), joint, bodies, "
          "component "
          "and upper (which of its bounds), and multiplier (nodes,): (N m)² by N m, rad, rad/s, m or s, by how "
          "much the cost falls for each unit by which the limit gives way, per second.")
      .def_prop_ro("work_multipliers", said("work_multipliers"),
                   nb::sig("def work_multipliers(self) -> list[list[float]] | None"),
                   "[drives][nodes] signs of the powers, where work has a weight: a row for each joint, of a universal "
                   "joint with "
                   "two moments one for each axis.")
      .def_prop_ro("work_change_multipliers", said("work_change_multipliers"),
                   nb::sig("def work_change_multipliers(self) -> list[list[float]] | None"),
                   "[drives][nodes] slopes of the work by the powers' changes over the nodes, where work has a weight.")
      .def("__repr__", [](const Solution& self) { return shown("Solution", self); })
      .def("__getstate__", &state<Solution>)
      .def("__setstate__", &from_state<Solution>);
  module.def(
      "load_solution", &load_solution, "directory"_a,
      nb::sig("def load_solution(directory: str | os.PathLike) -> Trajectory"),
      "Reads solution.json of a directory: a Solution, or a Trajectory where it was simulated. FileNotFoundError where "
      "there is none, another OSError where it is not what Lamprey writes.");
}

#undef LAMPREY_ARRAY

}  // namespace lamprey::python
