// Values as JSON text.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

namespace lamprey::document {

/// Names and messages come from people: whatever is not UTF-8 is replaced rather than refused.
std::string json(std::string_view text);

/// 17 digits; the sign of a negative zero survives only with a decimal point, since readers take "-0" for a whole number. The number
/// is finite.
std::string json_number(double value);
/// The same, or null where it is not finite.
std::string json(double value);
std::string json(bool value);
std::string json(int value);
/// Finite numbers.
std::string json(const Eigen::Vector3d& v);
std::string json(const Eigen::Matrix3d& m);

/// Throws std::domain_error that names the field.
void require_finite(bool finite, const std::string& field);

}  // namespace lamprey::document
