#if defined(__x86_64__)
#include "lumisweep/math/lanes_avx512.h"
#include "lumisweep/visibility/classify_block_impl.h"

namespace lumisweep {
namespace {

template <>
struct ClassifyLanes<Avx512Float> {
    LUMISWEEP_HD static Avx512Int widened(const std::uint8_t* raw)
    {
        return _mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(raw)));
    }
    LUMISWEEP_HD static Avx512Int widened(const std::uint16_t* raw)
    {
        return _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(raw)));
    }
    LUMISWEEP_HD static Avx512Int widened(const std::int16_t* raw)
    {
        return _mm512_cvtepi16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(raw)));
    }

    /// Each lane of 16 bytes as transpose_16, then the lanes.
    LUMISWEEP_HD static void transpose_64(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to,
                                          std::size_t to_stride)
    {
        __m512i part[4][16]; // [row / 16][column mod 16]: 16 rows of the columns 16 apart
        for (std::size_t group = 0; group < 4; ++group) {
            __m512i* a = part[group];
            __m512i b[16];
            for (std::size_t r = 0; r < 16; ++r)
                a[r] = _mm512_loadu_si512(from + (group * 16 + r) * from_stride);
            for (int twice = 0; twice < 2; ++twice) {
                zip(a, b);
                zip(b, a);
            }
        }
        for (std::size_t c = 0; c < 16; ++c) {
            const __m512i low0 = _mm512_shuffle_i64x2(part[0][c], part[1][c], 0x44);
            const __m512i low1 = _mm512_shuffle_i64x2(part[2][c], part[3][c], 0x44);
            const __m512i high0 = _mm512_shuffle_i64x2(part[0][c], part[1][c], 0xee);
            const __m512i high1 = _mm512_shuffle_i64x2(part[2][c], part[3][c], 0xee);
            std::uint8_t* line = to + c * to_stride;
            _mm512_storeu_si512(line, _mm512_shuffle_i64x2(low0, low1, 0x88));
            _mm512_storeu_si512(line + 16 * to_stride, _mm512_shuffle_i64x2(low0, low1, 0xdd));
            _mm512_storeu_si512(line + 32 * to_stride, _mm512_shuffle_i64x2(high0, high1, 0x88));
            _mm512_storeu_si512(line + 48 * to_stride, _mm512_shuffle_i64x2(high0, high1, 0xdd));
        }
    }

    LUMISWEEP_HD static bool any_of_64(const std::uint8_t* bytes)
    {
        const __m512i all = _mm512_loadu_si512(bytes);
        return _mm512_test_epi64_mask(all, all) != 0;
    }

    /// Whole cache lines are streamed: they need not be read to be written.
    LUMISWEEP_HD static void copy(std::uint8_t* to, const std::uint8_t* from, std::size_t count)
    {
        const std::size_t before = -reinterpret_cast<std::uintptr_t>(to) % 64, head = before < count ? before : count;
        copy_part(to, from, head);
        std::size_t i = head;
        for (; i + 64 <= count; i += 64)
            _mm512_stream_si512(reinterpret_cast<__m512i*>(to + i), _mm512_loadu_si512(from + i));
        copy_part(to + i, from + i, count - i);
    }

private:
    LUMISWEEP_HD static void zip(const __m512i* a, __m512i* b)
    {
        for (std::size_t r = 0; r < 8; ++r) {
            b[2 * r] = _mm512_unpacklo_epi8(a[r], a[r + 8]);
            b[2 * r + 1] = _mm512_unpackhi_epi8(a[r], a[r + 8]);
        }
    }
    LUMISWEEP_HD static void copy_part(std::uint8_t* to, const std::uint8_t* from, std::size_t count)
    {
        const __mmask64 bytes = (__mmask64{1} << count) - 1; // fewer than 64
        _mm512_mask_storeu_epi8(to, bytes, _mm512_maskz_loadu_epi8(bytes, from));
    }
};

/// The same segments and arithmetic as GatheredSegments; up to 16 segments are kept in registers and found by
/// bisection.
class RegisterSegments {
public:
    explicit RegisterSegments(const TransferFunctionView& tf) : gathered_(tf), few_(tf.stride <= 17)
    {
        const __mmask16 segments = static_cast<__mmask16>(few_ ? (1U << (tf.stride - 1)) - 1 : 0);
        knot_ = _mm512_mask_loadu_ps(_mm512_set1_ps(__builtin_inff()), segments, tf.table);
        extinction_ = _mm512_maskz_loadu_ps(segments, tf.table + tf.stride);
        slope_ = _mm512_maskz_loadu_ps(segments, tf.table + 2 * tf.stride);
    }
    LUMISWEEP_HD Avx512Float extinction(const Avx512Float& value) const
    {
        if (!few_)
            return gathered_.extinction(value);
        __m512i s = _mm512_setzero_si512();
        for (const int step : {8, 4, 2, 1}) {
            const __m512i next = _mm512_add_epi32(s, _mm512_set1_epi32(step));
            const __mmask16 reached = _mm512_cmp_ps_mask(value.v, _mm512_permutexvar_ps(next, knot_), _CMP_GE_OQ);
            s = _mm512_mask_mov_epi32(s, reached, next);
        }
        const Avx512Float offset = value - Avx512Float(_mm512_permutexvar_ps(s, knot_));
        return offset * Avx512Float(_mm512_permutexvar_ps(s, slope_)) +
               Avx512Float(_mm512_permutexvar_ps(s, extinction_));
    }

private:
    GatheredSegments<Avx512Float> gathered_;
    bool few_;
    __m512 knot_, extinction_, slope_;
};

} // namespace

void classify_block_avx512(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch)
{
    classify_block_lanes<Avx512Float, RegisterSegments>(job, slice, first_row, scratch);
    _mm_sfence(); // streamed lines are visible to whoever waits for this task
}

} // namespace lumisweep
#endif
