#include <cstddef>
#include <cstdint>

namespace lumisweep {
namespace {

/// Vectors of the compiler's own, for any processor.
struct Cells {
    using Float __attribute__((vector_size(16), aligned(4), may_alias)) = float;
    static constexpr int width = 4;

    static Float load(const std::uint8_t* p)
    {
        return Float{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]),
                     static_cast<float>(p[3])};
    }
    static Float load(const float* p) { return *reinterpret_cast<const Float*>(p); }
    static void store(float* p, Float v) { *reinterpret_cast<Float*>(p) = v; }
    static void store_transposed(float* p, int stride, Float a, Float b, Float c, Float d)
    {
        const Float ab0 = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab1 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
        const Float cd0 = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd1 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
        store(p, __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5));
        store(p + stride, __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7));
        store(p + 2 * stride, __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5));
        store(p + 3 * stride, __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7));
    }
    static void stream(float* to, const float* from, std::size_t count)
    {
        __builtin_memcpy(to, from, count * sizeof(float));
    }
    static void end_of_stream() {}
};

} // namespace
} // namespace lumisweep

#include "lumisweep/sampling/joint_kernel_impl.h"

namespace lumisweep {

const JointKernel joint_kernel_baseline = {"baseline", build};

const JointKernel* const* joint_kernels()
{
    static const auto kernels = [] {
        struct List {
            const JointKernel* kernel[4] = {};
        } list;
        int count = 0;
#if defined(__x86_64__)
        __builtin_cpu_init();
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
            list.kernel[count++] = &joint_kernel_avx512;
        if (__builtin_cpu_supports("avx2"))
            list.kernel[count++] = &joint_kernel_avx2;
#endif
        list.kernel[count++] = &joint_kernel_baseline;
        return list;
    }();
    return kernels.kernel;
}

} // namespace lumisweep
