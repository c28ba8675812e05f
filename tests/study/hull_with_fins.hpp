// A hull that two fins on hinges turn, by 0.2 rad in a free duration.
#pragma once

#include <string>
#include <utility>

#include "file/problem_file.hpp"

namespace lamprey::tests {

/// `between`: least and largest duration, s.
inline maneuver::Problem hull_with_fins(int steps, std::pair<double, double> between) {
  std::string text = R"(schema = 1
name = "fins"
[fluid]
density = 1000.0
[goal]
turn = [0, 0, 0.2]
[limits]
angle.L = [-1.2, 1.2]
angle.R = [-1.2, 1.2]
[cost]
time = 1.0
[time]
duration = "free"
)" +
                     ("min = " + std::to_string(between.first) + "\nmax = " + std::to_string(between.second) +
                      "\nsteps = " + std::to_string(steps)) +
                     R"(
[[body]]
name = "hull"
semi_axes = [0.3,0.1,0.08]
)";
  for (const auto& [name, side] : {std::pair("L", 1.0), std::pair("R", -1.0)})
    text += std::string("[[body]]\nname = \"") + name +
            "\"\nsemi_axes = [0.03,0.12,0.05]\n[[joint]]\nkind = \"hinge\"\nparent = \"hull\"\nchild = \"" + name +
            "\"\nparent_offset = [-0.05, " + std::to_string(0.12 * side) + ", 0]\nchild_offset = [0, " +
            std::to_string(-0.13 * side) + ", 0]\naxis = [0, 0, 1]\n";
  return file::parse_problem(text, "fins.toml").problem;
}

}  // namespace lamprey::tests
