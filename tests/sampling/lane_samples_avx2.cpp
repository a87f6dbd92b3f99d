#include "lumisweep/math/lanes_avx2.h"
#include "sampling/lane_samples.h"

namespace lumisweep::test {

void sample_lanes_avx2(const DirectionSamplingView& view, const LaneSamples& samples)
{
    sample_lanes<Avx2Float>(view, samples);
}

} // namespace lumisweep::test
