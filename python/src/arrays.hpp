// Numbers of the rooms as NumPy arrays, and the other way.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamprey::python {

/// A read-only array that owns its numbers, row-major.
nanobind::object array(std::vector<double> values, const std::vector<std::size_t>& shape);

nanobind::object array(const Eigen::Vector3d& vector);
nanobind::object array(const Eigen::Matrix3d& matrix);

using Numbers = nanobind::ndarray<const double, nanobind::c_contig, nanobind::device::cpu>;

/// Anything NumPy makes a float64 array of: lists, tuples, arrays; of the rest a model::InputError naming `key`.
Numbers numbers(nanobind::handle object, const std::string& key);

/// model::InputError naming `key` unless they have this shape and are finite.
void require_shape(const Numbers& given, const std::vector<std::size_t>& shape, const std::string& key);

/// Three finite numbers; `what` says which, for the model::InputError naming `key`.
Eigen::Vector3d three(nanobind::handle object, const std::string& key, const std::string& what);

/// So many finite numbers, of which one may stand alone.
std::vector<double> several(nanobind::handle object, std::size_t count, const std::string& key,
                            const std::string& what);

/// model::InputError naming `key` unless the shape is [count][3] or [count][3][3] and every number finite.
std::vector<Eigen::Vector3d> vectors(nanobind::handle object, std::size_t count, const std::string& key);
std::vector<Eigen::Matrix3d> rotations(nanobind::handle object, std::size_t count, const std::string& key);

}  // namespace lamprey::python
