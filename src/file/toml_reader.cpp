#include "file/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "file/words.hpp"
#include "model/input_error.hpp"

namespace lamprey::file {

namespace {

constexpr double least_size = 1e-60, largest_size = 1e60;  // of numbers, whose products have to stay numbers

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Kind = document::TomlValue::Kind;

bool is_number(const document::TomlValue& value) { return value.kind == Kind::integer || value.kind == Kind::number; }

double as_double(const document::TomlValue& value) {
  return value.kind == Kind::integer ? static_cast<double>(value.integer) : value.number;
}

void append_shown(const document::TomlValue& value, std::string& text) {
  constexpr std::size_t longest = 120;
  if (text.size() > longest) return;
  if (value.kind != Kind::array) {
    text += shown(value);
    return;
  }
  text += "[";
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    if (i > 0) text += ", ";
    if (text.size() > longest) {
      text += "…";
      break;
    }
    append_shown(value.items[i], text);
  }
  text += "]";
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::size_t longest_shared_piece(std::string_view a, std::string_view b) {
  std::size_t longest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      std::size_t length = 0;
      while (i + length < a.size() && j + length < b.size() && a[i + length] == b[j + length]) ++length;
      longest = std::max(longest, length);
    }
  return longest;
}

// Mistyped letters count against a candidate; what both words share in one piece counts for it, so that parts and longer
// forms of a word lead to it.
int strangeness(std::string_view word, std::string_view candidate) {
  constexpr std::size_t longest = 64;
  word = word.substr(0, longest);
  return static_cast<int>(edit_distance(word, candidate)) - static_cast<int>(longest_shared_piece(word, candidate));
}

std::string_view kind_cure(Kind kind) {
  switch (kind) {
    case Kind::boolean:
      return "write true or false without quotes";
    case Kind::integer:
      return "write a whole number without quotes or decimal point";
    case Kind::number:
      return "write a number without quotes";
    case Kind::string:
      return "write a text in double quotes";
    default:
      return "write a table";
  }
}

// By another program's word for the same, or else the nearest one.
std::string what_is_meant(const std::string& word, const std::vector<std::string>& allowed) {
  for (const auto& [other, here] : other_words) {
    if (other != word) continue;
    if (here.empty()) return "joints turn here, none slides";
    if (std::find(allowed.begin(), allowed.end(), here) != allowed.end())
      return fmt::format("{} is called {} here", document::in_quotes(word), document::in_quotes(std::string(here)));
  }
  return fmt::format("the nearest is {}", document::in_quotes(nearest(word, allowed)));
}

}  // namespace

void refuse(const std::string& key, const std::string& found, const std::string& allowed, const std::string& cure) {
  throw model::InputError(key, fmt::format("found {}; allowed: {}; {}", found, allowed, cure));
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  const auto closer = [&](const std::string& a, const std::string& b) {
    return strangeness(word, a) < strangeness(word, b);
  };
  const auto best = std::min_element(candidates.begin(), candidates.end(), closer);
  return best == candidates.end() ? std::string() : *best;
}

std::string shown(double value) { return fmt::format("{}", value); }

std::string shown(const Vector3d& value) { return fmt::format("[{}, {}, {}]", value[0], value[1], value[2]); }

std::string shown(const document::TomlValue& value) {
  switch (value.kind) {
    case Kind::boolean:
      return value.boolean ? "true" : "false";
    case Kind::integer:
      return fmt::format("{}", value.integer);
    case Kind::number:
      return shown(value.number);
    case Kind::string:
      return document::in_quotes(value.text);
    case Kind::date:
      return "a date or time";
    case Kind::table:
      return "a table";
    case Kind::array:
      break;
  }
  if (!value.items.empty() && value.items.front().kind == Kind::table)
    return fmt::format("{} tables", value.items.size());
  std::string text;
  append_shown(value, text);
  return text;
}

bool Range::contains(double value) const {
  return std::isfinite(value) && (low_included ? value >= low : value > low) &&
         (high_included ? value <= high : value < high);
}

std::string Range::in_words() const {
  std::string text;
  if (std::isfinite(low)) text += fmt::format(" {} {}", low_included ? "≥" : ">", low);
  if (std::isfinite(high)) text += fmt::format("{} {} {}", text.empty() ? "" : " and", high_included ? "≤" : "<", high);
  if (text.empty()) text = ", finite";
  return unit.empty() ? text : fmt::format("{} ({})", text, unit);
}

const std::vector<document::TomlValue>& TableReader::members() const {
  static const std::vector<document::TomlValue> none;
  return table_ ? table_->items : none;
}

void TableReader::allow_only(const std::vector<std::string>& known) const {
  for (const document::TomlValue& member : members()) {
    if (std::find(known.begin(), known.end(), member.key) != known.end()) continue;
    refuse(key(member.key), "an unknown key", fmt::format("{}", fmt::join(known, ", ")),
           fmt::format("the nearest known key is {}", document::in_quotes(nearest(member.key, known))));
  }
}

void TableReader::require(std::string_view name, const std::string& allowed) const {
  if (find(name) == nullptr) refuse(key(name), "nothing", allowed, "add this key");
}

TableReader TableReader::table(std::string_view name) const {
  const document::TomlValue* value = find(name);
  if (value && value->kind != Kind::table)
    refuse(key(name), shown(*value), "a table", fmt::format("write [{}], once, and its keys below it", key(name)));
  return {value, key(name)};
}

