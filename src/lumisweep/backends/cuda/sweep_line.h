// The lines of a sweep as kernels read them: plain data, filled once for a volume's shape and settings
// (device_sweep_plan.h).
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/visibility/sweep_cells.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// One slice of a line, or its part between two lookups: what SweepPiece says of it, and which rays count it.
struct alignas(16) MarchPiece {
    std::int32_t slice;
    std::int32_t voxel_u, voxel_v; ///< on the low side of ray 0
    std::uint32_t weights;         ///< bytes: of the voxels (v, u), (v, u + 1), (v + 1, u), (v + 1, u + 1)
    std::int32_t first_u, last_u, first_v, last_v; ///< the rays that count it, less first_ray: [first, last)
};
static_assert(sizeof(MarchPiece) == 32);

/// The line's rays and cells along one axis of the plane.
struct LineAxis {
    RayAxis rays;
    std::int32_t ray_count;
    std::int32_t ranges; ///< where LinesView::begin and end are for ray 0
    std::int32_t cells;
    double cell_side, cell_side_world; ///< level voxels, world units
};

struct LineView {
    std::int32_t axis, slices; ///< as in SweepGeometry
    std::int32_t cells;        ///< slices of cells
    double cell_side, slice_world;
    LineAxis u, v;
    std::int32_t first_piece, piece_count; ///< in LinesView::pieces
    std::int32_t first_slab;               ///< in LinesView::slab_begin, which has cells + 2 for it
    /// For V towards the low and towards the high side of the axis: the direction that it is (a part of), −1 if none
    /// wants it, and which of the line's two directions that is when lines are averaged.
    std::int32_t direction[2], slot[2];

    LUMISWEEP_HD const LineAxis& plane_axis(int which) const { return which == 0 ? u : v; }
};

struct LinesView {
    const LineView* lines;
    const MarchPiece* pieces;
    const std::int32_t* slab_begin;  ///< SweepSlabs::begin
    const std::int32_t *begin, *end; ///< [ray] the slices that it counts, of all lines and axes
};

/// A block of the march takes this many rays along u and v of a line. The last are the first of the next tile: a cell
/// belongs to the tile with the rays on its low sides, and finds those on its high sides there, too.
inline constexpr int tile_u = 128, tile_v = 32;
inline constexpr int tile_step_u = tile_u - 1, tile_step_v = tile_v - 1;

LUMISWEEP_HD int tile_step(int plane_axis) { return plane_axis == 0 ? tile_step_u : tile_step_v; }
/// Tiles for that many rays, of which the last can only be on a cell's high side.
LUMISWEEP_HD int tiles_of(int rays, int step) { return (rays - 1 + step - 1) / step; }

} // namespace lumisweep::LUMISWEEP_CUDA
