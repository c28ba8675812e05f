// Values in messages and names of tests: enumerations by the words of problem files, parameters by their values.
#pragma once

#include <gtest/gtest.h>

#include <cctype>
#include <ostream>
#include <string>
#include <type_traits>

#include "file/words.hpp"

namespace lamprey {

namespace model {
inline void PrintTo(JointKind kind, std::ostream* out) { *out << file::word(kind); }
}  // namespace model
namespace mechanics {
inline void PrintTo(DiscreteLagrangian lagrangian, std::ostream* out) {
  switch (lagrangian) {
    case DiscreteLagrangian::paper:
      *out << "paper";
      return;
    case DiscreteLagrangian::trapezoid:
      *out << "trapezoid";
      return;
    case DiscreteLagrangian::midpoint:
      *out << "midpoint";
      return;
  }
}
}  // namespace mechanics
namespace integrator {
inline void PrintTo(Scheme scheme, std::ostream* out) { *out << file::word(scheme); }
}  // namespace integrator
namespace maneuver {
inline void PrintTo(ControlKind kind, std::ostream* out) { *out << file::word(kind); }
inline void PrintTo(Status status, std::ostream* out) { *out << file::word(status); }
}  // namespace maneuver
namespace certificate {
inline void PrintTo(Verdict verdict, std::ostream* out) { *out << file::word(verdict); }
}  // namespace certificate

namespace tests {

template <class Value>
std::string in_words(const Value& value) {
  if constexpr (std::is_convertible_v<Value, std::string>) return value;
  return ::testing::PrintToString(value);
}

/// Names a test of a suite by its parameter: letters and digits of how it prints, in words.
inline const auto named_by_value = [](const auto& instance) {
  std::string name;
  for (const char c : in_words(instance.param))
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
};

}  // namespace tests
}  // namespace lamprey
