#include "result/joint_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "document/text_file.hpp"
#include "document/toml_document.hpp"
#include "model/input_error.hpp"

namespace lamprey::result {

namespace {

using Eigen::Vector3d;
using model::InputError;

std::optional<double> parsed(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct Cell {
  std::string_view text;
  int column;  // in the line, from 1
};

std::vector<Cell> cells_of(std::string_view line) {
  std::vector<Cell> cells;
  std::size_t start = 0;
  while (true) {
    const std::size_t comma = std::min(line.find(',', start), line.size());
    const std::string_view cell = line.substr(start, comma - start);
    const std::size_t blanks = std::min(cell.find_first_not_of(" \t\r"), cell.size());
    cells.push_back({document::trimmed(cell), static_cast<int>(start + blanks) + 1});
    if (comma == line.size()) return cells;
    start = comma + 1;
  }
}

class TableParser {
 public:
  TableParser(TableKind kind, const std::string& path, const Joints& joints)
      : kind_(kind), path_(path), joints_(joints), columns_(columns_in_order(kind, joints)) {
    table_.left_out.assign(joints.size(), false);
  }

  JointTable parse(std::string_view text) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      const std::string_view content = document::trimmed(line);
      if (!content.empty() && content.front() != '#') read_row(cells_of(line));
    }
    require_agreement();
    if (table_.time.size() < 2) refuse(1, "t", fmt::format("{} rows", table_.time.size()), "at least two", "add rows");
    return table_;
  }

 private:
  [[noreturn]] void refuse(int column, const std::string& key, const std::string& found, const std::string& allowed,
                           const std::string& cure) const {
    throw InputError(path_, std::max(line_, 1), column, key,
                     fmt::format("found {}; allowed: {}; {}", found, allowed, cure));
  }

  std::string column_name(std::size_t column) const {
    if (column == 0) return "t";
    return fmt::format("{} of {}", kind_ == TableKind::moments ? "moment" : "angle",
                       joints_[columns_[column - 1].joint].name);
  }

  void read_row(const std::vector<Cell>& cells) {
    if (cells.size() == 1 && cells.front().text.find(';') != std::string_view::npos)
      refuse(cells.front().column, "row", "semicolons between columns", "commas, and points in numbers",
             "replace them");
    if (std::exchange(header_possible_, false) && !parsed(cells.front().text))
      read_header(cells);
    else
      read_numbers(cells);
  }

  void require_columns(const std::vector<Cell>& cells, const std::string& key) const {
    if (cells.size() == 1 + columns_.size()) return;
    refuse(1, key, fmt::format("{} columns", cells.size()),
           fmt::format("{}: t, then {}", 1 + columns_.size(),
                       named_ ? "those of the header"
                       : kind_ == TableKind::moments
                           ? "3 for each joint"
                           : "those of each joint: 1 of a hinge, 2 of a universal, 3 of a ball joint"),
           named_ ? "add or remove columns"
           : kind_ == TableKind::moments
               ? "add or remove columns, or name them in a header, where hinges need one column only"
               : "add or remove columns");
  }

  // A few names in quotes.
  static std::string shown(const std::vector<std::string>& names) {
    constexpr std::size_t enough = 4;
    std::string text;
    for (std::size_t n = 0; n < std::min(names.size(), enough); ++n)
      text += (n == 0 ? "" : ", ") + document::in_quotes(names[n]);
    return text + (names.size() > enough ? ", ..." : "");
  }

  // Of a table that names others than the problem's joints: of another swimmer, it seems.
  void require_own_columns(const std::vector<Cell>& cells, const std::vector<std::string_view>& header) const {
    const std::vector<std::string> names = names_in_header(header);
    if (cells.size() == 1 + columns_.size() || names.empty()) return require_columns(cells, "header");
    std::vector<std::string> own;
    for (const model::JointDescription& joint : joints_) own.push_back(joint.name);
    refuse(1, "header", fmt::format("{} columns", cells.size()),
           fmt::format("{}: t, then those of each joint", 1 + columns_.size()),
           own.empty() ? std::string("the problem has no joints")
                       : fmt::format("the header names {}, and no joint of this problem: {}; is it the table of "
                                     "another swimmer? else name these",
                                     shown(names), shown(own)));
  }

