// mechanics: how shapes move the whole, as methods of Problem.
#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>

#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "arrays.hpp"
#include "bound.hpp"
#include "maneuver/maneuver.hpp"
#include "mechanics/connection.hpp"
#include "mechanics/height_functions.hpp"
#include "model/input_error.hpp"
#include "module.hpp"
#include "task/tasks.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using model::InputError;
using model::System;

// The joints' rates that the columns are by, as [joint, axis].
nb::list rates_of(const System& system) {
  nb::list rates;
  for (const model::Joint& joint : system.joints())
    for (int axis = 0; axis < system.body(joint.child).freedoms; ++axis) rates.append(nb::make_tuple(joint.name, axis));
  return rates;
}

nb::object matrix(const Eigen::MatrixXd& numbers) {
  const Eigen::MatrixXd rows = numbers.transpose();
  return array({rows.data(), rows.data() + rows.size()},
               {static_cast<std::size_t>(numbers.rows()), static_cast<std::size_t>(numbers.cols())});
}

// `count` matrices of one size, one after the other.
nb::object matrices(const Eigen::MatrixXd* first, std::size_t count) {
  std::vector<double> values;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::MatrixXd rows = first[k].transpose();
    values.insert(values.end(), rows.data(), rows.data() + rows.size());
  }
  return array(std::move(values),
               {count, static_cast<std::size_t>(first->rows()), static_cast<std::size_t>(first->cols())});
}

mechanics::Rotations shape_of(const System& system, nb::handle rotation) {
  constexpr double written = 1e-6;  // rad, of numbers with some digits
  return maneuver::fitted_to_joints(system,
                                    rotations(rotation, static_cast<std::size_t>(system.body_count()), "rotation"),
                                    written, "rotation of ", "");
}

nb::dict connection(const Problem& problem, nb::handle rotation) {
  const System system = task::system_of(problem.file);
  const mechanics::LocalConnection found = mechanics::local_connection(system, shape_of(system, rotation));
  nb::dict result;
  result["rates"] = rates_of(system);
  result["angular"] = matrix(found.turn);
  result["linear"] = matrix(found.shift);
  result["inertia"] = matrix(found.inertia);
  return result;
}

nb::dict connection_curvature(const Problem& problem, nb::handle rotation) {
  const System system = task::system_of(problem.file);
  const mechanics::ConnectionCurvature found = mechanics::connection_curvature(system, shape_of(system, rotation));
  nb::dict result;
  result["rates"] = rates_of(system);
  result["angular"] = matrices(found.turn.data(), 3);
  result["linear"] = matrices(found.shift.data(), 3);
  return result;
}

// An angle by its joint's name, or by that and the axis.
struct Angle {
  std::size_t joint;
  Eigen::Index axis;
};

Angle angle_named(const System& system, nb::handle name, const std::string& key) {
  std::string joint_name;
  std::pair<std::string, int> with_axis;
  const bool has_axis = nb::try_cast(name, with_axis);
  if (has_axis)
    joint_name = with_axis.first;
  else if (!nb::try_cast(name, joint_name))
    throw InputError(key, fmt::format("found {}; allowed: a joint's name, (name, axis), or a dict of these; give one",
                                      nb::cast<std::string>(nb::type_name(name.type()))));
  for (int j = 0; j < system.joint_count(); ++j) {
    if (system.joint(j).name != joint_name) continue;
    const int count = system.body(system.joint(j).child).freedoms;
    if (count == 0)
      throw InputError(
          key, fmt::format("found joint \"{}\", which is fixed; allowed: one that turns; name another", joint_name));
    if (!has_axis && count == 1) return {static_cast<std::size_t>(j), 0};
    if (has_axis && with_axis.second >= 0 && with_axis.second < count)
      return {static_cast<std::size_t>(j), with_axis.second};
    throw InputError(key, fmt::format("found {} of joint \"{}\"; allowed: an axis from 0 to {}; give (\"{}\", axis)",
                                      has_axis ? "axis " + std::to_string(with_axis.second) : std::string("no axis"),
                                      joint_name, count - 1, joint_name));
  }
  std::string names;
  for (const model::Joint& joint : system.joints()) names += (names.empty() ? "" : ", ") + joint.name;
  throw InputError(key, fmt::format("found joint \"{}\"; allowed: {}; name one of these", joint_name, names));
}

