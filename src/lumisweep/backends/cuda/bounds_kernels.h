// Kernels that look at every voxel of a volume for its bounds (volume/cell_bounds.h), as the host launches them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/volume/cell_bounds.h"
#include "lumisweep/volume/voxel_type.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Neighbouring cells of a block along x, read and written at once.
struct alignas(16) BoundsRow {
    CellBounds cell[majorant_block];
};
inline constexpr int rows_of_block = majorant_block * majorant_block;

/// What all blocks of threads find together, in the device's memory; begins as it stands here.
struct FoundInVoxels {
    std::uint32_t low = 0xffffffffU, high = 0; ///< of bounds; low > high where none are
    /// The same of finite voxels in single precision, as in_order() numbers them.
    std::uint32_t finite_low = 0xffffffffU, finite_high = 0;
    std::uint32_t non_finite = 0; ///< whether some voxel is
};

/// Numbers in the order of the floats that they stand for; −0 lies before 0.
LUMISWEEP_HD std::uint32_t in_order(float v)
{
    const auto bits = static_cast<std::uint32_t>(as_int(v));
    return bits ^ (bits >> 31 != 0 ? 0xffffffffU : 0x80000000U);
}
LUMISWEEP_HD float from_order(std::uint32_t number)
{
    return as_float(static_cast<std::int32_t>(number ^ (number >> 31 != 0 ? 0x80000000U : 0xffffffffU)));
}

/// The range of finite voxels, and whether all are.
void find_finite_range(const float* voxels, std::size_t count, FoundInVoxels* found, const Stream& stream);

/// Bounds of all cells and blocks, and of them together; those of cells beyond the volume are empty. Of `bounds` only
/// what begin_bounds() gives is read. Memory: voxels [nz][ny][nx]; cells [block][z][y] rows; blocks [bz][by][bx].
void find_cell_bounds(VoxelType type, const void* voxels, const WholeBounds& bounds, const Vec3i& block_grid,
                      BoundsRow* cells, CellBounds* blocks, FoundInVoxels* found, const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
