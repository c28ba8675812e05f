// A TOML file as a tree of plain values that remember where they stood.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace lamprey::document {

/// Place in a text file; lines and columns count from 1.
struct Position {
  int line = 1;
  int column = 1;
};

struct TomlValue {
  enum class Kind { boolean, integer, number, string, date, array, table };
  Kind kind = Kind::table;
  Position position;  // of its key; of the value itself in an array
  std::string key;    // its name within a table; empty in an array
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0.0;
  std::string text;
  std::vector<TomlValue> items;  // of an array or a table

  const TomlValue* find(std::string_view name) const;
};

/// The tree of a TOML text; model::InputError with the place for syntax errors, keys given twice and nesting deeper than 64.
/// `path` only names the file in messages.
TomlValue parse_toml(const std::string& text, const std::string& path);

/// The place of every key, by paths such as "time.steps" or "body[0].semi_axes"; "" is the document's start.
std::map<std::string, Position> key_positions(const TomlValue& document);

/// `name` below `path`, as in "start.rotation" + "front"; a name that TOML would quote is quoted.
std::string key_path(const std::string& path, std::string_view name);

/// The text in double quotes, shortened and with control characters escaped: safe inside a one-line message.
std::string in_quotes(std::string_view text);

}  // namespace lamprey::document
