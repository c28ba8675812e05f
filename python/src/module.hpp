// What each binding file adds to the module.
#pragma once

#include <nanobind/nanobind.h>

namespace lamprey::python {

void bind_model(nanobind::module_& module);      // InputError
void bind_fluid(nanobind::module_& module);      // ellipsoid_inertia
void bind_file(nanobind::module_& module);       // Problem, load
void bind_mechanics(nanobind::module_& module);  // Problem: connection, connection_curvature, height_functions
void bind_result(nanobind::module_& module);     // Trajectory, Solution, load_solution
void bind_task(nanobind::module_& module);       // solve, simulate, certify
void bind_search(nanobind::module_& module);     // Solver, Outcome

}  // namespace lamprey::python
