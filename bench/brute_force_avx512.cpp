#if defined(__x86_64__)
#include "brute_force_march.h"
#include "lumisweep/math/lanes_avx512.h"

namespace lumisweep::bench {

std::uint64_t march_avx512(const GridView<std::uint8_t>& grid, const RayArrays& rays)
{
    return march_lanes<Avx512Float>(grid, rays);
}

} // namespace lumisweep::bench
#endif
