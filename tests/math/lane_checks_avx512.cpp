#include "lumisweep/math/lanes_avx512.h"
#include "math/lane_checks.h"

namespace lumisweep::test {

void run_lanes_avx512(const LaneInput& in, LaneOutput& out) { run_lanes<Avx512Float>(in, out); }

} // namespace lumisweep::test
