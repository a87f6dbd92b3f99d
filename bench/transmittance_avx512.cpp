#if defined(__x86_64__)
#include "lumisweep/math/lanes_avx512.h"
#include "shadow_collector.h"
#include "transmittance_stream.h"

namespace lumisweep::bench {
namespace {

void estimate(TransmittanceJob& job) { estimate_transmittance<Avx512Float>(job); }
void collect(CollectJob& job) { collect_shadow_rays<Avx512Float>(job); }

} // namespace

const TransmittanceKernels transmittance_avx512{"avx512", estimate, collect};

} // namespace lumisweep::bench
#endif