  void read_header(const std::vector<Cell>& cells) {
    std::vector<std::string_view> names;
    for (const Cell& cell : cells) names.push_back(cell.text);
    const TableHeader header = read_table_header(kind_, names, joints_);
    if (const auto& fault = header.fault)
      refuse(cells[fault->cell].column, "header", fault->found, fault->allowed, fault->cure);
    columns_ = header.columns;
    named_ = header.named;
    table_.left_out.assign(joints_.size(), named_);
    for (const TableColumn& column : columns_) table_.left_out[column.joint] = false;
    if (named_)
      require_columns(cells, "header");
    else
      require_own_columns(cells, names);
    if (!named_)
      table_.remark = fmt::format("the header of {} names no joints of this problem: its columns are taken as {}",
                                  path_, header_in_order(kind_, joints_));
  }

  void read_numbers(const std::vector<Cell>& cells) {
    require_columns(cells, "row");
    std::vector<double> numbers;
    for (const Cell& cell : cells) {
      const std::optional<double> value = parsed(cell.text);
      if (!value || !std::isfinite(*value))
        refuse(cell.column, column_name(numbers.size()), document::in_quotes(cell.text), "a finite number",
               "write it with a decimal point, as in -1.5e3");
      numbers.push_back(*value);
    }
    if (!table_.time.empty() && !(numbers[0] > table_.time.back()))
      refuse(cells[0].column, "t", fmt::format("{} after {}", numbers[0], table_.time.back()), "times that rise (s)",
             "sort the rows and remove repeated times");
    table_.time.push_back(numbers[0]);
    table_.value.emplace_back(joints_.size());
    for (Vector3d& value : table_.value.back()) value.setZero();
    for (std::size_t n = 1; n < numbers.size(); ++n)
      if (columns_[n - 1].again)
        restated_.push_back({line_, cells[n].column, n - 1, table_.time.size() - 1, numbers[n]});
      else
        table_.value.back()[columns_[n - 1].joint] += numbers[n] * columns_[n - 1].direction;
  }

  // Motors' moments beside x, y and z: who changes the one without the other cannot mean both.
  void require_agreement() {
    constexpr double rounding = 1e-3;  // of the joint's largest moment
    std::vector<double> largest(joints_.size(), 0.0);
    for (const auto& row : table_.value)
      for (std::size_t j = 0; j < joints_.size(); ++j) largest[j] = std::max(largest[j], row[j].norm());
    for (const Restated& one : restated_) {
      const TableColumn& column = columns_[one.of];
      const double moment = column.direction.dot(table_.value[one.row][column.joint]);
      if (std::abs(one.number - moment) <= rounding * largest[column.joint]) continue;
      line_ = one.line;
      refuse(one.column, column_name(one.of + 1),
             fmt::format("{} N m beside x, y and z that make {} N m", one.number, moment), "the same moment both ways",
             "change both, or leave the columns of one way out");
    }
  }

  // A moment that other columns hold, too.
  struct Restated {
    int line, column;     // where it stands
    std::size_t of, row;  // which of columns_, which of the rows
    double number;        // N m
  };

  TableKind kind_;
  const std::string& path_;
  const Joints& joints_;
  std::vector<TableColumn> columns_;  // after the first
  bool named_ = false;                // by a header
  int line_ = 0;
  bool header_possible_ = true;
  std::vector<Restated> restated_;
  JointTable table_;
};

}  // namespace

JointTable parse_joint_table(TableKind kind, std::string_view text, const std::string& path, const Joints& joints) {
  return TableParser(kind, path, joints).parse(text);
}

}  // namespace lamprey::result
