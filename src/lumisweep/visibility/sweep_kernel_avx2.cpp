#if defined(__x86_64__)
#include <immintrin.h>

#include <cstddef>

#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {
namespace {

struct Rays {
    using Weights = __m256i;
    __m256i sum[2];

    static __attribute__((always_inline)) inline Rays load(const std::int32_t* rays)
    {
        return {{_mm256_loadu_si256(reinterpret_cast<const __m256i*>(rays)),
                 _mm256_loadu_si256(reinterpret_cast<const __m256i*>(rays) + 1)}};
    }
    __attribute__((always_inline)) inline void store(std::int32_t* rays) const
    {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(rays), sum[0]);
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(rays) + 1, sum[1]);
    }
    static __attribute__((always_inline)) inline Weights weights(const std::int8_t* weight)
    {
        int four;
        __builtin_memcpy(&four, weight, 4);
        return _mm256_set1_epi32(four);
    }
    /// Two products fit 16 bits, because the weights of a slice sum to 127.
    static __attribute__((always_inline)) inline __m256i products(const std::uint8_t* pairs, Weights weight)
    {
        const __m256i voxels = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(pairs));
        return _mm256_madd_epi16(_mm256_maddubs_epi16(voxels, weight), _mm256_set1_epi16(1));
    }
    __attribute__((always_inline)) inline void add(const std::uint8_t* pairs, Weights weight)
    {
        sum[0] = _mm256_add_epi32(sum[0], products(pairs, weight));
        sum[1] = _mm256_add_epi32(sum[1], products(pairs + 32, weight));
    }
    __attribute__((always_inline)) inline void add_some(const std::uint8_t* pairs, Weights weight, std::uint32_t which)
    {
        const __m256i bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
        for (int half = 0; half < 2; ++half) {
            const __m256i chosen = _mm256_and_si256(_mm256_set1_epi32(static_cast<int>(which >> (8 * half))), bits);
            sum[half] = _mm256_add_epi32(
                sum[half], _mm256_and_si256(products(pairs + 32 * half, weight), _mm256_cmpeq_epi32(chosen, bits)));
        }
    }
};

inline int store_lines(std::uint8_t*, const std::uint16_t*, int) { return 0; }
inline int stream_lines(float*, const float*, int) { return 0; }
inline void fence_lines() {}

} // namespace
} // namespace lumisweep

#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_avx2
#define LUMISWEEP_SWEEP_KERNELS_NAME "avx2"
#include "lumisweep/visibility/sweep_kernel_impl.h"
#endif
