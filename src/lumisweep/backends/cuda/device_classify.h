// Classification (visibility/extinction_grid.h) on the device.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device_extinction.h"
#include "lumisweep/backends/cuda/device_transfer_function.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Keeps tables between edits, so that an edit uploads no more than its transfer function.
class DeviceClassify {
public:
    /// Classifies a level in both layouts, as classify() does to the byte. Of `volume` only what describes it is read;
    /// its voxels lie on the device, x fastest, aligned to their type and with ScalarGrid::readable_behind readable
    /// bytes behind them. `on_device` holds `tf`. Nothing is stored of an empty volume. Throws Error for a level
    /// outside of 0 … 13.
    void classify(DeviceExtinction& extinction, const void* voxels_on_device, const ScalarGrid& volume,
                  const RawRange& range, const TransferFunction& tf, const DeviceTransferFunction& on_device,
                  int mip_level, const Stream& stream);
    std::uint64_t bytes() const { return table_.bytes() + dither_.bytes(); }

private:
    DeviceArray<std::int32_t> table_;   ///< steps by raw value, from the smallest one that occurs
    DeviceArray<std::uint16_t> dither_; ///< dither_numbers()
};

} // namespace lumisweep::LUMISWEEP_CUDA
