#include "lumisweep/base/version.h"

namespace lumisweep {

const char* version() { return LUMISWEEP_VERSION; }

} // namespace lumisweep
