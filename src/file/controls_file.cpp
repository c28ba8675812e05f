#include "file/controls_file.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "file/solution_file.hpp"
#include "file/text_file.hpp"
#include "file/toml_document.hpp"
#include "model/input_error.hpp"

namespace lamprey::file {

namespace {

using model::InputError;

constexpr std::size_t byte_limit = std::size_t{1} << 30;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

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
    cells.push_back({trimmed(cell), static_cast<int>(start + blanks) + 1});
    if (comma == line.size()) return cells;
    start = comma + 1;
  }
}

class TableParser {
 public:
  TableParser(const std::string& path, int joints) : path_(path), columns_(1 + 3 * static_cast<std::size_t>(joints)) {}

  ControlSamples parse(std::string_view text) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      ++line_;
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      const std::string_view content = trimmed(line);
      if (!content.empty() && content.front() != '#') read_row(cells_of(line));
    }
    if (samples_.time.size() < 2)
      refuse(1, "t", fmt::format("{} rows", samples_.time.size()), "at least two", "add rows");
    return samples_;
  }

 private:
  [[noreturn]] void refuse(int column, const std::string& key, const std::string& found, const std::string& allowed,
                           const std::string& cure) const {
    throw InputError(path_, std::max(line_, 1), column, key,
                     fmt::format("found {}; allowed: {}; {}", found, allowed, cure));
  }

  static std::string column_name(std::size_t column) {
    if (column == 0) return "t";
    return fmt::format("joint {} moment {}", (column - 1) / 3, (column - 1) % 3);
  }

  void read_row(const std::vector<Cell>& cells) {
    if (!header_possible_ || parsed(cells.front().text)) {
      header_possible_ = false;
      read_numbers(cells);
    }
    header_possible_ = false;
  }

  void read_numbers(const std::vector<Cell>& cells) {
    if (cells.size() != columns_)
      refuse(1, "row", fmt::format("{} columns", cells.size()), fmt::format("{}: t, then 3 for each joint", columns_),
             "add or remove columns");
    std::vector<double> numbers;
    for (const Cell& cell : cells) {
      const std::optional<double> value = parsed(cell.text);
      if (!value || !std::isfinite(*value))
        refuse(cell.column, column_name(numbers.size()), in_quotes(cell.text), "a finite number",
               "write it with a decimal point, as in -1.5e3");
      numbers.push_back(*value);
    }
    if (!samples_.time.empty() && !(numbers[0] > samples_.time.back()))
      refuse(cells[0].column, "t", fmt::format("{} after {}", numbers[0], samples_.time.back()), "times that rise (s)",
             "sort the rows and remove repeated times");
    samples_.time.push_back(numbers[0]);
    samples_.control.emplace_back();
    for (std::size_t i = 1; i < numbers.size(); i += 3)
      samples_.control.back().emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
  }

  const std::string& path_;
  std::size_t columns_;
  int line_ = 0;
  bool header_possible_ = true;
  ControlSamples samples_;
};

ControlSamples controls_of_solution(const std::string& bytes, const std::string& path, int joints) {
  const Results results = parse_solution(bytes, path);
  if (results.problem.joints.size() != static_cast<std::size_t>(joints))
    throw InputError(path, "/problem/joints",
                     fmt::format("found {} joints; allowed: the problem's {}; choose the controls of the same swimmer",
                                 results.problem.joints.size(), joints));
  if (results.solution.time.size() < 2)
    throw InputError(path, "/time", "found no motion; allowed: at least two nodes; choose a file with a trajectory");
  for (std::size_t k = 1; k < results.solution.time.size(); ++k)
    if (!(results.solution.time[k] > results.solution.time[k - 1]))
      throw InputError(path, fmt::format("/time/{}", k),
                       fmt::format("found {} after {}; allowed: times that rise (s); mend this field",
                                   results.solution.time[k], results.solution.time[k - 1]));
  ControlSamples samples;
  const bool spline = results.problem.control == maneuver::ControlKind::spline;
  samples.source = spline ? ControlSource::spline : ControlSource::steps;
  samples.time = results.solution.time;
  samples.control = results.solution.control;
  samples.points = results.problem.points;
  samples.scheme = results.problem.scheme;
  return samples;
}

}  // namespace

ControlSamples parse_controls(const std::string& bytes, const std::string& path, int joints) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && bytes[first] == '{') return controls_of_solution(bytes, path, joints);
  return TableParser(path, joints).parse(bytes);
}

ControlSamples read_controls(const std::string& path, int joints) {
  return parse_controls(read_bytes(path, byte_limit), path, joints);
}

}  // namespace lamprey::file
