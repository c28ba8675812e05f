#include "document/toml_document.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "document/text_file.hpp"
#include "model/input_error.hpp"

namespace lamprey::document {

/// Thrown where the TOML parser assumes something of its input that does not hold (as for "[=" in 3.3): its own assertion would
/// abort, and without assertions it would run into undefined behaviour.
struct BrokenAssumption {};

[[noreturn]] void break_assumption();

}  // namespace lamprey::document

#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : ::lamprey::document::break_assumption())
#define TOML_HEADER_ONLY 1
#define TOML_ENABLE_FORMATTERS 0
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace lamprey::document {

void break_assumption() { throw BrokenAssumption(); }

namespace {

using model::InputError;

bool bare_key_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-'; }

// Walks over the raw bytes, so that no text, however deep, reaches the recursive parser: brackets and dotted keys both nest.
class NestingGuard {
 public:
  NestingGuard(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  void check() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        skip_string(c);
        continue;
      }
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
        continue;
      }
      count(c);
      ++at_;
    }
  }

 private:
  void count(char c) {
    if (c == '\n') {
      ++line_;
      line_start_ = at_ + 1;
    }
    if (c == '[' || c == '{') ++depth_;
    if (c == ']' || c == '}') depth_ = std::max(0, depth_ - 1);
    if (c == '.')
      ++dots_;
    else if (!bare_key_character(c) && c != ' ' && c != '\t')
      dots_ = 0;
    if (depth_ > nesting_limit || dots_ > nesting_limit)
      throw InputError(
          path_, line_, static_cast<int>(at_ - line_start_) + 1, "file",
          fmt::format("found nesting deeper than {0} levels; allowed: at most {0}; flatten the file", nesting_limit));
  }

  bool triple(char quote) const { return text_.substr(at_, 3) == std::string(3, quote); }

  void skip_string(char quote) {
    const bool multi_line = triple(quote);
    at_ += multi_line ? 3 : 1;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '\n') {
        if (!multi_line) return;
        ++line_;
        line_start_ = at_ + 1;
      }
      if (c == '\\' && quote == '"') {
        at_ += 1;
        if (at_ < text_.size() && text_[at_] == '\n') continue;
      } else if (c == quote && (!multi_line || triple(quote))) {
        at_ += multi_line ? 3 : 1;
        for (int extra = 0; multi_line && extra < 2 && at_ < text_.size() && text_[at_] == quote; ++extra) ++at_;
        return;
      }
      ++at_;
    }
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0;
  std::size_t line_start_ = 0;
  int line_ = 1;
  int depth_ = 0;
  int dots_ = 0;
};

Position position_of(const toml::source_region& region) {
  return {static_cast<int>(std::max(region.begin.line, toml::source_index{1})),
          static_cast<int>(std::max(region.begin.column, toml::source_index{1}))};
}

TomlValue converted(const toml::node& node) {
  using Kind = TomlValue::Kind;
  TomlValue value;
  value.position = position_of(node.source());
  if (const auto* boolean = node.as_boolean()) {
    value.kind = Kind::boolean;
    value.boolean = boolean->get();
  } else if (const auto* integer = node.as_integer()) {
    value.kind = Kind::integer;
    value.integer = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    value.kind = Kind::number;
    value.number = number->get();
  } else if (const auto* text = node.as_string()) {
    value.kind = Kind::string;
    value.text = text->get();
  } else if (const auto* array = node.as_array()) {
    value.kind = Kind::array;
    for (const toml::node& item : *array) value.items.push_back(converted(item));
  } else if (const auto* table = node.as_table()) {
    value.kind = Kind::table;
    for (const auto& [key, member] : *table) {
      value.items.push_back(converted(member));
      value.items.back().key = std::string(key.str());
      value.items.back().position = position_of(key.source());
    }
    std::stable_sort(value.items.begin(), value.items.end(), [](const TomlValue& a, const TomlValue& b) {
      return std::pair(a.position.line, a.position.column) < std::pair(b.position.line, b.position.column);
    });
  } else {
    value.kind = Kind::date;
  }
  return value;
}

bool plain_key(std::string_view key) {
  return !key.empty() && key.size() <= 100 &&
         std::all_of(key.begin(), key.end(), [](char c) { return bare_key_character(c) || c == '.'; });
}

// The key that line `line` of a text that is not TOML seems to set, with its table; "syntax" when there is none.
std::string guessed_key(std::string_view text, int line) {
  std::string section;
  std::map<std::string, int, std::less<>> seen;
  std::string_view current;
  for (int n = 1; n <= line && !text.empty(); ++n) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    current = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (current.empty() || current.front() != '[') continue;
    const bool repeated = current.substr(0, 2) == "[[";
    const std::size_t open = repeated ? 2 : 1;
    const std::string_view name = trimmed(current.substr(open, std::max(current.find(']'), open) - open));
    if (!plain_key(name)) continue;
    section = repeated ? fmt::format("{}[{}]", name, seen[std::string(name)]++) : std::string(name);
    if (n == line) return section;
  }
  const std::string_view key = trimmed(current.substr(0, current.find('=')));
  if (!plain_key(key)) return "syntax";
  return section.empty() ? std::string(key) : section + "." + std::string(key);
}

