#include "document/json_text.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace lamprey::document {

std::string json(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string json_number(double value) {
  if (value == 0.0) return std::signbit(value) ? "-0.0" : "0";
  char text[32];  // a sign, 17 digits, a point and an exponent
  const char* end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 17).ptr;
  return std::string(static_cast<const char*>(text), end);
}

std::string json(double value) { return std::isfinite(value) ? json_number(value) : "null"; }
std::string json(bool value) { return value ? "true" : "false"; }
std::string json(int value) { return fmt::format("{}", value); }

std::string json(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", json_number(v[0]), json_number(v[1]), json_number(v[2]));
}

std::string json(const Eigen::Matrix3d& m) {
  return fmt::format("[{}, {}, {}]", json(Eigen::Vector3d(m.row(0))), json(Eigen::Vector3d(m.row(1))),
                     json(Eigen::Vector3d(m.row(2))));
}

void require_finite(bool finite, const std::string& field) {
  if (!finite) throw std::domain_error(field + ": found a number that is not finite, which no result may hold");
}

}  // namespace lamprey::document
