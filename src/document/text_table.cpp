#include "document/text_table.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

#include <fmt/format.h>

namespace lamprey::document {

namespace {

// Characters of UTF-8 text: every byte that does not continue one.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

void TextTable::add_row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

std::string TextTable::text() const {
  std::vector<std::size_t> widths;
  for (const auto& row : rows_) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width(row[k]));
  }
  std::string result;
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::string padding(widths[k] - width(row[k]), ' ');
      const bool left = alignment_[std::min(k, alignment_.size() - 1)] == 'l';
      line += "  " + (left ? row[k] + padding : padding + row[k]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    result += line + "\n";
  }
  return result;
}

std::string wrapped(const std::string& words, const std::string& lead) {
  constexpr std::size_t widest = 110;
  std::string result, line;
  std::istringstream text(words);
  const auto add_line = [&] {
    result += (result.empty() ? lead : std::string(width(lead), ' ')) + line + "\n";
    line.clear();
  };
  for (std::string word; text >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > widest) add_line();
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) add_line();
  return result;
}

std::string short_number(double value) { return fmt::format("{:.6g}", value == 0.0 ? 0.0 : value); }

std::string printable(const std::string& text) {
  std::string result = text;
  const auto control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; };
  std::replace_if(result.begin(), result.end(), control, '?');
  return result;
}

}  // namespace lamprey::document
