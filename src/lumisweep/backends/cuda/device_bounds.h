// BoundsGrid (volume/majorant_grid.h) in the device's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/bounds_kernels.h"
#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/volume/cell_bounds.h"
#include "lumisweep/volume/raw_range.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Made on the device once a volume, equal to the host's to the bit.
class DeviceBounds {
public:
    /// `voxels_on_device` are those of `volume`, of which the host looks at few, and only in single precision. Waits.
    void build(const void* voxels_on_device, const ScalarGrid& volume, const Stream& stream);

    const WholeBounds& whole() const { return whole_; }
    /// lumisweep::raw_range() of the volume.
    const RawRange& raw_range() const { return raw_range_; }
    std::size_t block_count() const { return blocks_.size(); }
    /// Memory: as in find_cell_bounds().
    const CellBounds* blocks() const { return blocks_.data(); }
    const BoundsRow* cells() const { return cells_.data(); }
    std::uint64_t bytes() const { return blocks_.bytes() + cells_.bytes(); }

private:
    DeviceArray<CellBounds> blocks_;
    DeviceArray<BoundsRow> cells_;
    WholeBounds whole_;
    RawRange raw_range_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
