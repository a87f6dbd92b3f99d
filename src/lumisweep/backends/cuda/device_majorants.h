// MajorantGrid (volume/majorant_grid.h) in the device's memory.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/backends/cuda/device_bounds.h"
#include "lumisweep/backends/cuda/majorant_kernels.h"
#include "lumisweep/volume/majorant_view.h"
#include "lumisweep/volume/transfer_points.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Made on the device once a transfer function, equal to the host's to the bit. Memory is kept for the next edit.
class DeviceMajorants {
public:
    /// The transfer function's points stand in the device's memory. Waits.
    void build(const DeviceBounds& bounds, const TransferPointsView& transfer_function, const Stream& stream);

    /// With pointers into the device's memory.
    MajorantView view() const { return view_; }
    std::uint64_t bytes() const;

private:
    DeviceArray<std::uint8_t> blocks_, smallest_;
    DeviceArray<CodeRow> cells_;
    DeviceArray<std::uint8_t> distances_[2]; // while empty space is measured
    DeviceArray<double> extinction_;         // of the table's entries
    DeviceArray<std::uint8_t> codes_;        // the table
    DeviceArray<FoundInBlocks> found_;
    MajorantView view_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
