// Typed access to the tables of a problem file. Every refusal is a model::InputError with the key alone, saying what was found,
// what is allowed and how to mend it; read_problem adds file, line and column.
#pragma once

#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "document/toml_document.hpp"

namespace lamprey::file {

/// Throws model::InputError(key, "found F; allowed: A; C").
[[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& allowed,
                         const std::string& cure);

/// The candidate that `word` was most likely meant to be: few mistyped letters, a long piece in common; empty when there is none.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

/// The value as a person would write it, shortened, on one line.
std::string shown(const document::TomlValue& value);
std::string shown(const Eigen::Vector3d& value);
std::string shown(double value);

/// The numbers a key allows, and their unit for messages.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_included = false;
  bool high_included = true;
  std::string_view unit;

  bool contains(double value) const;
  std::string in_words() const;
};

constexpr Range any_number(std::string_view unit) { return {.unit = unit}; }
/// rad: up to a full turn either way, for more is meant in degrees.
constexpr Range turn() {
  return {.low = -2.0 * std::numbers::pi, .high = 2.0 * std::numbers::pi, .low_included = true, .unit = "rad"};
}
constexpr Range positive(std::string_view unit) { return {.low = 0.0, .unit = unit}; }
constexpr Range not_negative(std::string_view unit) { return {.low = 0.0, .low_included = true, .unit = unit}; }

/// One table of the file, or its absence (every key is then absent). The tree must outlive the reader.
class TableReader {
 public:
  TableReader(const document::TomlValue* table, std::string path) : table_(table), path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  std::string key(std::string_view name) const { return document::key_path(path_, name); }
  bool present() const { return table_ != nullptr; }
  const document::TomlValue* find(std::string_view name) const { return table_ ? table_->find(name) : nullptr; }
  const std::vector<document::TomlValue>& members() const;

  /// Refuses the first key that is not in the list, naming the nearest one that is.
  void allow_only(const std::vector<std::string>& known) const;

  /// Refuses the absence of a key; `allowed` says what to write there.
  void require(std::string_view name, const std::string& allowed) const;

  TableReader table(std::string_view name) const;
  std::vector<TableReader> tables(std::string_view name) const;

  // Nothing when the key is absent; a refusal when its value has the wrong type, shape or size.
  std::optional<std::string> text(std::string_view name) const;
  std::optional<bool> boolean(std::string_view name) const;
  std::optional<std::int64_t> integer(std::string_view name, std::int64_t low, std::int64_t high) const;
  std::optional<double> number(std::string_view name, const Range& range) const;
  std::optional<Eigen::Vector3d> vector(std::string_view name, const Range& range) const;
  /// At least one; `for_none` says how to mend an empty list.
  std::optional<std::vector<Eigen::Vector3d>> vectors(std::string_view name, const Range& range,
                                                      const std::string& for_none) const;
  /// A 3×3 matrix from three numbers (its diagonal) or three rows.
  std::optional<Eigen::Matrix3d> matrix(std::string_view name, std::string_view unit) const;

  /// The position of the key's word in the list.
  std::optional<std::size_t> choice(std::string_view name, const std::vector<std::string>& words) const;

  /// The value whose word the key holds, from one of the tables of file/words.hpp.
  template <class Words>
  auto word(std::string_view name, const Words& entries) const -> std::optional<decltype(entries.front().value)> {
    std::vector<std::string> texts;
    for (const auto& entry : entries) texts.emplace_back(entry.text);
    const std::optional<std::size_t> index = choice(name, texts);
    if (!index) return std::nullopt;
    return entries[*index].value;
  }

  double number_in(const document::TomlValue& value, std::string_view name, const Range& range,
                   const document::TomlValue& whole, const std::string& allowed) const;
  Eigen::Vector3d vector_in(const document::TomlValue& value, std::string_view name, const Range& range) const;

 private:
  const document::TomlValue* table_;
  std::string path_;
};

}  // namespace lamprey::file
