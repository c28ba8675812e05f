// What people choose by name or number when they run a task, on the command line as in Python.
#pragma once

#include <string>

#include "maneuver/problem.hpp"
#include "search/solve.hpp"

namespace lamprey::task {

inline constexpr int most_cycles = 100'000;  // of a gait that is marched
inline constexpr int most_workers = 1024;    // threads

/// model::InputError (`key`) where no scheme or solver is called so.
maneuver::Scheme scheme_named(const std::string& key, const std::string& name);
search::Backend backend_named(const std::string& key, const std::string& name);

}  // namespace lamprey::task
