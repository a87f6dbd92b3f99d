// ExtinctionGrids from stored voxels, without a volume and a transfer function.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumisweep/visibility/extinction_grid.h"

namespace lumisweep::test {

/// How precisely a row says what of it is not empty: to the voxel, or in lines of 64 as classify() does.
enum class FilledIn { voxels, lines };

inline std::vector<ExtinctionGrid::Filled> filled_rows(const AlignedArray<std::uint8_t>& voxels, int length,
                                                       FilledIn unit)
{
    std::vector<ExtinctionGrid::Filled> rows;
    for (const std::uint8_t* row = voxels.begin(); row != voxels.end(); row += length) {
        ExtinctionGrid::Filled filled{length, 0};
        for (int i = 0; i < length; ++i)
            if (row[i] != 0)
                filled = {std::min(filled.first, i), i + 1};
        if (unit == FilledIn::lines && filled.first < filled.last)
            filled = {filled.first / 64 * 64, std::min((filled.last + 63) / 64 * 64, length)};
        rows.push_back(filled);
    }
    return rows;
}

/// Fills all that depends on voxels, `stored(i, j, k)`, of a grid of known size.
template <class Stored>
void store_voxels(ExtinctionGrid& grid, FilledIn unit, Stored&& stored)
{
    const Vec3i size = grid.size;
    const std::size_t x = static_cast<std::size_t>(size.x), y = static_cast<std::size_t>(size.y);
    const std::size_t z = static_cast<std::size_t>(size.z);
    grid.stored = AlignedArray<std::uint8_t>(x * y * z);
    grid.transposed = AlignedArray<std::uint8_t>(x * y * z);
    for (std::size_t k = 0; k < z; ++k)
        for (std::size_t j = 0; j < y; ++j)
            for (std::size_t i = 0; i < x; ++i) {
                const auto voxel =
                    static_cast<std::uint8_t>(stored(static_cast<int>(i), static_cast<int>(j), static_cast<int>(k)));
                grid.stored[(k * y + j) * x + i] = voxel;
                grid.transposed[(i * z + k) * y + j] = voxel;
            }
    grid.filled = filled_rows(grid.stored, size.x, unit);
    grid.filled_transposed = filled_rows(grid.transposed, size.y, unit);
}

} // namespace lumisweep::test
