// What stands behind Python's classes.
#pragma once

#include <nanobind/nanobind.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "file/problem_file.hpp"
#include "mechanics/height_functions.hpp"
#include "result/results.hpp"

namespace lamprey::python {

/// Stands for the file's name where a problem was made in Python.
inline constexpr const char* made_in_python = "<Python>";

struct Problem {
  file::ProblemFile file;
  std::string text;  // TOML, from which `file` was read
};

/// The problem of a file's text, its system checked too; `path` names it in messages.
Problem problem_from(const std::string& text, const std::string& path);
Problem load(const std::filesystem::path& path);

/// A Problem as it is, a dict as its settings, anything else as the path of a problem file.
Problem problem_or_loaded(nanobind::handle object);

/// What Problem.height_functions returns.
nanobind::dict dict_of(const mechanics::HeightFunctions& heights);

/// A motion. What Python asks for is made at the first question and kept.
class Trajectory {
 public:
  explicit Trajectory(result::Results results)
      : results_(std::make_shared<const result::Results>(std::move(results))) {}
  const result::Results& results() const { return *results_; }
  /// An array of solution.json by its path, such as "momentum/linear/total"; None where there is none.
  nanobind::object array(const std::string& path) const;
  /// Anything of solution.json that is not an array over the nodes; None where there is none.
  nanobind::object entry(const std::string& key) const;

 private:
  std::shared_ptr<const result::Results> results_;
  mutable std::map<std::string, nanobind::object> arrays_;
  mutable nanobind::object document_;
};

/// A motion that was sought, with its certificate.
class Solution : public Trajectory {
 public:
  using Trajectory::Trajectory;
};

}  // namespace lamprey::python
