// Ctrl-C where work that is long looks for it: the first asks it to stop with its best point, the second ends the program.
#pragma once

namespace lamprey::app {

void watch_for_interrupt();
bool interrupted();

}  // namespace lamprey::app
