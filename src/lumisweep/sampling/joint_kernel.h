// The inner loop of the joint grid, compiled once per instruction set (joint_kernel_*.cpp) and chosen at start-up. All
// give the same bits: every operation is rounded by itself.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lumisweep {

/// Cells are worked on in blocks of this many.
inline constexpr std::size_t joint_block = 16;

/// Plain loads and stores, or stores past the caches for grids that these cannot hold.
enum class JointStores { cached, streaming };

/// A product in the making: visibility and light in, nodes and roots out, all in JointView's layout.
struct JointWork {
    const std::uint8_t* const* visibility = nullptr; ///< [direction] its cells
    const float* light = nullptr;                    ///< [direction] factor
    float epsilon = 0.0F;
    int directions = 0; ///< a power of 4, 4 … 1024
    int node_count = 0; ///< per cell
    float* nodes = nullptr;
    float* root = nullptr;
    JointStores stores = JointStores::cached;
};

struct JointKernel {
    const char* name;
    /// Cells first … last − 1; `first` is a multiple of joint_block. No byte beyond `last` is read.
    void (*build)(const JointWork& work, std::size_t first, std::size_t last);
};

extern const JointKernel joint_kernel_baseline;
#if defined(__x86_64__)
extern const JointKernel joint_kernel_avx2;
extern const JointKernel joint_kernel_avx512;
#endif

/// The kernels that this machine runs, widest first; the list ends with nullptr.
const JointKernel* const* joint_kernels();

} // namespace lumisweep
