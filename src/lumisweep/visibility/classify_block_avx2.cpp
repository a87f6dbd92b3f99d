#if defined(__x86_64__)
#include "lumisweep/math/lanes_avx2.h"
#include "lumisweep/visibility/classify_block_impl.h"

namespace lumisweep {
namespace {

template <>
struct ClassifyLanes<Avx2Float> {
    LUMISWEEP_HD static Avx2Int widened(const std::uint8_t* raw)
    {
        return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(raw)));
    }
    LUMISWEEP_HD static Avx2Int widened(const std::uint16_t* raw)
    {
        return _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(raw)));
    }
    LUMISWEEP_HD static Avx2Int widened(const std::int16_t* raw)
    {
        return _mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(raw)));
    }
    LUMISWEEP_HD static void transpose_64(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to,
                                          std::size_t to_stride)
    {
        transpose(from, from_stride, to, to_stride, 64, 64);
    }
    LUMISWEEP_HD static bool any_of_64(const std::uint8_t* bytes)
    {
        const __m256i any = _mm256_or_si256(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes)),
                                            _mm256_loadu_si256(reinterpret_cast<const __m256i*>(bytes + 32)));
        return _mm256_testz_si256(any, any) == 0;
    }
    /// Whole cache lines are streamed: they need not be read to be written.
    LUMISWEEP_HD static void copy(std::uint8_t* to, const std::uint8_t* from, std::size_t count)
    {
        const std::size_t before = -reinterpret_cast<std::uintptr_t>(to) % 64, head = before < count ? before : count;
        __builtin_memcpy(to, from, head);
        std::size_t i = head;
        for (; i + 64 <= count; i += 64)
            for (std::size_t half : {0, 32})
                _mm256_stream_si256(reinterpret_cast<__m256i*>(to + i + half),
                                    _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from + i + half)));
        __builtin_memcpy(to + i, from + i, count - i);
    }
};

} // namespace

void classify_block_avx2(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch)
{
    classify_block_lanes<Avx2Float, GatheredSegments<Avx2Float>>(job, slice, first_row, scratch);
    _mm_sfence(); // streamed lines are visible to whoever waits for this task
}

} // namespace lumisweep
#endif
