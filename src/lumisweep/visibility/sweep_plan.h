// Which directions are marched together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lumisweep/math/vec.h"
#include "lumisweep/visibility/settings.h"

namespace lumisweep {

/// A line through the volume and the grid's directions (Morton indices) that want V along it; −1 where none does.
struct SweepPair {
    Vec3d w_world;
    int towards_low = -1, towards_high = -1; ///< to the low and the high side of the sweep's axis
};

/// Pairs of one sweep axis and one sense of the shear across rows: they share the pairs of voxel rows.
using SweepGroup = std::vector<SweepPair>;

/// One thread's work, in order. With oversampling all lines of two opposite texels, which are then averaged; else one
/// group, each of whose lines belongs to one texel.
struct SweepTask {
    std::vector<SweepGroup> groups;
    /// The directions written.
    std::vector<int> directions() const;
};

/// `directions` each once, none out of range. A direction gets the same V in whatever task it is.
std::vector<SweepTask> plan_sweeps(const Affine3d& level_from_world, const VisibilitySettings& settings,
                                   std::span<const int> directions, std::size_t largest_group);

/// Largest group that keeps a thread's memory within bounds and leaves work for `threads`, when that many directions
/// are swept.
std::size_t largest_sweep_group(Vec3i level_size, Vec3i cells, const VisibilitySettings& settings,
                                std::size_t directions, int threads);

/// Working memory of one line, in bytes, at most.
std::uint64_t sweep_pair_bytes(Vec3i level_size, Vec3i cells);

} // namespace lumisweep
