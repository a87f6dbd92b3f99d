// Visibility sweeps: journal paper sections 6 (sweeping plane) and 8 (sweep-space filter).
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

/// What a sweep cost; seconds are wall-clock.
struct SweepStats {
    double march_s = 0.0, lookup_s = 0.0, filter_s = 0.0, total_s = 0.0; ///< parts summed over threads; total elapsed
    std::uint64_t voxel_steps = 0;
    int mip_level = 0; ///< of the extinction grid that was marched
    int rays = 0;      ///< rays along the longer side of the sweep plane
};

/// The mip level (rays 2^level voxels apart) that `rays` means for this volume; 0 ("auto") takes the default.
int sweep_mip_level(Vec3i volume_size, int rays);

/// Sweeps the given directions (Morton indices) of `grid`, which must be of the volume's geometry; all of them when
/// `directions` is empty. Bias: none in the image; V itself is off by what tests/visibility allow.
/// When *cancel becomes true, returns early: the directions not yet done keep their old V.
SweepStats sweep_visibility(VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                            std::span<const int> directions = {}, const std::atomic<bool>* cancel = nullptr);

} // namespace lumisweep
