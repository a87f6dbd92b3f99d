// Where the rays of one direction run: journal paper section 6, equations (6) and (7), in voxel index space.
//
// Rays start on the box's low face across the sweep's axis, one per voxel of the marched level, and run upwards: along
// the direction or against it, which is the same line. `depth` counts slices from that face. In the plane, u and v are
// the other two axes; ray (i, m) is at u = i + 1/2 + slope_u · depth, v = m + 1/2 + slope_v · depth. It is inside of
// the box while both are, so rays are numbered from where some depth needs them, which may be negative.
//
// The march counts optical depth in whole numbers: 1/127 of a stored extinction step × one slice. A slice adds what the
// four voxels around a ray's middle in it hold, times four weights that are the same for the whole slice and sum to
// 127. A ray counts a slice wholly if it is inside of the box anywhere in it, with the edge voxels repeated beyond the
// box; lookups divide by the slices counted and multiply by the length inside, so the mean extinction is what is kept.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lumisweep/math/vec.h"
#include "lumisweep/visibility/sweep_cells.h"

namespace lumisweep {

struct SweepAxis : RayAxis {
    int ray_count;
    std::vector<int> begin, end;  ///< [ray − first_ray]: the slices that it counts, [begin, end)
    std::vector<int> first, last; ///< [slice]: the rays that count it, [first, last), less first_ray

    SweepAxis(int voxels, double slope_per_slice, int slices);
};

/// One slice, or its part between two lookups, and what is constant over it.
struct SweepPiece {
    int slice;
    int shift_u, shift_v;  ///< voxel on a ray's low side = ray + shift
    std::int8_t weight[4]; ///< of the voxels (v, u), (v + 1, u), (v, u + 1), (v + 1, u + 1)
};

/// A whole line's pieces, cut at the slices of cells.
struct SweepSlabs {
    std::vector<SweepPiece> pieces;
    std::vector<int> begin;     ///< [slab]: its first piece; one slab up to each lookup and one for the rest behind it
    std::vector<double> depths; ///< [slice of cells]

    std::span<const SweepPiece> slab(int index) const;
};

/// A direction's axis and shear; w and −w have the same, but for the side that they point to.
struct SweepLine {
    int axis;                ///< the sweep's: 0, 1, 2
    bool towards_high_side;  ///< whether w points to the high side, so that its rays come in there
    double slice_world;      ///< world length of a ray inside of one slice
    double slope_u, slope_v; ///< voxels per slice, −1 … 1

    /// Ties between the axes go to y, then to z: x needs a transposed volume.
    SweepLine(const Affine3d& level_from_world, const Vec3d& w_world);
};

struct SweepGeometry : SweepLine {
    int slices;
    SweepAxis u, v;

    SweepGeometry(Vec3i level_size, const Affine3d& level_from_world, const Vec3d& w_world);

    /// The slices from one depth to another, cut there.
    std::vector<SweepPiece> pieces(double begin_depth, double end_depth) const;
    /// With `cells` slices of cells, `cell_side` level voxels apart.
    SweepSlabs slabs(int cells, double cell_side) const;
};

inline int u_axis_of(int axis) { return axis == 0 ? 1 : 0; }
inline int v_axis_of(int axis) { return axis == 2 ? 1 : 2; }

} // namespace lumisweep
