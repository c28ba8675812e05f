#include "report/page_template.hpp"

// The assembler reads the file (found by the -I that CMakeLists.txt gives it): no generated source, no time to compile.
asm(R"(
  .pushsection .rodata
  .global lamprey_report_page
  .hidden lamprey_report_page
  .global lamprey_report_page_end
  .hidden lamprey_report_page_end
lamprey_report_page:
  .incbin "report.html"
lamprey_report_page_end:
  .byte 0
  .popsection
)");

extern "C" {
extern const char lamprey_report_page[] __attribute__((visibility("hidden")));
extern const char lamprey_report_page_end[] __attribute__((visibility("hidden")));
}

namespace lamprey::report {

std::string_view page_template() { return {lamprey_report_page, lamprey_report_page_end}; }

}  // namespace lamprey::report
