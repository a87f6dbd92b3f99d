// Visibility sweeps: journal paper sections 6 (sweeping plane) and 8 (sweep-space filter).
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

struct SweepKernels;

/// What a sweep cost.
struct SweepStats {
    /// Processor time over all threads: layouts (where rays run, pairs of voxel rows), march, lookup with exponential,
    /// filter.
    double layout_s = 0.0, march_s = 0.0, lookup_s = 0.0, filter_s = 0.0;
    double total_s = 0.0;          ///< elapsed
    std::uint64_t voxel_steps = 0; ///< rays × slices; what is empty is counted, but not marched
    std::uint64_t bytes_read = 0;  ///< of the level, by all groups
    int mip_level = 0;             ///< of the extinction grid that was marched
    int rays = 0;                  ///< rays along the longer side of the sweep plane

    /// Adds what was done; the level and the rays are those of `part`.
    SweepStats& operator+=(const SweepStats& part);
};

/// The mip level (rays 2^level voxels apart) that `rays` means for this volume; 0 ("auto") takes the default.
int sweep_mip_level(Vec3i volume_size, int rays);

/// The grid's directions in groups that cost least when they are swept together: what they share is done once, and
/// opposite directions come out of one march.
std::vector<std::vector<int>> sweep_groups(const ExtinctionGrid& extinction, const VisibilitySettings& settings);

/// Sweeps the given directions (Morton indices) of `grid`, which must be of the volume's geometry; all of them when
/// `directions` is empty. Bias: none in the image; V itself is off by what tests/visibility allow.
/// Each direction's V is the same whatever else is swept with it, on any number of threads and instruction set. When
/// *cancel becomes true, returns early: the directions not yet done keep their old V or have a part of the new.
SweepStats sweep_visibility(VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                            std::span<const int> directions = {}, const std::atomic<bool>* cancel = nullptr);

/// Likewise with the given kernels (sweep_kernel.h) in place of the widest that this machine has.
SweepStats sweep_visibility_with(const SweepKernels& kernels, VisibilityGrid& grid, const ExtinctionGrid& extinction,
                                 const VisibilitySettings& settings, std::span<const int> directions = {},
                                 const std::atomic<bool>* cancel = nullptr);

} // namespace lumisweep
