// The report page and its pictures, made from stored results alone.
#pragma once

#include <string>

#include "result/results.hpp"

namespace lamprey::report {

/// One self-contained HTML page: verdict, animation, snapshots, curves, certificate, search, problem, provenance. It runs
/// from a file, asks for nothing from anywhere, and keeps at most 2001 frames. Throws std::invalid_argument where the
/// arrays of the solution do not have the shapes of solution.json.
std::string report_html(const result::Results& results);

/// The same page for two results: both swimmers in one picture (b translucent), curves of b dashed. Bodies and joints are
/// paired by index, so both swimmers must have the same numbers of them, or std::invalid_argument is thrown.
std::string comparison_html(const result::Results& a, const result::Results& b);

/// Writes FOLDER/solution.json, trajectory.h5 and report.html, all of them or none, and the same of each other minimum that the results
/// hold into a folder within it. Of such folders beyond these, those go whose provenance is that of the solution.json that is
/// replaced. Failures of file::write_files.
void write_results(const std::string& folder, const result::Results& results);

/// Name of the folder of other minimum n: minimum_2 of the first.
std::string folder_of_other(std::size_t n);

/// Stand-alone SVG: the swimmer seen from above (e₁ right, e₂ up) each 0.07 of the duration and at the end.
std::string snapshot_svg(const result::Results& results);

}  // namespace lamprey::report
