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
    F transmittance;   ///< shadow: ratio tracking's estimate so far. camera: unused (1)
    Vec3<F> weight;    ///< shadow: ρ L / (4π pdf). camera: x holds the distance from the lens to the segment's start
    int_of<F> cell;    ///< majorant cell, packed by stage::pack_cell()
    int_of<F> pixel;   ///< index in the image
    int_of<F> segment; ///< 0 camera, 1 shadow
    int_of<F> dimension;
    RandomKey<F> key;

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
