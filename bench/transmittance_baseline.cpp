#include "shadow_collector.h"
#include "transmittance_stream.h"

namespace lumisweep::bench {
namespace {

void estimate(TransmittanceJob& job) { estimate_transmittance<float>(job); }
void collect(CollectJob& job) { collect_shadow_rays<float>(job); }

} // namespace

const TransmittanceKernels transmittance_baseline{"baseline", estimate, collect};

} // namespace lumisweep::bench
