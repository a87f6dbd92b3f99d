#include "lumisweep/visibility/classify_block_impl.h"

namespace lumisweep {
namespace {

template <>
struct ClassifyLanes<float> {
    template <class T>
    LUMISWEEP_HD static std::int32_t widened(const T* raw)
    {
        return *raw;
    }
    LUMISWEEP_HD static void transpose_64(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to,
                                          std::size_t to_stride)
    {
        transpose(from, from_stride, to, to_stride, 64, 64);
    }
    LUMISWEEP_HD static bool any_of_64(const std::uint8_t* bytes)
    {
        std::uint64_t any = 0;
        for (int i = 0; i < 64; i += 8) {
            std::uint64_t eight;
            __builtin_memcpy(&eight, bytes + i, 8);
            any |= eight;
        }
        return any != 0;
    }
    LUMISWEEP_HD static void copy(std::uint8_t* to, const std::uint8_t* from, std::size_t count)
    {
        __builtin_memcpy(to, from, count);
    }
};

} // namespace

void classify_block_baseline(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch)
{
    classify_block_lanes<float, GatheredSegments<float>>(job, slice, first_row, scratch);
}

ClassifyBlock widest_classify_block()
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        return classify_block_avx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return classify_block_avx2;
#endif
    return classify_block_baseline;
}

} // namespace lumisweep
