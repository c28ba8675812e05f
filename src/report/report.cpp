#include "report/report.hpp"

#include <string_view>
#include <utility>
#include <vector>

#include "model/input_error.hpp"
#include "report/page_data.hpp"
#include "report/page_template.hpp"
#include "report/snapshots.hpp"
#include "report/wording.hpp"

namespace lamprey::report {
namespace {

/// The template with each mark, looked for from left to right, replaced by its text; texts are never searched.
std::string filled(const std::vector<std::pair<std::string_view, std::string>>& texts) {
  const std::string_view page = page_template();
  std::string html;
  std::size_t done = 0;
  for (const auto& [mark, text] : texts) {
    const std::size_t at = page.find(mark, done);
    if (at == std::string_view::npos) throw std::logic_error("report: the page lacks " + std::string(mark));
    html.append(page, done, at - done).append(text);
    done = at + mark.size();
  }
  return html.append(page, done, std::string_view::npos);
}

}  // namespace

std::string report_html(const file::Results& results) {
  return filled({{"%TITLE%", escaped(results.name)},
                 {"%SNAPSHOTS%", snapshot_figures(results)},
                 {"%DATA%", page_data({&results})}});
}

std::string comparison_html(const file::Results& a, const file::Results& b) {
  if (a.problem.bodies.size() != b.problem.bodies.size() || a.problem.joints.size() != b.problem.joints.size()) {
    throw model::InputError("report",
                            "found two swimmers with other numbers of bodies or joints; allowed: two motions of "
                            "alike swimmers; write a report of each");
  }
  const auto heading = [](const char* letter, const file::Results& results) {
    return "<h3>" + std::string(letter) + ": " + escaped(results.name) + "</h3>\n";
  };
  return filled({{"%TITLE%", escaped(a.name + " | " + b.name)},
                 {"%SNAPSHOTS%", heading("A", a) + snapshot_figures(a) + heading("B", b) + snapshot_figures(b)},
                 {"%DATA%", page_data({&a, &b})}});
}

}  // namespace lamprey::report