constexpr const char* syntax_allowed = "allowed: TOML, as in key = 1.0, \"text\" or [1, 2, 3]; mend this line";

// The name of a table that stands in double brackets, where one in single brackets is what was read; nothing: another key.
std::string many_tables(const std::string& key) {
  if (key.find('.') != std::string::npos) return "";
  const std::string name = key.substr(0, key.find('['));
  return name == "body" || name == "joint" || name == "waypoint" ? name : "";
}

[[noreturn]] void refuse_syntax(const toml::parse_error& error, const std::string& text, const std::string& path) {
  const Position place = position_of(error.source());
  const std::string key = guessed_key(text, place.line);
  const std::string description = in_quotes(error.description());
  const bool redefined = description.find("redefine") != std::string::npos;
  if (const std::string many = many_tables(key); redefined && !many.empty())
    throw InputError(
        path, place.line, place.column, key,
        fmt::format("found [{0}] as a table and a second time; allowed: any number of [[{0}]]; begin each with [[{0}]] "
                    "in double brackets",
                    many));
  const bool value_and_table =
      redefined &&
      (description.find("as dotted") != std::string::npos ||
       (description.find("key-value") != std::string::npos && description.find("existing table") != std::string::npos));
  const std::string message =
      value_and_table
          ? "found one value for this key and values for keys below it; allowed: either; where they differ write "
            "KEY.NAME = … for each NAME (" +
                description + ")"
      : redefined
          ? "found this key a second time; allowed: once in a table; remove one of the two (" + description + ")"
          : "found what TOML cannot read (" + description + "); " + syntax_allowed;
  throw InputError(path, place.line, place.column, key, message);
}

bool breaks_assumption(std::string_view text) {
  try {
    static_cast<void>(toml::parse(text));
  } catch (const BrokenAssumption&) {
    return true;
  } catch (const toml::parse_error&) {
  }
  return false;
}

// The parser stopped without a place: the first line whose presence stops it, by bisection over the lines.
[[noreturn]] void refuse_broken_assumption(const std::string& text, const std::string& path) {
  std::vector<std::size_t> ends;
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) ends.push_back(at + 1);
  ends.push_back(text.size());
  std::size_t low = 0;
  std::size_t high = ends.size() - 1;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (breaks_assumption(std::string_view(text).substr(0, ends[middle])))
      high = middle;
    else
      low = middle + 1;
  }
  const int line = static_cast<int>(low) + 1;
  throw InputError(path, line, 1, guessed_key(text, line),
                   std::string("found what TOML cannot read; ") + syntax_allowed);
}

void collect(const TomlValue& value, const std::string& path, std::map<std::string, Position>& positions) {
  positions.emplace(path, value.position);
  for (std::size_t i = 0; i < value.items.size(); ++i) {
    const TomlValue& item = value.items[i];
    if (value.kind == TomlValue::Kind::table)
      collect(item, key_path(path, item.key), positions);
    else if (item.kind == TomlValue::Kind::table)
      collect(item, fmt::format("{}[{}]", path, i), positions);
  }
}

}  // namespace

const TomlValue* TomlValue::find(std::string_view name) const {
  for (const TomlValue& item : items)
    if (item.key == name) return &item;
  return nullptr;
}

TomlValue parse_toml(const std::string& text, const std::string& path) {
  NestingGuard(text, path).check();
  try {
    TomlValue document = converted(toml::parse(text, path));
    document.position = {};
    return document;
  } catch (const toml::parse_error& error) {
    refuse_syntax(error, text, path);
  } catch (const BrokenAssumption&) {
    refuse_broken_assumption(text, path);
  }
}

std::map<std::string, Position> key_positions(const TomlValue& document) {
  std::map<std::string, Position> positions;
  collect(document, "", positions);
  return positions;
}

std::string key_path(const std::string& path, std::string_view name) {
  const bool bare = !name.empty() && name.size() <= 100 && std::all_of(name.begin(), name.end(), bare_key_character);
  const std::string last = bare ? std::string(name) : in_quotes(name);
  return path.empty() ? last : path + "." + last;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 100;
  std::string result = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool character_starts = (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
    if (i >= longest && character_starts) {
      result += "…";
      break;
    }
    if (static_cast<unsigned char>(c) < 0x20U || c == 0x7F)
      result += fmt::format("\\u{:04x}", static_cast<int>(c));
    else if (c == '"' || c == '\\')
      result += fmt::format("\\{}", c);
    else
      result += c;
  }
  return result + "\"";
}

}  // namespace lamprey::document
