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

/// The whole cache lines go past the caches: nobody reads them before the sweep's end.
inline __attribute__((always_inline)) int store_lines(std::uint8_t* out, const std::uint16_t* in, int count)
{
    if (reinterpret_cast<std::uintptr_t>(out) % 64 != 0)
        return 0;
    const __m512i half = _mm512_set1_epi16(8);
    const int lines = count / 64 * 64;
    for (int i = 0; i < lines; i += 64) {
        const __m256i low =
            _mm512_cvtepi16_epi8(_mm512_srli_epi16(_mm512_add_epi16(_mm512_loadu_si512(in + i), half), 4));
        const __m256i high =
            _mm512_cvtepi16_epi8(_mm512_srli_epi16(_mm512_add_epi16(_mm512_loadu_si512(in + i + 32), half), 4));
        _mm512_stream_si512(reinterpret_cast<__m512i*>(out + i),
                            _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1));
    }
    return lines;
}
inline __attribute__((always_inline)) int stream_lines(float* out, const float* in, int count)
{
    if (reinterpret_cast<std::uintptr_t>(out) % 64 != 0)
        return 0;
    const int lines = count / 16 * 16;
    for (int i = 0; i < lines; i += 16)
        _mm512_stream_ps(out + i, _mm512_loadu_ps(in + i));
    return lines;
}
inline __attribute__((always_inline)) void fence_lines() { _mm_sfence(); }

} // namespace
} // namespace lumisweep

#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_avx512
#define LUMISWEEP_SWEEP_KERNELS_NAME "avx512"
#include "lumisweep/visibility/sweep_kernel_impl.h"
#endif
