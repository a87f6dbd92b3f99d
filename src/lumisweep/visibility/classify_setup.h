// What classification works out once a transfer function, on whatever device the voxels are classified.
#pragma once

#include "lumisweep/visibility/voxel_steps.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// Voxels of a level: ceil(volume_size / 2^mip_level). Throws Error for a level outside of 0 … 13.
Vec3i level_size(const Vec3i& volume_size, int mip_level);

/// Extinction of one stored step: 255 of them are the largest that the transfer function has within the volume's range.
double extinction_of_step(const ScalarGrid& volume, const RawRange& range, const TransferFunction& tf);

/// For float voxels where a stored step is `scale` > 0 of extinction. The empty values are the widest run of segments
/// that are 0 all over.
FloatClassification classification_of_floats(const ScalarGrid& volume, const TransferFunction& tf, double scale);

} // namespace lumisweep
