// The extinction grid (visibility/extinction_grid.h) in the device's memory, in rows that sweeps copy in pieces of 16
// bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/math/vec.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Bytes before a row's first voxel, and at least as many behind its last: they repeat the voxel at that end.
inline constexpr int row_margin = 16;

/// From row to row in bytes, a multiple of 16.
constexpr int row_pitch(int voxels) { return (voxels + 2 * row_margin + 15) / 16 * 16; }

/// One layout as kernels read it. Memory: rows [row][pitch] bytes; voxel i of row r at r · pitch + row_margin + i.
struct RowsView {
    const std::uint8_t* rows = nullptr;
    int pitch = 0;
};

/// Stored steps equal those of classify() to the byte.
struct DeviceExtinction {
    Vec3i volume_size{0, 0, 0}; ///< finest voxels
    Affine3d world_from_voxel;  ///< of the finest level
    int mip_level = 0;
    Vec3i size{0, 0, 0}; ///< level voxels
    float scale = 0.0F; ///< extinction of one stored step, 1/world unit; 0 for an empty volume (then nothing is stored)
    DeviceArray<std::uint8_t> straight;   ///< rows along x: [z][y]
    DeviceArray<std::uint8_t> transposed; ///< rows along y: [x][z]

    /// Memory for a level of that size.
    void resize(Vec3i level_size)
    {
        size = level_size;
        const auto rows = [](int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); };
        straight.resize(rows(size.z, size.y) * static_cast<std::size_t>(row_pitch(size.x)), "the classified volume");
        transposed.resize(rows(size.x, size.z) * static_cast<std::size_t>(row_pitch(size.y)), "the classified volume");
    }
    /// What resize() takes of a level of a volume.
    static std::uint64_t bytes_needed(Vec3i volume_voxels, int level)
    {
        const auto side = [&](int voxels) { return (voxels + (1 << level) - 1) >> level; };
        const auto rows = [](int a, int b, int voxels) {
            return static_cast<std::uint64_t>(a) * static_cast<std::uint64_t>(b) *
                   static_cast<std::uint64_t>(row_pitch(voxels));
        };
        const int x = side(volume_voxels.x), y = side(volume_voxels.y), z = side(volume_voxels.z);
        return rows(z, y, x) + rows(x, z, y);
    }
    std::uint64_t bytes() const { return straight.bytes() + transposed.bytes(); }
    RowsView rows_along_x() const { return {straight.data(), row_pitch(size.x)}; }
    RowsView rows_along_y() const { return {transposed.data(), row_pitch(size.y)}; }
};

} // namespace lumisweep::LUMISWEEP_CUDA
