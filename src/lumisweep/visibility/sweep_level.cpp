#include "lumisweep/visibility/sweep_level.h"

#include <cmath>

#include "lumisweep/base/error.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

SweepLevel::SweepLevel(Vec3i volume_size, const Affine3d& world_from_voxel, int mip_level, Vec3i level_size,
                       Vec3i cell_counts)
    : size(level_size), cells(cell_counts)
{
    const double side = std::ldexp(1.0, mip_level); // finest voxels
    Affine3d world_from_level = world_from_voxel;
    for (Vec3d& column : world_from_level.column)
        column = column * side;
    level_from_world = inverse(world_from_level);
    voxel_sides_world = {length(world_from_level.column[0]), length(world_from_level.column[1]),
                         length(world_from_level.column[2])};
    cell_sides = {volume_size.x / side / cells.x, volume_size.y / side / cells.y, volume_size.z / side / cells.z};
}

void check_sweep(Vec3i grid_cells, int directions_per_side, Vec3i volume_size, int mip_level,
                 const VisibilitySettings& settings)
{
    settings.validate();
    require(directions_per_side == settings.directions &&
                grid_cells == VisibilityGrid::cells_of(volume_size, settings.cell),
            "visibility sweep: the grid was made for another volume or other visibility settings (make a new one)");
    const int level = sweep_mip_level(volume_size, settings.rays);
    require(level == mip_level,
            "visibility sweep: mip level {} is needed but level {} was classified (see sweep_mip_level)", level,
            mip_level);
}

} // namespace lumisweep
