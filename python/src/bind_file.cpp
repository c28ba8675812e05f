// file: problems.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <filesystem>

#include "arrays.hpp"
#include "bound.hpp"
#include "document/text_file.hpp"
#include "file/words.hpp"
#include "module.hpp"
#include "task/tasks.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

constexpr std::size_t problem_bytes = std::size_t{16} << 20;

nb::list names_of(const auto& described) {
  nb::list names;
  for (const auto& entry : described) names.append(entry.name);
  return names;
}

nb::object settings_of(const Problem& problem) {
  return nb::module_::import_("lamprey._toml").attr("settings_of")(problem.text);
}

std::string shown(const Problem& problem) {
  const maneuver::Problem& p = problem.file.problem;
  return "<lamprey.Problem '" + p.name + "': " + std::to_string(p.swimmer.bodies.size()) + " bodies, " +
         std::to_string(p.steps) + " steps, scheme " + std::string(file::word(p.scheme)) + ">";
}

}  // namespace

Problem problem_from(const std::string& text, const std::string& path) {
  Problem problem{file::parse_problem(text, path), text};
  task::system_of(problem.file);  // says what the reader cannot see
  return problem;
}

Problem load(const std::filesystem::path& path) {
  return problem_from(document::read_bytes(path.string(), problem_bytes), path.string());
}

Problem problem_of_settings(const nb::dict& settings) {
  const nb::object text = nb::module_::import_("lamprey._toml").attr("text_of")(settings);
  return problem_from(nb::cast<std::string>(text), made_in_python);
}

Problem problem_or_loaded(nb::handle object) {
  if (nb::isinstance<Problem>(object)) return nb::cast<const Problem&>(object);
  if (nb::isinstance<nb::dict>(object)) return problem_of_settings(nb::cast<nb::dict>(object));
  std::filesystem::path path;
  if (!nb::try_cast(object, path))
    throw nb::type_error(
        fmt::format(
            "problem: found {}; allowed: a Problem, its settings as a dict, or the path of a problem file; give one",
            nb::cast<std::string>(nb::type_name(object.type())))
            .c_str());
  return load(path);
}

void bind_file(nb::module_& module) {
  nb::class_<Problem>(module, "Problem",
                      "A swimmer and what it shall do, validated: the numbers of a problem file.\n\n"
                      "Problem({...}) takes the sections and keys of a problem file as nested dicts: \"fluid\", "
                      "\"body\" and \"joint\" (lists "
                      "of dicts),\n\"start\", \"goal\", \"time\", ... NumPy arrays stand for lists. SI units, angles "
                      "in rad, rotations as "
                      "rotation vectors.\nRaises InputError naming the key.")
      .def(
          "__init__",
          [](Problem* self, const nb::dict& settings) { new (self) Problem(problem_of_settings(settings)); },
          "settings"_a)
      .def_static(
          "from_toml", [](const std::string& text, const std::string& path) { return problem_from(text, path); },
          "text"_a, "path"_a = made_in_python,
          "The problem of a file's text; `path` names it in messages. InputError naming the key where it is none.")
      .def(
          "changed",
          [](const Problem& self, const nb::kwargs& sections) {
            const nb::object text = nb::module_::import_("lamprey._toml").attr("changed")(self.text, sections);
            return problem_from(nb::cast<std::string>(text), made_in_python);
          },
          "sections"_a,
          "The problem with other keys: problem.changed(time={\"steps\": 100}, search={\"starts\": 1}).\n\n"
          "Dicts go key by key into what is there, anything else replaces it, None removes it.")
      .def_prop_ro(
          "text", [](const Problem& self) { return self.text; }, "The problem as TOML.")
      .def_prop_ro(
          "settings", [](const Problem& self) { return settings_of(self); },
          nb::sig("def settings(self) -> dict[str, object]"), "The problem as nested dicts, as Problem takes them.")
      .def_prop_ro(
          "name", [](const Problem& self) { return self.file.problem.name; }, "Its name.")
      .def_prop_ro(
          "bodies", [](const Problem& self) { return names_of(self.file.problem.swimmer.bodies); },
          nb::sig("def bodies(self) -> list[str]"), "Names of the bodies, the root first: the order of all arrays.")
      .def_prop_ro(
          "joints", [](const Problem& self) { return names_of(self.file.problem.swimmer.joints); },
          nb::sig("def joints(self) -> list[str]"), "Names of the joints: the order of all arrays.")
      .def_prop_ro(
          "steps", [](const Problem& self) { return self.file.problem.steps; },
          "Number of steps; arrays have one node more.")
      .def_prop_ro(
          "duration", [](const Problem& self) { return self.file.problem.duration.value; },
          "s; where it is free the first guess.")
      .def_prop_ro(
          "scheme", [](const Problem& self) { return std::string(file::word(self.file.problem.scheme)); },
          "paper, trapezoid, midpoint, order4 or order6.")
      .def(
          "check", [](const Problem& self) { return task::check_task(self.file); },
          "What `lamprey check` prints: the resolved model as a table for people, and where solve does not take the "
          "problem why.\n\nRaises InputError where the start or the goal breaks a limit.")
      .def("__repr__", &shown)
      .def(
          "__eq__",
          [](const Problem& self, const Problem& other) { return settings_of(self).equal(settings_of(other)); },
          nb::is_operator(), nb::sig("def __eq__(self, other: object, /) -> bool"),
          "Whether both have the same settings, wherever they were read.")
      .def("__hash__",
           [](const Problem& self) {
             return nb::hash(nb::module_::import_("lamprey._toml").attr("frozen")(settings_of(self)));
           })
      .def("__getstate__", [](const Problem& self) { return std::pair(self.text, self.file.path); })
      .def("__setstate__", [](Problem& self, const std::pair<std::string, std::string>& state) {
        new (&self) Problem(problem_from(state.first, state.second));
      });
  module.def("load", &load, "path"_a,
             "Reads and validates a problem file.\n\nRaises InputError (file:line:column: key: what was found, what is "
             "allowed, how "
             "to mend it), FileNotFoundError.");
}

}  // namespace lamprey::python
