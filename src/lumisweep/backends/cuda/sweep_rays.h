// The march's inner loop: the rays of one thread through one slice of the window of voxels that its block has fetched.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// A block of the march: a warp has 8 rows of the tile's rays, a thread 4 neighbouring rays of each.
inline constexpr int warp_lanes = 32, warps = 4;
inline constexpr int rays_a_thread = 4, rows_a_warp = tile_v / warps;
static_assert(warp_lanes * rays_a_thread == tile_u);

/// Of a piece's voxels: 129 bytes from any of the first 16 on.
inline constexpr int window_chunks = (15 + tile_u + 1 + 15) / 16, window_row = 16 * window_chunks;
inline constexpr int window_rows = tile_v + 1, window_bytes = window_rows * window_row;

/// The number in [low, high] next to x.
LUMISWEEP_HD int between(int x, int low, int high) { return x < low ? low : x > high ? high : x; }

/// The rows of voxels of one sweep axis.
struct VoxelRows {
    const std::uint8_t* rows;
    int pitch, rows_of_slice; ///< rows along v
    std::size_t slice_stride, row_stride;

    LUMISWEEP_HD VoxelRows(const VoxelsView& voxels, int axis)
    {
        const RowsView& layout = axis == 0 ? voxels.along_y : voxels.along_x;
        rows = layout.rows;
        pitch = layout.pitch;
        rows_of_slice = axis == 2 ? voxels.size.y : voxels.size.z;
        const std::size_t one = static_cast<std::size_t>(pitch);
        const std::size_t many = one * static_cast<std::size_t>(axis == 0 ? voxels.size.z : voxels.size.y);
        slice_stride = axis == 1 ? one : many;
        row_stride = axis == 1 ? many : one;
    }
};

struct RaySums {
    std::uint32_t of[rows_a_warp][rays_a_thread];
};

/// `words`: the voxels beside the thread's first ray begin at byte `offset` of the first. Whether all rays along u
/// and all rows of them count.
template <bool all_rays, bool all_rows>
LUMISWEEP_HD void add_piece(const MarchPiece& piece, const std::uint32_t* words, int offset, int row, int ray,
                            RaySums& sums)
{
    // Rays 0 … 2 have their voxels in bytes 0 … 3 of the row, ray 3 in bytes 1 … 4.
    std::uint32_t low[rays_a_thread], high[rays_a_thread];
    LUMISWEEP_UNROLL
    for (int i = 0; i < rays_a_thread; ++i) {
        const bool counts = all_rays || (ray + i >= piece.first_u && ray + i < piece.last_u);
        const int shift = i < 3 ? 8 * i : 16;
        low[i] = counts ? (piece.weights & 0xffffU) << shift : 0U;
        high[i] = counts ? piece.weights >> 16 << shift : 0U;
    }
    LUMISWEEP_UNROLL
    for (int r = 0; r <= rows_a_warp; ++r) {
        const std::uint32_t first = words[r * (window_row / 4)], second = words[r * (window_row / 4) + 1];
        const std::uint32_t a = bytes_from(first, second, offset), b = bytes_from(first, second, offset + 1);
        const auto add = [&](const std::uint32_t(&weights)[rays_a_thread], int to) {
            if (!all_rows && (row + to < piece.first_v || row + to >= piece.last_v))
                return;
            LUMISWEEP_UNROLL
            for (int i = 0; i < rays_a_thread; ++i)
                sums.of[to][i] = dot_bytes(i < 3 ? a : b, weights[i], sums.of[to][i]);
        };
        if (r > 0)
            add(high, r - 1);
        if (r < rows_a_warp)
            add(low, r);
    }
}

} // namespace lumisweep::LUMISWEEP_CUDA
