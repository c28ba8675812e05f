// Problem files: TOML text → the plain numbers of maneuver::Problem, fully validated, and the place of every key for messages.
#pragma once

#include <map>
#include <string>

#include "document/toml_document.hpp"
#include "maneuver/problem.hpp"
#include "model/input_error.hpp"

namespace lamprey::file {

inline constexpr std::int64_t step_limit = 10'000'000;  // steps of a motion
inline constexpr double loosest_tolerance = 0.1;        // on certificate.kkt

struct ProblemFile {
  maneuver::Problem problem;
  std::string path;                                     // as given; names the file in messages
  std::string sha256;                                   // of the file's bytes
  std::map<std::string, document::Position> positions;  // of every key, by paths such as "body[0].semi_axes"
};

/// Reads and validates a problem file; IoError when it cannot be read, model::InputError (file, line, column, key) when it is wrong.
ProblemFile read_problem_file(const std::string& path);

/// The problem alone, with read_problem_file's failures.
maneuver::Problem read_problem(const std::string& path);

/// The same from the file's bytes; `path` only names them.
ProblemFile parse_problem(const std::string& bytes, const std::string& path);

/// The error with file, line and column of its key, or of the nearest enclosing key that the file has.
model::InputError located(const model::InputError& error, const ProblemFile& file);

/// By which solver a maneuver is sought; marching takes everything that can be read.
enum class Purpose { solve, solve_with_ipopt };

/// Throws model::InputError, with its place, for what the interface describes but this version cannot solve yet, and for
/// a goal that is missing.
void require_supported(const ProblemFile& file, Purpose purpose);

/// Throws model::InputError, with its place, where a maneuver's given start, or the end that its goal fixes, breaks one of its
/// limits, or all ends would: no moment changes that.
/// Needs start rotations of all bodies.
void require_ends_within_limits(const ProblemFile& file);

}  // namespace lamprey::file
