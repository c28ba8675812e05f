// The report page as built by tools/build_web.sh, carried inside the program.
#pragma once

#include <string_view>

namespace lamprey::report {

/// web/dist/report.html with its marks %TITLE%, %SNAPSHOTS% and %DATA%.
std::string_view page_template();

}  // namespace lamprey::report
