#include "march_input.hpp"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "arrays.hpp"
#include "bound.hpp"
#include "model/input_error.hpp"
#include "result/joint_table_header.hpp"

namespace lamprey::python {

namespace nb = nanobind;
using model::InputError;

namespace {

// Rows of a table over joints: time (rows,), values (rows, joints, 3).
struct Rows {
  std::vector<double> time;
  std::vector<std::vector<Eigen::Vector3d>> value;
  std::vector<bool> missing;  // [joints] whose values are NaN in all rows, where they may be; zero in `value`
};

// What one number for each hinge is about, where it will do: [joints], zero of fixed ones, which have no number; else empty.
using Axes = std::vector<Eigen::Vector3d>;

std::size_t hinges_of(const Axes& axes) {
  return static_cast<std::size_t>(
      std::count_if(axes.begin(), axes.end(), [](const Eigen::Vector3d& axis) { return !axis.isZero(0.0); }));
}

// Where all joints that move are hinges.
Axes hinge_axes(const result::Joints& joints,
                const std::function<Eigen::Vector3d(const model::JointDescription&)>& axis) {
  Axes axes;
  for (const model::JointDescription& joint : joints) {
    const bool fixed = joint.kind == model::JointKind::fixed;
    if (!fixed && joint.kind != model::JointKind::hinge) return {};
    axes.push_back(fixed ? Eigen::Vector3d::Zero() : axis(joint));
  }
  return hinges_of(axes) > 0 ? axes : Axes();
}

// Of one row, [joints][3]; where there are `axes`, one number for each hinge.
std::vector<Eigen::Vector3d> row_of(const double* from, std::size_t count, const Axes& axes) {
  std::vector<Eigen::Vector3d> row;
  for (std::size_t j = 0; j < count; ++j)
    if (axes.empty())
      row.emplace_back(Eigen::Map<const Eigen::Vector3d>(from + 3 * j));
    else
      row.emplace_back(axes[j].isZero(0.0) ? axes[j] : Eigen::Vector3d(*from++ * axes[j]));
  return row;
}

// Of a function at a time, asked under the GIL.
std::vector<Eigen::Vector3d> row_at(const nb::object& function, double time, std::size_t count, const Axes& axes,
                                    const char* word) {
  const std::string key = fmt::format("{}({})", word, time);
  const nb::object given = function(time);
  const Numbers each = numbers(given, key);
  if (axes.empty() || each.ndim() != 1) return vectors(given, count, key);
  require_shape(each, {hinges_of(axes)}, key);
  return row_of(each.data(), count, axes);
}

// Where a joint may be left out, and is so in every row.
std::vector<bool> missing_of(const Rows& table, const std::vector<bool>& may_miss) {
  std::vector<bool> missing = may_miss;
  for (const auto& row : table.value)
    for (std::size_t j = 0; j < missing.size(); ++j) missing[j] = missing[j] && row[j].hasNaN();
  return missing;
}

Rows rows_of(const nb::object& pair, std::size_t count, const Axes& axes, const std::string& key,
             const std::string& name, const std::vector<bool>& may_miss) {
  const Numbers time = numbers(pair[0], key + "[0]"), values = numbers(pair[1], key + "[1]");
  const std::size_t rows = time.ndim() == 1 ? time.shape(0) : 0;
  const bool single = !axes.empty() && values.ndim() == 2;
  const std::size_t columns = single ? hinges_of(axes) : count;
  if (rows < 2 || values.ndim() != (single ? 2U : 3U) || values.shape(0) != rows || values.shape(1) != columns ||
      (!single && values.shape(2) != 3))
    throw InputError(key,
                     fmt::format("found arrays of other shapes; allowed: time (rows,), {} (rows, {}, 3){}, "
                                 "at least two rows; mend their shapes",
                                 name, count, !axes.empty() ? fmt::format(" or (rows, {})", hinges_of(axes)) : ""));
  Rows table;
  for (std::size_t r = 0; r < rows; ++r) {
    table.time.push_back(time.data()[r]);
    if (!std::isfinite(table.time[r]) || (r > 0 && !(table.time[r] > table.time[r - 1])))
      throw InputError(
          key, fmt::format("found time[{}] = {}; allowed: times that rise (s); sort the rows", r, table.time[r]));
    table.value.push_back(row_of(values.data() + r * columns * (single ? 1 : 3), count, single ? axes : Axes()));
  }
  table.missing = missing_of(table, may_miss);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t j = 0; j < count; ++j) {
      if (table.missing[j]) table.value[r][j].setZero();
      if (!table.value[r][j].allFinite())
        throw InputError(key, fmt::format("found {} that is not finite in row {}; mend it", name, r));
    }
  return table;
}

bool is_path(const nb::object& object) { return nb::isinstance<nb::str>(object) || nb::hasattr(object, "__fspath__"); }

void warn_of(const std::string& remark) {
  if (!remark.empty() && PyErr_WarnEx(PyExc_UserWarning, remark.c_str(), 1) < 0) throw nb::python_error();
}

[[noreturn]] void refuse_type(const nb::object& found, const std::string& key, const std::string& name) {
  throw InputError(key, fmt::format("found {}; allowed: a pair (time, {}) of arrays, a function of time, a solution "
                                    "or trajectory, or a file's path; give one of these",
                                    nb::cast<std::string>(nb::type_name(found.type())), name));
}

// Asked under the GIL; must be outlived by the object.
std::function<std::vector<Eigen::Vector3d>(double)> asked_of(const nb::object& function, std::size_t count,
                                                             const Axes& axes, const char* word) {
  return [&function, count, axes, word](double time) {
    const nb::gil_scoped_acquire lock;
    return row_at(function, time, count, axes, word);
  };
}

}  // namespace

