#include "lumisweep/backends/cuda/device_bounds.h"

#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/whole_bounds.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceBounds::build(const void* voxels_on_device, const ScalarGrid& volume, const Stream& stream)
{
    const Vec3i block_grid = majorant_blocks(volume.size());
    const std::size_t blocks = static_cast<std::size_t>(block_grid.x) * static_cast<std::size_t>(block_grid.y) *
                               static_cast<std::size_t>(block_grid.z);
    blocks_.resize(blocks, "bounds of the volume");
    cells_.resize(blocks * rows_of_block, "bounds of the volume");

    FoundInVoxels found;
    DeviceArray<FoundInVoxels> on_device;
    on_device.upload({&found, 1}, "bounds of the volume", stream);
    const auto look = [&] {
        on_device.download({&found, 1}, stream);
        stream.wait();
    };
    raw_range_ = {};
    if (volume.type() == VoxelType::f32) {
        find_finite_range(static_cast<const float*>(voxels_on_device), volume.voxel_count(), on_device.data(), stream);
        look();
        if (found.finite_low <= found.finite_high) // zeros of either sign are one
            raw_range_ = {from_order(found.finite_low) + 0.0F, from_order(found.finite_high) + 0.0F};
    }
    whole_ = begin_bounds(volume, raw_range_);
    find_cell_bounds(volume.type(), voxels_on_device, whole_, block_grid, cells_.data(), blocks_.data(),
                     on_device.data(), stream);
    look();
    CellBounds range;
    if (found.low <= found.high)
        range = {static_cast<std::uint16_t>(found.low), static_cast<std::uint16_t>(found.high)};
    whole_ = end_bounds(whole_, volume.type(), range, found.non_finite != 0);
    if (volume.type() != VoxelType::f32)
        raw_range_ = {static_cast<float>(raw_of_bound(whole_.scale, range.low)),
                      static_cast<float>(raw_of_bound(whole_.scale, range.high))};
}

} // namespace lumisweep::LUMISWEEP_CUDA
