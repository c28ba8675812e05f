// The data embedded in the report page.
#pragma once

#include <string>
#include <vector>

#include "result/results.hpp"

namespace lamprey::report {

/// Nodes to draw: all of them while few, else evenly spaced ones with both ends, so that frames × numbers_per_frame stays
/// near 150,000 and frames ≤ 2001.
std::vector<std::size_t> drawn_nodes(std::size_t nodes, std::size_t numbers_per_frame);

/// JSON {"runs": [...]}: words and rows of each run, its bodies and joints, and flat arrays of 7 significant digits for the
/// drawn nodes. Safe inside <script type="application/json">: every '<' is written \u003c.
std::string page_data(const std::vector<const result::Results*>& runs);

}  // namespace lamprey::report
