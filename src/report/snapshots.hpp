// Pictures of the swimmer at a few times, as SVG with exact outlines.
#pragma once

#include <string>

#include "report/outline.hpp"
#include "result/results.hpp"

namespace lamprey::report {

/// The HTML figures of the report page: view from above and from behind, a small SVG for each time.
std::string snapshot_figures(const result::Results& results);

}  // namespace lamprey::report
