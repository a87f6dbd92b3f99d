#include "lumisweep/math/lanes_avx512.h"
#include "sampling/lane_samples.h"

namespace lumisweep::test {

void sample_lanes_avx512(const DirectionSamplingView& view, const LaneSamples& samples)
{
    sample_lanes<Avx512Float>(view, samples);
}

} // namespace lumisweep::test
