// The range of raw values that a volume holds.
#pragma once

#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

/// The smallest and largest finite raw (not yet scaled) value; low > high where no voxel is finite. Exact: voxels of 8
/// and 16 bits are whole numbers in single precision.
struct RawRange {
    float low = 0.0F, high = -1.0F;
    bool empty() const { return !(low <= high); }
};

/// Reads every voxel, so take it once a volume, not once a transfer function.
RawRange raw_range(const ScalarGrid& volume);

} // namespace lumisweep
