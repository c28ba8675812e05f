#include "arrays.hpp"

#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <Eigen/LU>

#include "model/input_error.hpp"

namespace lamprey::python {

namespace nb = nanobind;

namespace {

constexpr double orthogonal = 1e-6;  // how far RᵀR of a rotation may be from I

std::string shown(const std::vector<std::size_t>& shape) {
  std::string text;
  for (const std::size_t length : shape) text += fmt::format("[{}]", length);
  return text;
}

}  // namespace

nb::object array(std::vector<double> values, const std::vector<std::size_t>& shape) {
  auto kept = std::make_unique<std::vector<double>>(std::move(values));
  const double* data = kept->data();
  const nb::capsule owner(kept.get(), [](void* vector) noexcept { delete static_cast<std::vector<double>*>(vector); });
  kept.release();
  return nb::cast(nb::ndarray<nb::numpy, const double>(data, shape.size(), shape.data(), owner));
}

nb::object array(const Eigen::Vector3d& vector) { return array({vector[0], vector[1], vector[2]}, {3}); }

nb::object array(const Eigen::Matrix3d& matrix) {
  std::vector<double> values;
  for (Eigen::Index row = 0; row < 3; ++row)
    for (Eigen::Index column = 0; column < 3; ++column) values.push_back(matrix(row, column));
  return array(std::move(values), {3, 3});
}

void require_shape(const Numbers& given, const std::vector<std::size_t>& shape, const std::string& key) {
  std::vector<std::size_t> found;
  std::size_t size = 1;
  for (std::size_t axis = 0; axis < given.ndim(); ++axis) {
    found.push_back(given.shape(axis));
    size *= found.back();
  }
  if (found != shape)
    throw model::InputError(
        key, fmt::format("found the shape {}; allowed: {}; give an array of that shape", shown(found), shown(shape)));
  for (std::size_t n = 0; n < size; ++n)
    if (!std::isfinite(given.data()[n]))
      throw model::InputError(key, fmt::format("found {}; allowed: finite numbers; mend entry {}", given.data()[n], n));
}

Numbers numbers(nb::handle object, const std::string& key) {
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    return nb::cast<Numbers>(numpy.attr("ascontiguousarray")(object, numpy.attr("float64")));
  } catch (nb::python_error& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw model::InputError(
        key, "found what is no array of numbers; allowed: numbers, lists of them, NumPy arrays; mend it");
  }
}

Eigen::Vector3d three(nb::handle object, const std::string& key, const std::string& what) {
  const Numbers given = numbers(object, key);
  if (given.ndim() != 1 || given.shape(0) != 3)
    throw model::InputError(key, "found another shape; allowed: three numbers, " + what + "; give three");
  const Eigen::Vector3d vector = Eigen::Map<const Eigen::Vector3d>(given.data());
  if (!vector.allFinite())
    throw model::InputError(key, "found a number that is not finite; allowed: " + what + "; mend it");
  return vector;
}

std::vector<double> several(nb::handle object, std::size_t count, const std::string& key, const std::string& what) {
  const Numbers given = numbers(object, key);
  if (given.size() != count || given.ndim() != 1) throw model::InputError(key, "found another shape; allowed: " + what);
  const std::vector<double> values(given.data(), given.data() + count);
  for (double value : values)
    if (!std::isfinite(value))
      throw model::InputError(key, "found a number that is not finite; allowed: " + what + "; mend it");
  return values;
}

std::vector<Eigen::Vector3d> vectors(nb::handle object, std::size_t count, const std::string& key) {
  const Numbers given = numbers(object, key);
  require_shape(given, {count, 3}, key);
  std::vector<Eigen::Vector3d> result;
  for (std::size_t i = 0; i < count; ++i) result.emplace_back(Eigen::Map<const Eigen::Vector3d>(given.data() + 3 * i));
  return result;
}

std::vector<Eigen::Matrix3d> rotations(nb::handle object, std::size_t count, const std::string& key) {
  const Numbers given = numbers(object, key);
  require_shape(given, {count, 3, 3}, key);
  std::vector<Eigen::Matrix3d> result;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Matrix3d R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(given.data() + 9 * i);
    const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(error <= orthogonal) || !(R.determinant() > 0.0))
      throw model::InputError(
          fmt::format("{}[{}]", key, i),
          fmt::format("found a matrix that is no rotation (RᵀR − I up to {:.1e}, determinant {:.3g}); allowed: "
                      "orthogonal matrices of determinant 1, body → world; orthogonalise it",
                      error, R.determinant()));
    result.push_back(R);
  }
  return result;
}

}  // namespace lamprey::python
