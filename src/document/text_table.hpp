// Plain text in aligned columns for terminals.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace lamprey::document {

/// Rows of cells, two spaces apart.
class TextTable {
 public:
  /// One letter for each column, l or r for flush left or right; the last one holds for all further columns.
  explicit TextTable(std::string alignment) : alignment_(std::move(alignment)) {}
  void add_row(std::vector<std::string> cells);
  /// One line for each row, indented by two spaces, each ending with a line break.
  std::string text() const;

 private:
  std::string alignment_;
  std::vector<std::vector<std::string>> rows_;
};

/// Words in lines of at most 110 bytes, each ending with a line break: the first one after `lead`, the others as far in.
std::string wrapped(const std::string& words, const std::string& lead = "  ");

/// Six significant digits, as short as they allow.
std::string short_number(double value);

/// The text with control characters replaced by '?', so that no name can command a terminal.
std::string printable(const std::string& text);

}  // namespace lamprey::document
