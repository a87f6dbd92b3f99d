// The plain version, for every machine: what the wider ones must equal to the bit.
#include <cstddef>

#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {
namespace {

struct Rays {
    struct Weights {
        std::int16_t of[4];
    };
    std::int32_t sum[ray_block / 2];

    static Rays load(const std::int32_t* rays)
    {
        Rays r;
        for (int k = 0; k < ray_block / 2; ++k)
            r.sum[k] = rays[k];
        return r;
    }
    void store(std::int32_t* rays) const
    {
        for (int k = 0; k < ray_block / 2; ++k)
            rays[k] = sum[k];
    }
    static Weights weights(const std::int8_t* weight) { return {{weight[0], weight[1], weight[2], weight[3]}}; }
    void add(const std::uint8_t* pairs, const Weights& weight)
    {
        for (int k = 0; k < ray_block / 2; ++k)
            sum[k] += pairs[4 * k] * weight.of[0] + pairs[4 * k + 1] * weight.of[1] + pairs[4 * k + 2] * weight.of[2] +
                      pairs[4 * k + 3] * weight.of[3];
    }
    void add_some(const std::uint8_t* pairs, const Weights& weight, std::uint32_t which)
    {
        for (int k = 0; k < ray_block / 2; ++k)
            if ((which >> k & 1U) != 0)
                sum[k] += pairs[4 * k] * weight.of[0] + pairs[4 * k + 1] * weight.of[1] +
                          pairs[4 * k + 2] * weight.of[2] + pairs[4 * k + 3] * weight.of[3];
    }
};

inline int store_lines(std::uint8_t*, const std::uint16_t*, int) { return 0; }
inline int stream_lines(float*, const float*, int) { return 0; }
inline void fence_lines() {}

} // namespace
} // namespace lumisweep

#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_baseline
#define LUMISWEEP_SWEEP_KERNELS_NAME "baseline"
#include "lumisweep/visibility/sweep_kernel_impl.h"

namespace lumisweep {

const SweepKernels& sweep_kernels()
{
#if defined(__x86_64__)
    static const SweepKernels& best = []() -> const SweepKernels& {
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vnni"))
            return sweep_kernels_avx512;
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
            return sweep_kernels_avx2;
        return sweep_kernels_baseline;
    }();
    return best;
#else
    return sweep_kernels_baseline;
#endif
}

} // namespace lumisweep