// [joints][3] of one angle, or of a dict of angles and numbers.
mechanics::Vectors turns_of(const System& system, nb::handle given, const std::string& key) {
  mechanics::Vectors turns(static_cast<std::size_t>(system.joint_count()), Eigen::Vector3d::Zero());
  const auto entry = [&](nb::handle name) -> double& {
    const Angle angle = angle_named(system, name, key);
    return turns[angle.joint][angle.axis];
  };
  if (!nb::isinstance<nb::dict>(given)) {
    entry(given) = 1.0;
    return turns;
  }
  for (const auto& [name, number] : nb::borrow<nb::dict>(given)) {
    double value = 0.0;
    if (!nb::try_cast(number, value) || !std::isfinite(value))
      throw InputError(key, fmt::format("found {}; allowed: a finite number for each angle; give one",
                                        nb::cast<std::string>(nb::str(number))));
    entry(name) = value;
  }
  return turns;
}

void require_apart(const mechanics::Vectors& first, const mechanics::Vectors& second) {
  constexpr double parallel = 1e-9;
  double square = 0.0, other = 0.0, product = 0.0;
  for (std::size_t j = 0; j < first.size(); ++j) {
    square += first[j].squaredNorm();
    other += second[j].squaredNorm();
    product += first[j].dot(second[j]);
  }
  for (const auto& [key, size] : {std::pair("first", square), std::pair("second", other)})
    if (size == 0.0) throw InputError(key, "found no angle that changes; allowed: one at least; name it");
  if (square * other - product * product <= parallel * square * other)
    throw InputError("second", "found the first variable again; allowed: another one; name another angle");
}

nb::dict height_functions(const Problem& problem, nb::handle first, nb::handle second,
                          const std::pair<double, double>& first_range, const std::pair<double, double>& second_range,
                          int points, nb::handle middle) {
  const System system = task::system_of(problem.file);
  mechanics::ShapePlane plane;
  if (!middle.is_none() && !nb::isinstance<nb::dict>(middle))
    throw InputError("middle", fmt::format("found {}; allowed: a dict of angles in rad; give {{\"joint\": angle}}",
                                           nb::cast<std::string>(nb::type_name(middle.type()))));
  plane.middle = turns_of(system, middle.is_none() ? nb::dict() : nb::borrow<nb::dict>(middle), "middle");
  plane.direction = {turns_of(system, first, "first"), turns_of(system, second, "second")};
  require_apart(plane.direction[0], plane.direction[1]);
  for (const auto& [range, key, n] : {std::tuple(first_range, "first_range", std::size_t{0}),
                                      std::tuple(second_range, "second_range", std::size_t{1})}) {
    constexpr double least_width = 1e-3, farthest = 1e3;
    if (!(range.second - range.first >= least_width) || !(std::abs(range.first) <= farthest) ||
        !(std::abs(range.second) <= farthest))
      throw InputError(key,
                       fmt::format("found ({}, {}); allowed: a lower and a higher value in rad, {} apart at least and "
                                   "{} at most; set them",
                                   range.first, range.second, least_width, farthest));
    plane.low[n] = range.first;
    plane.high[n] = range.second;
  }
  constexpr int least_points = 4, most_points = 200;
  if (points < least_points || points > most_points)
    throw InputError("points", fmt::format("found {}; allowed: {} to {} along each variable; choose some", points,
                                           least_points, most_points));
  plane.points = points;
  std::optional<mechanics::HeightFunctions> found;
  {
    const nb::gil_scoped_release others_run;
    found = mechanics::height_functions(system, plane);
  }
  if (!found)
    throw InputError("first, second",
                     "found a swimmer that moves otherwise than in one plane of its root's axes, or a ball joint that "
                     "turns about several; allowed: angles about one of the root's axes, of bodies that are symmetric "
                     "about the plane; use connection_curvature at single shapes");
  return dict_of(*found);
}

}  // namespace

