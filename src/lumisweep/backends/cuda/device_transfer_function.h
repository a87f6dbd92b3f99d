// The transfer function in the device's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/staged_array.h"
#include "lumisweep/volume/transfer_function_view.h"
#include "lumisweep/volume/transfer_points.h"

namespace lumisweep {
class TransferFunction;
}

namespace lumisweep::LUMISWEEP_CUDA {

/// The renderer's tables and the points in double precision: a few KB, and all that an edit uploads.
class DeviceTransferFunction {
public:
    void upload(const TransferFunction& tf, const Stream& stream);

    /// As TransferFunction::view(). Valid until the next upload.
    TransferFunctionView view(double slope, double intercept) const;
    TransferPointsView points() const { return points_; }
    std::uint64_t bytes() const { return memory_.bytes(); }

private:
    StagedArray<std::byte> memory_; ///< points, then the table, then the hints
    TransferFunctionView view_;
    TransferPointsView points_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
