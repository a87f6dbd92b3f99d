// The classified volume that sweeps march through: extinction per voxel in 8 bits, and its mips.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// One level: extinction = scale · stored, in 1/world unit, at voxel centres. Rounding is dithered, so that thin media
/// below half a step survive on average. Level l has ceil(size / 2^l) voxels of 2^l × the finest voxel's sides.
struct ExtinctionGrid {
    Vec3i size{0, 0, 0};
    AlignedArray<std::uint8_t> stored;
};

/// Classified before interpolation (the renderer interpolates first), which is why its visibility only steers sampling.
struct ExtinctionPyramid {
    Affine3d world_from_voxel; ///< of the finest level
    float scale = 0.0F;        ///< extinction of stored = 1; 0 for an empty volume
    std::vector<ExtinctionGrid> levels;
    std::size_t bytes() const;
};

/// Classifies every voxel and builds levels 0 … mip_level. Non-finite voxels are empty.
ExtinctionPyramid classify(const ScalarGrid& volume, const TransferFunction& transfer_function, int mip_level);

} // namespace lumisweep
