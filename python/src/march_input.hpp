// What Python gives a march to go by: moments or joint angles.
#pragma once

#include <nanobind/nanobind.h>

#include "result/controls_file.hpp"
#include "task/tasks.hpp"

namespace lamprey::python {

/// A file, a motion, a pair (time, rows) of arrays, or a function of time, which has to outlive the options; None leaves them as they are.
/// Where all joints that move are hinges one number for each is enough, along its axis. Throws model::InputError for anything else.
void take_controls(const nanobind::object& controls, const result::Joints& joints, task::MarchOptions& options);

/// Joint angles, likewise.
void take_angles(const nanobind::object& angles, const result::Joints& joints, task::MarchOptions& options);

}  // namespace lamprey::python
