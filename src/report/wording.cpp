#include "report/wording.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace lamprey::report {
namespace {

std::string superscript(int power) {
  static constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(power)) text += c == '-' ? "⁻" : digits[c - '0'];
  return text;
}

std::string with_true_minus(const std::string& text) { return text[0] == '-' ? "−" + text.substr(1) : text; }

}  // namespace

std::string number(double value, int digits) {
  if (std::isnan(value)) return "not computed";
  if (std::isinf(value)) return value > 0.0 ? "∞" : "−∞";
  const double size = std::abs(value);
  if (size == 0.0) return "0";
  if (size >= 1e-3 && size < 1e7) {
    const int needed = static_cast<int>(std::ceil(std::log10(size)));
    return with_true_minus(fmt::format("{:.{}g}", value, std::max(digits, needed + 1)));
  }
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  const std::size_t split = text.find('e');
  std::string front = text.substr(0, split);
  if (front.find('.') != std::string::npos) front.erase(front.find_last_not_of("0.") + 1);
  const std::string power = "10" + superscript(std::stoi(text.substr(split + 1)));
  const std::string sign = value < 0.0 ? "−" : "";
  if (value < 0.0) front.erase(0, 1);
  return sign + (front == "1" ? "" : front + "×") + power;
}

std::string cost_number(double cost, int digits) {
  const double size = std::abs(cost);
  if (!(size >= 1e4 && size < 1e12)) return number(cost, digits);
  std::string text = size < 1e7 ? number(size, digits) : fmt::format("{:.0f}", size);
  for (std::size_t place = std::min(text.find('.'), text.size()); place > 3; place -= 3)
    text.insert(place - 3, "\u202f");
  return (cost < 0.0 ? "−" : "") + text;
}

std::string vector(const Eigen::Vector3d& value, int digits) {
  constexpr double round_off = 1e-12;  // of the largest entry: below it an entry is nothing
  const double least = round_off * value.cwiseAbs().maxCoeff();
  const auto entry = [&](double one) { return number(std::abs(one) < least ? 0.0 : one, digits); };
  return fmt::format("({}, {}, {})", entry(value.x()), entry(value.y()), entry(value.z()));
}

std::string matrix(const Eigen::Matrix3d& value, int digits) {
  const Eigen::Vector3d diagonal = value.diagonal();
  if (value == Eigen::Matrix3d(diagonal.asDiagonal())) return "diag" + vector(diagonal, digits);
  const auto row = [&](Eigen::Index r) {
    return fmt::format("{}, {}, {}", number(value(r, 0), digits), number(value(r, 1), digits),
                       number(value(r, 2), digits));
  };
  return fmt::format("[{}; {}; {}]", row(0), row(1), row(2));
}

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        if (static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n')
          safe += "\xEF\xBF\xBD";
        else
          safe += c;
    }
  }
  return safe;
}

}  // namespace lamprey::report
