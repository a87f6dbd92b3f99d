// The version of the library, as clients and files name it.
#pragma once

namespace lumisweep {

/// "0.1.0".
const char* version();

} // namespace lumisweep
