// What a sweep needs to know of the level that it marches and of the cells on it, wherever the voxels are.
#pragma once

#include "lumisweep/math/vec.h"
#include "lumisweep/visibility/settings.h"

namespace lumisweep {

struct SweepLevel {
    Vec3i size; ///< level voxels
    Affine3d level_from_world;
    Vec3d voxel_sides_world; ///< of the level's voxels
    Vec3i cells;
    Vec3d cell_sides; ///< level voxels

    /// volume_size and world_from_voxel are those of the finest level.
    SweepLevel(Vec3i volume_size, const Affine3d& world_from_voxel, int mip_level, Vec3i level_size, Vec3i cells);

    double cell_side(int axis) const { return component(cell_sides, axis); }
    double cell_side_world(int axis) const { return component(voxel_sides_world, axis) * cell_side(axis); }
};

/// Throws Error when a grid of that shape is not the one that `settings` mean for this volume, or the level not the one
/// to march.
void check_sweep(Vec3i grid_cells, int directions_per_side, Vec3i volume_size, int mip_level,
                 const VisibilitySettings& settings);

} // namespace lumisweep
