#if defined(__x86_64__)
#include "brute_force_march.h"
#include "lumisweep/math/lanes_avx2.h"

namespace lumisweep::bench {

std::uint64_t march_avx2(const GridView<std::uint8_t>& grid, const RayArrays& rays)
{
    return march_lanes<Avx2Float>(grid, rays);
}

} // namespace lumisweep::bench
#endif
