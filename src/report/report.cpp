#include "report/report.hpp"

#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "model/input_error.hpp"
#include "report/page_data.hpp"
#include "report/page_template.hpp"
#include "report/snapshots.hpp"
#include "report/wording.hpp"
#include "result/solution_file.hpp"
#include "result/trajectory_file.hpp"

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

// Those of other minima beyond the first `count` that came with the result that lies in a folder: one run wrote them all.
std::vector<std::filesystem::path> folders_of_others(const std::filesystem::path& within, std::size_t count) {
  std::vector<std::filesystem::path> folders;
  std::optional<result::Provenance> run;
  for (std::size_t n = count; std::filesystem::exists(within / folder_of_other(n) / "solution.json"); ++n) {
    if (!run) run = result::stored_provenance(within.string());
    if (!run) break;
    const std::filesystem::path folder = within / folder_of_other(n);
    if (result::stored_provenance(folder.string()) == run) folders.push_back(folder);
  }
  return folders;
}

// What write_results writes, and the folder where it holds nothing else.
void remove_results(const std::filesystem::path& folder) {
  std::error_code untold;
  for (const char* name : {"trajectory.h5", "report.html", "solution.json"})
    std::filesystem::remove(folder / name, untold);
  std::filesystem::remove(folder, untold);
}

}  // namespace

std::string report_html(const result::Results& results) {
  return filled({{"%TITLE%", escaped(results.name)},
                 {"%SNAPSHOTS%", snapshot_figures(results)},
                 {"%DATA%", page_data({&results})}});
}

std::string comparison_html(const result::Results& a, const result::Results& b) {
  if (a.problem.bodies.size() != b.problem.bodies.size() || a.problem.joints.size() != b.problem.joints.size()) {
    throw model::InputError("report",
                            "found two swimmers with other numbers of bodies or joints; allowed: two motions of "
                            "alike swimmers; write a report of each");
  }
  const auto heading = [](const char* letter, const result::Results& results) {
    return "<h3>" + std::string(letter) + ": " + escaped(results.name) + "</h3>\n";
  };
  return filled({{"%TITLE%", escaped(a.name + " | " + b.name)},
                 {"%SNAPSHOTS%", heading("A", a) + snapshot_figures(a) + heading("B", b) + snapshot_figures(b)},
                 {"%DATA%", page_data({&a, &b})}});
}

std::string folder_of_other(std::size_t n) { return "minimum_" + std::to_string(n + 2); }

void write_results(const std::string& folder, const result::Results& results) {
  const std::filesystem::path within = folder.empty() ? "." : folder;
  std::vector<std::filesystem::path> outdated;
  if (!results.alone)  // a motion that was read may have others that it does not know
    outdated = folders_of_others(within, results.others.size());
  for (std::size_t n = 0; n < results.others.size(); ++n)
    write_results((within / folder_of_other(n)).string(), results.others[n]);
  document::write_files(folder, {result::solution_file(results), result::trajectory_file(results),
                                 document::finished_file("report.html", report_html(results))});
  for (const std::filesystem::path& other : outdated) remove_results(other);
}

}  // namespace lamprey::report
