#if defined(__x86_64__)
#include <immintrin.h>

#include <cstddef>

#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {
namespace {

struct Rays {
    using Weights = __m512i;
    __m512i sum;

    static __attribute__((always_inline)) inline Rays load(const std::int32_t* rays)
    {
        return {_mm512_loadu_si512(rays)};
    }
    __attribute__((always_inline)) inline void store(std::int32_t* rays) const { _mm512_storeu_si512(rays, sum); }
    static __attribute__((always_inline)) inline Weights weights(const std::int8_t* weight)
    {
        int four;
        __builtin_memcpy(&four, weight, 4);
        return _mm512_set1_epi32(four);
    }
    __attribute__((always_inline)) inline void add(const std::uint8_t* pairs, Weights weight)
    {
        sum = _mm512_dpbusd_epi32(sum, _mm512_loadu_si512(pairs), weight);
    }
    __attribute__((always_inline)) inline void add_some(const std::uint8_t* pairs, Weights weight, std::uint32_t which)
    {
        sum = _mm512_mask_dpbusd_epi32(sum, static_cast<__mmask16>(which), _mm512_loadu_si512(pairs), weight);
    }
};

} // namespace
} // namespace lumisweep

#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_avx512
#define LUMISWEEP_SWEEP_KERNELS_NAME "avx512"
#include "lumisweep/visibility/sweep_kernel_impl.h"
#endif
