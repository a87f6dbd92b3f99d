// What a volume's values look like: what presets are chosen and scaled by, and what `lumisweep info` prints.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

struct ValueStatistics {
    double min = 0.0, max = 0.0; ///< of the finite voxels; 0 when there are none
    std::uint64_t count = 0;     ///< finite voxels
    std::uint64_t non_finite = 0;
    bool integers = true;                 ///< integer voxel type
    int bits = 8;                         ///< of the voxel type
    double bin_width = 1.0;               ///< data units
    std::vector<std::uint64_t> histogram; ///< bin b counts values in min + [b, b+1) · bin_width; the last includes max

    /// The value below which `fraction` of the finite voxels lie, to one bin's width.
    double percentile(double fraction) const;
    /// The same over the voxels at or above `floor`.
    double percentile_above(double floor, double fraction) const;
    /// Share of the finite voxels that are exactly in the first bin: the empty background of a simulation or a masked
    /// scan.
    double lowest_share() const;
    /// The value that best parts background and content (Otsu 1979, "A Threshold Selection Method from Gray-Level
    /// Histograms"), after the lowest bin has been left out.
    double background_threshold() const;
};

/// One pass over the voxels for the range, one for at most `bins` bins (fewer for short integer ranges).
ValueStatistics value_statistics(const ScalarGrid& volume, int bins = 4096);

} // namespace lumisweep
