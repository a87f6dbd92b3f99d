// What bounds of a volume stand for, as the host finds it before and after it looks at every voxel.
#pragma once

#include "lumisweep/volume/cell_bounds.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

/// All that bounds of cells are made with. Of voxels in single precision the volume's range is needed, and some voxels
/// are looked at; of others `range` is left out.
WholeBounds begin_bounds(const ScalarGrid& volume, const RawRange& range = {});

/// The same once there are bounds of all cells, `range` those of all of them together; `non_finite`: some voxel is.
WholeBounds end_bounds(const WholeBounds& begun, VoxelType type, const CellBounds& range, bool non_finite);

} // namespace lumisweep
