// Ctrl-C where work that is long looks for it: the first asks it to stop with its best point, further ones not to refine that; one
// more than it looks for ends the program.
#pragma once

namespace lamprey::app {

/// From now on so many are looked for.
void watch_for_interrupts(int count);
bool interrupted();
bool interrupted_again();

}  // namespace lamprey::app
