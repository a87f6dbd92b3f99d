#define LUMISWEEP_SWEEP_KERNELS sweep_kernels_baseline
#define LUMISWEEP_SWEEP_KERNELS_NAME "baseline"
#include "lumisweep/visibility/sweep_kernel_impl.h"

namespace lumisweep {

const SweepKernels& sweep_kernels()
{
#if defined(__x86_64__)
    static const SweepKernels& best = []() -> const SweepKernels& {
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
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
