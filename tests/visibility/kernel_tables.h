// The kernel tables that this machine can run.
#pragma once

#include <vector>

#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep::test {

/// The baseline first.
inline std::vector<const SweepKernels*> runnable_kernels()
{
    std::vector<const SweepKernels*> kernels{&sweep_kernels_baseline};
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        kernels.push_back(&sweep_kernels_avx2);
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vnni"))
        kernels.push_back(&sweep_kernels_avx512);
#endif
    return kernels;
}

} // namespace lumisweep::test