std::vector<TableReader> TableReader::tables(std::string_view name) const {
  std::vector<TableReader> readers;
  const document::TomlValue* value = find(name);
  if (!value) return readers;
  const bool all_tables = value->kind == Kind::array &&
                          std::all_of(value->items.begin(), value->items.end(),
                                      [](const document::TomlValue& item) { return item.kind == Kind::table; });
  if (!all_tables)
    refuse(key(name), shown(*value), "a list of tables",
           fmt::format("begin each with [[{}]] in double brackets", key(name)));
  for (std::size_t i = 0; i < value->items.size(); ++i)
    readers.emplace_back(&value->items[i], fmt::format("{}[{}]", key(name), i));
  return readers;
}

std::optional<std::string> TableReader::text(std::string_view name) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  if (value->kind != Kind::string) refuse(key(name), shown(*value), "a text", std::string(kind_cure(Kind::string)));
  return value->text;
}

std::optional<bool> TableReader::boolean(std::string_view name) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  if (value->kind != Kind::boolean)
    refuse(key(name), shown(*value), "true or false", std::string(kind_cure(Kind::boolean)));
  return value->boolean;
}

std::optional<std::int64_t> TableReader::integer(std::string_view name, std::int64_t low, std::int64_t high) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  const std::string allowed =
      low == high ? fmt::format("the whole number {}", low) : fmt::format("a whole number from {} to {}", low, high);
  if (value->kind != Kind::integer) {
    const std::string text = shown(*value);  // 50.0, which is written 50, is none either
    const bool digits = text.find_first_not_of("-0123456789") == std::string::npos;
    refuse(key(name), text + (digits ? ".0" : ""), allowed, std::string(kind_cure(Kind::integer)));
  }
  if (value->integer < low || value->integer > high)
    refuse(key(name), shown(*value), allowed, "choose one in that range");
  return value->integer;
}

double TableReader::number_in(const document::TomlValue& value, std::string_view name, const Range& range,
                              const document::TomlValue& whole, const std::string& allowed) const {
  if (!is_number(value))
    refuse(key(name), shown(whole), allowed,
           std::string(value.kind != Kind::array ? kind_cure(Kind::number)
                       : &value == &whole        ? "write one number, without brackets"
                                                 : "write a plain number for each, in one pair of brackets"));
  if (!range.contains(as_double(value))) {
    const bool degrees = range.unit == "rad" && std::abs(as_double(value)) > range.high;
    refuse(key(name), shown(whole), allowed,
           degrees ? "write radians: 180 degrees are 3.14159" : "choose a finite value in that range");
  }
  const double size = std::abs(as_double(value));
  const bool of_round_off = range.contains(-least_size);  // what may have a sign may be next to nothing
  if (size > largest_size || (size > 0.0 && size < least_size && !of_round_off))
    refuse(key(name), shown(whole), fmt::format("{}, of a size between {} and {}", allowed, least_size, largest_size),
           "check the units: products of such numbers are none");
  return as_double(value);
}

std::optional<double> TableReader::number(std::string_view name, const Range& range) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  return number_in(*value, name, range, *value, "a number" + range.in_words());
}

Vector3d TableReader::vector_in(const document::TomlValue& value, std::string_view name, const Range& range) const {
  const std::string allowed = "three numbers" + range.in_words();
  if (value.kind != Kind::array || value.items.size() != 3)
    refuse(key(name), shown(value), allowed, "write three of them in brackets, as in [1.0, 2.0, 3.0]");
  Vector3d vector;
  for (std::size_t i = 0; i < 3; ++i)
    vector[static_cast<Eigen::Index>(i)] = number_in(value.items[i], name, range, value, allowed);
  return vector;
}

std::optional<Vector3d> TableReader::vector(std::string_view name, const Range& range) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  return vector_in(*value, name, range);
}

std::optional<std::vector<Vector3d>> TableReader::vectors(std::string_view name, const Range& range,
                                                          const std::string& for_none) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  const bool of_arrays = value->kind == Kind::array &&
                         std::all_of(value->items.begin(), value->items.end(),
                                     [](const document::TomlValue& item) { return item.kind == Kind::array; });
  if (value->kind == Kind::array && value->items.empty())
    refuse(key(name), "[]", "at least one vector of three numbers", for_none);
  if (!of_arrays)
    refuse(key(name), shown(*value), "a list of vectors of three numbers",
           "write double brackets, as in [[0.0, 0.0, 1.0]]");
  std::vector<Vector3d> vectors;
  for (const document::TomlValue& item : value->items) vectors.push_back(vector_in(item, name, range));
  return vectors;
}

std::optional<Matrix3d> TableReader::matrix(std::string_view name, std::string_view unit) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  if (value->kind != Kind::array || value->items.size() != 3)
    refuse(key(name), shown(*value), "three numbers (the diagonal) or three rows of three", "as in [1.0, 2.0, 3.0]");
  if (value->items.front().kind != Kind::array) return Matrix3d(vector_in(*value, name, any_number(unit)).asDiagonal());
  Matrix3d matrix;
  for (std::size_t row = 0; row < 3; ++row)
    matrix.row(static_cast<Eigen::Index>(row)) = vector_in(value->items[row], name, any_number(unit)).transpose();
  return matrix;
}

std::optional<std::size_t> TableReader::choice(std::string_view name, const std::vector<std::string>& words) const {
  const document::TomlValue* value = find(name);
  if (!value) return std::nullopt;
  const std::string allowed = fmt::format("\"{}\"", fmt::join(words, "\" or \""));
  if (value->kind != Kind::string) refuse(key(name), shown(*value), allowed, std::string(kind_cure(Kind::string)));
  const auto found = std::find(words.begin(), words.end(), value->text);
  if (found == words.end()) refuse(key(name), shown(*value), allowed, what_is_meant(value->text, words));
  return static_cast<std::size_t>(found - words.begin());
}

}  // namespace lamprey::file