void take_controls(const nb::object& controls, const result::Joints& joints, task::MarchOptions& options) {
  const std::size_t count = joints.size();
  const Axes axes = hinge_axes(joints, result::moment_axis);
  if (controls.is_none()) return;
  if (nb::isinstance<Trajectory>(controls)) {
    options.controls = result::controls_of_results(nb::cast<const Trajectory&>(controls).results(), "controls", joints);
  } else if (nb::isinstance<nb::callable>(controls)) {
    options.control = asked_of(controls, count, axes, "controls");
  } else if (nb::isinstance<nb::tuple>(controls) && nb::len(controls) == 2) {
    Rows rows = rows_of(controls, count, axes, "controls", "moments", std::vector<bool>(count, false));
    result::ControlSamples samples;
    samples.time = std::move(rows.time);
    samples.control = std::move(rows.value);
    options.controls = samples;
  } else if (is_path(controls)) {
    options.controls_path = nb::cast<std::filesystem::path>(controls).string();
    options.controls = result::read_controls(options.controls_path, joints);
    warn_of(options.controls->remark);
  } else {
    refuse_type(controls, "controls", "moments");
  }
}

void take_angles(const nb::object& angles, const result::Joints& joints, task::MarchOptions& options) {
  const std::size_t count = joints.size();
  const Axes axes =
      hinge_axes(joints, [](const model::JointDescription&) -> Eigen::Vector3d { return Eigen::Vector3d::UnitX(); });
  if (angles.is_none()) return;
  if (nb::isinstance<Trajectory>(angles)) {
    options.angles = result::angles_of_results(nb::cast<const Trajectory&>(angles).results(), "angles", joints);
  } else if (nb::isinstance<nb::callable>(angles)) {
    options.angle = asked_of(angles, count, axes, "angles");
  } else if (nb::isinstance<nb::tuple>(angles) && nb::len(angles) == 2) {
    std::vector<bool> idle;
    for (const auto& joint : joints) idle.push_back(joint.passive());
    Rows rows = rows_of(angles, count, axes, "angles", "angles", idle);
    options.angles = result::AngleSamples{
        .time = std::move(rows.time), .angle = std::move(rows.value), .passive = std::move(rows.missing)};
  } else if (is_path(angles)) {
    options.angles_path = nb::cast<std::filesystem::path>(angles).string();
    options.angles = result::read_angles(options.angles_path, joints);
    warn_of(options.angles->remark);
  } else {
    refuse_type(angles, "angles", "angles");
  }
}

}  // namespace lamprey::python