nb::dict dict_of(const mechanics::HeightFunctions& heights) {
  nb::dict result;
  const auto along = [](const std::vector<double>& values) { return array(values, {values.size()}); };
  result["first"] = along(heights.at[0]);
  result["second"] = along(heights.at[1]);
  result["normal"] = heights.normal;
  result["linear"] = matrices(heights.height.data(), 2);
  result["angular"] = matrix(heights.height[2]);
  result["frame_position"] = matrices(heights.frame.data(), 2);
  result["frame_angle"] = matrix(heights.frame[2]);
  return result;
}

void bind_mechanics(nb::module_& module) {
  auto problem = nb::borrow<nb::class_<Problem>>(module.attr("Problem"));
  problem
      .def("connection", &connection, "rotation"_a,
           nb::sig("def connection(self, rotation: numpy.typing.ArrayLike) -> dict[str, typing.Any]"),
           "The local connection at a shape: how the root moves as the joints turn, where total momentum is zero.\n\n"
           "rotation: (bodies, 3, 3), body to world, of which the shape alone counts; InputError where a body is off "
           "its joint by more than "
           "1e-6 rad. Returns \"angular\" (3, f) and "
           "\"linear\" "
           "(3, f, in m): the root's angular velocity and its mass centre's velocity, both along its own axes, by the "
           "f rates "
           "of the joints, and \"inertia\" (f, f): M of the kinetic energy ½ rate·M rate, kg m².\n\"rates\": the joint "
           "and the "
           "axis of each, of a hinge or universal joint the angle about it, of a ball joint a component of the child's "
           "angular "
           "velocity against the parent's, in the parent's frame. Equation 9.28.")
      .def("connection_curvature", &connection_curvature, "rotation"_a,
           nb::sig("def connection_curvature(self, rotation: numpy.typing.ArrayLike) -> dict[str, typing.Any]"),
           "The curvature of the local connection at a shape: what small loops of shapes move the root by.\n\n"
           "rotation: (bodies, 3, 3), body to world, of which the shape alone counts; InputError as in connection. "
           "Returns \"angular\" (3, f, f) and "
           "\"linear\" (3, f, f, in m), by the f \"rates\" of connection: the parallelogram of two small motions a, b "
           "of "
           "the joints (rad) turns the root by angular[k] @ b · a about its axis k and moves it by linear[k] likewise, "
           "to "
           "second order in its size. Antisymmetric, exact. Equations 9.29, 9.30.")
      .def(
          "height_functions", &height_functions, "first"_a, "second"_a, "first_range"_a, "second_range"_a,
          "points"_a = 31, "middle"_a = nb::none(),
          nb::sig(
              "def height_functions(self, first: str | tuple[str, int] | dict, second: str | tuple[str, int] | dict, "
              "first_range: tuple[float, float], second_range: tuple[float, float], points: int = 31, middle: dict | "
              "None = None) -> dict[str, typing.Any]"),
          "Height functions of a swimmer that two shape variables move in a plane: volumes over loops are what it "
          "moves.\n\n"
          "first, second: what the variables change, a joint's name, of a ball or universal joint with its axis, "
          "(\"front\", 2); or a mode, a dict of angles and how far each turns for 1 of the variable, {\"front\": 1.0, "
          "\"back\": "
          "-0.5}. middle: angles where both variables are zero, rad, from which they count; those that are not named "
          "are zero. Ranges in rad. "
          "Returns \"first\", \"second\" (points): the variables; \"linear\" (2, points, points, m) and \"angular\" "
          "(points, points, rad), each for 1 of both variables, rows by the first: along the two axes that follow "
          "\"normal\", the root's axis about which it turns (0, 1 or 2), and about it; told in the frame that shapes "
          "disturb least, which stands at \"frame_position\" (2, points, points, m) and is turned by \"frame_angle\" "
          "(points, points, rad) in the root's.\nRaises InputError where the swimmer leaves the plane. Equation 9.31.");
}

}  // namespace lamprey::python
