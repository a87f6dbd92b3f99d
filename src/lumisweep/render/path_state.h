// The state of a path between stages.
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/random.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Lanes of paths. A path is on its camera segment (towards the first collision) or on its shadow segment (towards the
/// light). Rays are kept in voxel space, p_voxel(t) = origin + t · direction with t in world units from the segment's
/// start.
template <class F>
struct PathState {
    Vec3<F> origin, direction;
    F t;
    F optical_depth;   ///< left until the next tentative collision
    F transmittance;   ///< ratio tracking's estimate so far
    Vec3<F> weight;    ///< shadow: ρ L / (4π pdf k). camera: see below
    int_of<F> cell;    ///< majorant cell, packed by stage::pack_cell()
    int_of<F> pixel;   ///< index in the image
    int_of<F> segment; ///< 0 camera, 1 shadow
    int_of<F> dimension;
    RandomKey<F> key;

    // Camera segments have no weight and keep in its place:
    LUMISWEEP_HD const F& lens_to_box() const { return weight.x; }    ///< distance from the lens to the segment's start
    LUMISWEEP_HD const F& collision_rest() const { return weight.y; } ///< in (0, 1]; see collisions_before()
    LUMISWEEP_HD const F& transmittance_before() const { return weight.z; } ///< before the last tentative collision

    /// Calls f on every field, for structure-of-arrays storage; all are 4 bytes a lane.
    template <class Function>
    LUMISWEEP_HD void for_each_field(Function&& f)
    {
        f(origin.x), f(origin.y), f(origin.z), f(direction.x), f(direction.y), f(direction.z);
        f(t), f(optical_depth), f(transmittance), f(weight.x), f(weight.y), f(weight.z);
        f(cell), f(pixel), f(segment), f(dimension), f(key.k0), f(key.k1);
    }
    static constexpr int field_count = 18;
};

inline constexpr int camera_segment = 0;
inline constexpr int shadow_segment = 1;

} // namespace lumisweep
