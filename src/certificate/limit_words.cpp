#include "certificate/limit_words.hpp"

#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <string_view>

namespace lamprey::certificate {

namespace {

struct Unit {
  std::string_view of;  // how keys begin
  std::string_view words;
};

constexpr std::array units{Unit{"limits.torque", "times its bound"},
                           Unit{"limits.angular_velocity", "times its bound"},
                           Unit{"limits.clearance", "m"},
                           Unit{"limits.sphere", "m"},
                           Unit{"limits.half_space", "m"},
                           Unit{"limits.", "rad"},
                           Unit{"time.", "times its bound"}};

std::string_view unit_of(std::string_view key) {
  for (const Unit& unit : units)
    if (key.starts_with(unit.of)) return unit.words;
  return "(rad or m)";
}

}  // namespace

std::string violation_in_words(const std::string& key, double violation, double time) {
  std::ostringstream text;
  text << key << " is broken by " << std::setprecision(2);
  if (violation >= 100.0 && violation < 1e6)  // in digits, not as 2.7e+02
    text << std::lround(violation / 10.0) * 10;
  else
    text << violation;
  text << " " << unit_of(key) << " at " << std::setprecision(3) << time << " s";
  return text.str();
}

}  // namespace lamprey::certificate
