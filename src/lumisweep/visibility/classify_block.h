// The inner loops of classification, compiled once per instruction set (classify_block_*.cpp). Nothing is fused or
// reassociated, so every instruction set gives the same bits.
#pragma once

#include <atomic>
#include <cstdint>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/voxel_steps.h"

namespace lumisweep {

/// Rows of a block at most: long lines of the transposed layout, in a piece of the straight one that stays in the
/// second-level cache.
inline constexpr int classify_block_rows = 512;
/// Bytes from line to line of ClassifyScratch::lines: whole cache lines, and not a power of two of them.
inline constexpr int scratch_line = classify_block_rows + 64;

/// What all blocks share. Extinction counts in stored steps, in fixed point until it is dithered (voxel_steps.h).
struct ClassifyJob {
    const void* voxels;
    VoxelType type;
    Vec3i volume_size; ///< finest voxels
    int mip_level;
    /// u8, u16, i16: steps at table[raw] (raw may be negative), and raw values [empty_first, empty_last] where they are
    /// 0.
    const std::int32_t* table;
    std::int32_t empty_first, empty_last;
    FloatClassification floats;                ///< f32
    const std::uint16_t* dither;               ///< dither_numbers()
    Vec3i size;                                ///< level voxels
    std::uint8_t* stored;                      ///< [z][y][x]
    std::uint8_t* transposed;                  ///< [x][z][y], or null
    ExtinctionGrid::Filled* filled;            ///< [z][y]
    ExtinctionGrid::Filled* filled_transposed; ///< [block of the slice][x][z]: of the voxels in that block
};

/// Working memory of a task. What it holds before does not matter.
struct ClassifyScratch {
    std::int32_t* steps; ///< [2][finest voxels along x, rounded up to 16 and to a whole level voxel]
    std::uint64_t* sums; ///< [level voxels along x]
    std::uint8_t* lines; ///< [64][scratch_line]
};

/// Classifies rows first_row … first_row + classify_block_rows − 1 of level slice `slice`, as far as there are.
using ClassifyBlock = void (*)(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch);

void classify_block_baseline(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch);
#if defined(__x86_64__)
void classify_block_avx2(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch);
void classify_block_avx512(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch);
#endif

/// The widest instruction set of this machine.
ClassifyBlock widest_classify_block();

/// classify_into() with the given loops.
bool classify_with(ClassifyBlock block, ExtinctionGrid& grid, const ScalarGrid& volume, const RawRange& range,
                   const TransferFunction& transfer_function, int mip_level, ExtinctionLayouts layouts,
                   const std::atomic<bool>* cancel = nullptr);

} // namespace lumisweep
