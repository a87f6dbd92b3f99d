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
};

} // namespace

void classify_block_avx2(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch)
{
    classify_block_lanes<Avx2Float, GatheredSegments<Avx2Float>>(job, slice, first_row, scratch);
}

} // namespace lumisweep
#endif
