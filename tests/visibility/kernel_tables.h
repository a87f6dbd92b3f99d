// The kernel tables that this machine can run, and random input for them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
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

inline int uniform(std::mt19937& random, int low, int high)
{
    return std::uniform_int_distribution<int>(low, high)(random);
}

template <class T>
std::vector<T> random_values(std::mt19937& random, int count, int low, int high)
{
    std::vector<T> list(static_cast<std::size_t>(count));
    std::generate(list.begin(), list.end(), [&] { return static_cast<T>(uniform(random, low, high)); });
    return list;
}

inline std::vector<float> random_floats(std::mt19937& random, int count, float low, float high)
{
    std::uniform_real_distribution<float> value(low, high);
    std::vector<float> list(static_cast<std::size_t>(count));
    std::generate(list.begin(), list.end(), [&] { return value(random); });
    return list;
}

/// Lengths about the widths of vectors, and others.
inline std::vector<int> awkward_counts()
{
    return {1, 2, 3, 7, 8, 15, 16, 17, 31, 32, 33, 47, 63, 64, 65, 127, 129, 200};
}

} // namespace lumisweep::test
