#include "lumisweep/backends/cuda/device_transfer_function.h"

#include <span>
#include <vector>

#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceTransferFunction::upload(const TransferFunction& tf, const Stream& stream)
{
    view_ = tf.view(1.0, 0.0);
    points_ = tf.points_view();
    std::vector<std::byte> packed;
    const auto append = [&](const auto* first, int count) {
        const auto bytes = std::as_bytes(std::span(first, static_cast<std::size_t>(count)));
        packed.insert(packed.end(), bytes.begin(), bytes.end());
        return packed.size();
    };
    const std::size_t table = append(points_.points, points_.count);
    const std::size_t hints = append(view_.table, transfer_table_fields * view_.stride);
    append(view_.hints, view_.bin_count);
    memory_.upload(packed, "the transfer function", stream);
    points_.points = reinterpret_cast<const TransferPoint*>(memory_.data());
    view_.table = reinterpret_cast<const float*>(memory_.data() + table);
    view_.hints = reinterpret_cast<const std::int32_t*>(memory_.data() + hints);
}

TransferFunctionView DeviceTransferFunction::view(double slope, double intercept) const
{
    TransferFunctionView view = view_;
    view.slope = static_cast<float>(slope);
    view.intercept = static_cast<float>(intercept);
    return view;
}

} // namespace lumisweep::LUMISWEEP_CUDA
