#if defined(__x86_64__)
#include <cstddef>
#include <cstdint>

#include <immintrin.h>

namespace lumisweep {
namespace {

struct Cells {
    using Float = __m512;
    static constexpr int width = 16;

    static Float load(const std::uint8_t* p)
    {
        return _mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p))));
    }
    static Float load(const float* p) { return _mm512_load_ps(p); }
    static void store(float* p, Float v) { _mm512_store_ps(p, v); }
    static void store_transposed(float* p, int stride, Float a, Float b, Float c, Float d)
    {
        const Float ab0 = _mm512_unpacklo_ps(a, b), ab1 = _mm512_unpackhi_ps(a, b);
        const Float cd0 = _mm512_unpacklo_ps(c, d), cd1 = _mm512_unpackhi_ps(c, d);
        store_quarters(p, stride, _mm512_shuffle_ps(ab0, cd0, 0x44));
        store_quarters(p + stride, stride, _mm512_shuffle_ps(ab0, cd0, 0xEE));
        store_quarters(p + 2 * stride, stride, _mm512_shuffle_ps(ab1, cd1, 0x44));
        store_quarters(p + 3 * stride, stride, _mm512_shuffle_ps(ab1, cd1, 0xEE));
    }
    static void stream(float* to, const float* from, std::size_t count)
    {
        for (std::size_t i = 0; i < count; i += 16)
            _mm512_stream_ps(to + i, _mm512_load_ps(from + i));
    }
    static void end_of_stream() { _mm_sfence(); }

private:
    /// Every fourth cell.
    static void store_quarters(float* p, int stride, Float v)
    {
        _mm_store_ps(p, _mm512_castps512_ps128(v));
        _mm_store_ps(p + 4 * stride, _mm512_extractf32x4_ps(v, 1));
        _mm_store_ps(p + 8 * stride, _mm512_extractf32x4_ps(v, 2));
        _mm_store_ps(p + 12 * stride, _mm512_extractf32x4_ps(v, 3));
    }
};

} // namespace
} // namespace lumisweep

#include "lumisweep/sampling/joint_kernel_impl.h"

namespace lumisweep {
const JointKernel joint_kernel_avx512 = {"avx512", build};
} // namespace lumisweep
#endif
