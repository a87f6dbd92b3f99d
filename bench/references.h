// What V should be at random cells, so that many sweeps of one volume can be held against the same numbers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::bench {

struct MeanAndError {
    double mean, error; ///< error: the standard error of the mean
};
MeanAndError mean_and_error(std::span<const double> values);

/// At each of `cells`, all directions of an n × n map, in Morton order.
struct References {
    std::vector<Vec3i> cells;
    std::vector<float> exact;    ///< at cell and texel centres, by the exact oracle on the classified volume
    std::vector<float> averaged; ///< over cell and texel: 512 stratified rays, one sample a voxel
};

/// `extinction` is the volume at full resolution, `grid` tells the geometry. The same for the same seed.
References make_references(const ExtinctionGrid& extinction, const VisibilityGrid& grid, int positions,
                           std::uint64_t seed);

/// Root mean squares with the standard errors that choosing cells at random leaves them.
struct GridErrors {
    double rms = 0.0, rms_error = 0.0, rms_averaged = 0.0, rms_averaged_error = 0.0;
};
GridErrors errors_of(const VisibilityGrid& grid, const References& references);

} // namespace lumisweep::bench
