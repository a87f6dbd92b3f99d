#include "lumisweep/math/lanes_avx2.h"
#include "math/lane_checks.h"

namespace lumisweep::test {

void run_lanes_avx2(const LaneInput& in, LaneOutput& out) { run_lanes<Avx2Float>(in, out); }

} // namespace lumisweep::test
