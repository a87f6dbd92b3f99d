// What the host has, in the device's memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "lumisweep/backends/cuda/device_extinction.h"
#include "lumisweep/visibility/extinction_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// `rows` rows of `length` voxels with their margins.
inline std::vector<std::uint8_t> padded_rows(const std::uint8_t* voxels, int length, int rows)
{
    const std::size_t pitch = static_cast<std::size_t>(row_pitch(length)), count = static_cast<std::size_t>(length);
    std::vector<std::uint8_t> padded(pitch * static_cast<std::size_t>(rows));
    for (std::uint8_t* row = padded.data(); row != padded.data() + padded.size(); row += pitch, voxels += count) {
        std::fill(row, row + row_margin, voxels[0]);
        std::memcpy(row + row_margin, voxels, count);
        std::fill(row + row_margin + count, row + pitch, voxels[count - 1]);
    }
    return padded;
}

inline DeviceExtinction on_device(const ExtinctionGrid& grid, const Stream& stream)
{
    DeviceExtinction extinction;
    extinction.volume_size = grid.volume_size;
    extinction.world_from_voxel = grid.world_from_voxel;
    extinction.mip_level = grid.mip_level;
    extinction.scale = grid.scale;
    extinction.resize(grid.size);
    const Vec3i& size = grid.size;
    const auto upload = [&](DeviceArray<std::uint8_t>& to, const std::vector<std::uint8_t>& from) {
        to.upload(from, "voxels", stream);
        stream.wait();
    };
    upload(extinction.straight, padded_rows(grid.stored.data(), size.x, size.y * size.z));
    upload(extinction.transposed, padded_rows(grid.transposed.data(), size.y, size.x * size.z));
    return extinction;
}

} // namespace lumisweep::LUMISWEEP_CUDA
