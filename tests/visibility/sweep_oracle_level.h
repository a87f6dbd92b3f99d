// What the slow sweeps know of an ExtinctionGrid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::test {

inline int across_u(int axis) { return axis == 0 ? 1 : 0; }
inline int across_v(int axis) { return axis == 2 ? 1 : 2; }

/// The level's voxels and the cells on it. `axis` is the sweep's, u and v are across it.
struct Level {
    const ExtinctionGrid& extinction;
    Vec3i cells;
    Vec3d cell_sides; // level voxels
    Affine3d world_from_level, level_from_world;

    Level(const ExtinctionGrid& grid, int voxels_per_cell)
        : extinction(grid), cells(VisibilityGrid::cells_of(grid.volume_size, voxels_per_cell)),
          world_from_level(grid.world_from_voxel)
    {
        const double side = std::ldexp(1.0, grid.mip_level);
        for (Vec3d& column : world_from_level.column)
            column = column * side;
        level_from_world = inverse(world_from_level);
        cell_sides = {grid.volume_size.x / side / cells.x, grid.volume_size.y / side / cells.y,
                      grid.volume_size.z / side / cells.z};
    }

    double voxel_side_world(int axis) const { return length(world_from_level.column[static_cast<std::size_t>(axis)]); }

    /// Edge voxels repeated.
    int voxel(int axis, int u, int v, int w) const
    {
        const Vec3i& size = extinction.size;
        const auto inside = [&](int a, int i) { return std::clamp(i, 0, component(size, a) - 1); };
        std::size_t at[3];
        at[axis] = static_cast<std::size_t>(inside(axis, w));
        at[across_u(axis)] = static_cast<std::size_t>(inside(across_u(axis), u));
        at[across_v(axis)] = static_cast<std::size_t>(inside(across_v(axis), v));
        const std::size_t x = static_cast<std::size_t>(size.x), y = static_cast<std::size_t>(size.y);
        return extinction.stored[(at[2] * y + at[1]) * x + at[0]];
    }

    std::size_t cell_index(int axis, int u, int v, int w) const
    {
        std::size_t at[3];
        at[axis] = static_cast<std::size_t>(w);
        at[across_u(axis)] = static_cast<std::size_t>(u);
        at[across_v(axis)] = static_cast<std::size_t>(v);
        return (at[2] * static_cast<std::size_t>(cells.y) + at[1]) * static_cast<std::size_t>(cells.x) + at[0];
    }
    std::size_t cell_count() const
    {
        return static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) *
               static_cast<std::size_t>(cells.z);
    }
};

} // namespace lumisweep::test
