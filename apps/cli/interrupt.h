// Ctrl-C: the first asks the render to stop at the next pass, the second ends the program.
#pragma once

namespace lumisweep::cli {

/// From now on SIGINT and SIGTERM set a flag, once each; a second one has its usual effect.
void catch_interrupts();
bool interrupted();

} // namespace lumisweep::cli
