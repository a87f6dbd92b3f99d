// The classified volume that sweeps march through: extinction per level voxel in 8 bits, one mip level.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// Extinction = scale · stored, in 1/world unit, at the centres of level voxels. Rounding is dithered, so that thin
/// media below half a step survive on average. Voxels are classified before interpolation (the renderer interpolates
/// first), which is why visibility from here only steers sampling.
struct ExtinctionGrid {
    /// Voxels of a row outside of [first, last) are empty; whole lines of 64 where the row has them.
    struct Filled {
        std::int32_t first, last;
    };

    Vec3i volume_size{0, 0, 0};            ///< finest voxels
    Affine3d world_from_voxel;             ///< of the finest level
    int mip_level = 0;                     ///< a level voxel is 2^mip_level finest voxels a side
    Vec3i size{0, 0, 0};                   ///< level voxels: ceil(volume_size / 2^mip_level)
    float scale = 0.0F;                    ///< extinction of one stored step; 0 for an empty volume
    AlignedArray<std::uint8_t> stored;     ///< [z][y][x], x fastest
    AlignedArray<std::uint8_t> transposed; ///< [x][z][y], y fastest: for sweeps along x; empty unless asked for
    std::vector<Filled> filled;            ///< [z][y], of the rows along x
    std::vector<Filled> filled_transposed; ///< [x][z], of those along y, if there is the transposed copy
    std::size_t bytes() const
    {
        return stored.bytes() + transposed.bytes() + (filled.size() + filled_transposed.size()) * sizeof(Filled);
    }
    /// What classifying a level of that size in both layouts takes, at most.
    static std::uint64_t bytes_needed(Vec3i size);
};

/// Which memory layouts a grid gets. Sweeps along x need the transposed copy, those along y and z do not.
enum class ExtinctionLayouts { straight, with_transposed };

/// Averages the extinction of 2^mip_level finest voxels a side and rounds once. Finest voxels missing at an odd end
/// count as empty, so that extinction × length is kept; so do voxels that are not finite. `range` is raw_range(volume):
/// 255 steps are the largest extinction that the transfer function has in it. The result is the same for any number of
/// threads and every instruction set. Throws Error for a level outside of 0 … 13. When *cancel becomes true, returns
/// early with a grid that is of no use.
ExtinctionGrid classify(const ScalarGrid& volume, const RawRange& range, const TransferFunction& transfer_function,
                        int mip_level, ExtinctionLayouts layouts = ExtinctionLayouts::with_transposed,
                        const std::atomic<bool>* cancel = nullptr);

/// The same into a grid made before. Where the size is that of before, no memory is given back and taken anew, which is
/// 40 % of the time of the finest level. Returns false when cancelled.
bool classify_into(ExtinctionGrid& grid, const ScalarGrid& volume, const RawRange& range,
                   const TransferFunction& transfer_function, int mip_level, ExtinctionLayouts layouts,
                   const std::atomic<bool>* cancel = nullptr);

} // namespace lumisweep
