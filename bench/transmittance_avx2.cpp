#if defined(__x86_64__)
#include "lumisweep/math/lanes_avx2.h"
#include "shadow_collector.h"
#include "transmittance_stream.h"

namespace lumisweep::bench {
namespace {

void estimate(TransmittanceJob& job) { estimate_transmittance<Avx2Float>(job); }
void collect(CollectJob& job) { collect_shadow_rays<Avx2Float>(job); }

} // namespace

const TransmittanceKernels transmittance_avx2{"avx2", estimate, collect};

} // namespace lumisweep::bench
#endif
