// Memory in large pages: a search touches tens of megabytes, and thousands of small pages cost a tenth of its time.
#pragma once

namespace lamprey::app {

/// Asks for them, once, before anything large is allocated; where the system has none, nothing changes.
void use_large_pages();

}  // namespace lamprey::app
