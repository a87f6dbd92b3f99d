// Where the rays of one direction run: journal paper section 6, equations (6) and (7), in voxel index space.
//
// Rays start on an axis-aligned face of the box, the one that the direction points to, one ray per voxel of the marched
// level, and run against the direction. `depth` counts slices from that face. In the plane, u and v are the other two
// axes; ray (i, m) is at u = i + 1/2 + slope_u · depth, v = m + 1/2 + slope_v · depth. It is inside of the box while
// both are, so rays are numbered from where some depth needs them, which may be negative.
#pragma once

#include <vector>

#include "lumisweep/math/vec.h"

namespace lumisweep {

/// The depths at which the rays of one column (or row) pass the low and the high side of the box along u (or v).
struct SidePass {
    double enter, leave;
};

struct SweepAxis {
    int size;      ///< voxels of the level
    double slope;  ///< voxels per slice, −1 … 1
    int first_ray; ///< number of the first ray
    int ray_count;
    std::vector<SidePass> passes; ///< [ray − first_ray]

    /// For a ray at `x` voxels from the voxel centres' origin on the start face; need not be a whole number.
    SidePass pass(double x) const;
};

struct SweepGeometry {
    int axis;            ///< the sweep's: 0, 1, 2
    bool from_high_side; ///< the start face is the one at the high end of the axis
    int slices;
    double slice_world; ///< world length of a ray inside of one slice
    SweepAxis u, v;

    /// Ties between the axes go to y, then to z: x needs a transposed volume.
    SweepGeometry(Vec3i level_size, const Affine3d& level_from_world, const Vec3d& w_world);

    /// Depth of a plane at `p` voxels along the axis.
    double depth_of(double p) const { return from_high_side ? slices - p : p; }
    /// The voxel slice at whole depths [j, j + 1).
    int slice_at(int j) const { return from_high_side ? slices - 1 - j : j; }
};

/// One piece of a slice, and what is constant over it.
struct SweepStep {
    struct Window {
        int shift;                       ///< voxel on a ray's low side = ray + shift
        double fraction;                 ///< towards the next voxel
        int first, last;                 ///< rays inside of the box all the way: [first, last), of ray numbers
        int touched_first, touched_last; ///< rays inside of it anywhere
    };
    int slice;
    double begin, end; ///< depth
    Window u, v;

    SweepStep(const SweepGeometry& geometry, int slice_depth, double begin_depth, double end_depth);
};

/// The pieces of slices between two depths.
std::vector<SweepStep> sweep_steps(const SweepGeometry& geometry, double begin_depth, double end_depth);

} // namespace lumisweep
