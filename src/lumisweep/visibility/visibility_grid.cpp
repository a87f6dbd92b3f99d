#include "lumisweep/visibility/visibility_grid.h"

#include <bit>
#include <cstring>

#include "lumisweep/base/error.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {

Vec3i VisibilityGrid::cells_of(Vec3i volume_size, int voxels_per_cell)
{
    const auto along = [&](int side) { return side / voxels_per_cell + (side % voxels_per_cell != 0 ? 1 : 0); };
    return {along(volume_size.x), along(volume_size.y), along(volume_size.z)};
}

VisibilityGrid::VisibilityGrid(Vec3i volume_size, int voxels_per_cell, int directions_per_side)
{
    require(volume_size.x >= 1 && volume_size.y >= 1 && volume_size.z >= 1,
            "visibility grid: the volume has {} x {} x {} voxels (every side must be at least 1)", volume_size.x,
            volume_size.y, volume_size.z);
    require(voxels_per_cell >= 1, "visibility.cell: {} voxels per cell (use 1 to 64)", voxels_per_cell);
    require(directions_per_side >= 1 && directions_per_side <= 32 &&
                std::has_single_bit(static_cast<unsigned>(directions_per_side)),
            "visibility.directions: {} is not one of 1, 2, 4, 8, 16 and 32", directions_per_side);
    cells_ = cells_of(volume_size, voxels_per_cell);
    n_ = directions_per_side;
    cell_count_ =
        static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) * static_cast<std::size_t>(cells_.z);
    stored_ = AlignedArray<std::uint8_t>(bytes_needed(cell_count_, n_), Contents::uninitialised);
    std::memset(stored_.data(), 255, stored_.size());
    for (int d = 0; d < direction_count(); ++d)
        directions_.push_back(stored_.data() + static_cast<std::size_t>(d) * direction_stride(cell_count_));
}

std::size_t VisibilityGrid::direction_stride(std::size_t cell_count)
{
    constexpr std::size_t line = AlignedArray<std::uint8_t>::alignment;
    return ((cell_count + line - 1) / line | 1) * line;
}

std::size_t VisibilityGrid::bytes_needed(std::size_t cell_count, int directions_per_side)
{
    return direction_stride(cell_count) * static_cast<std::size_t>(directions_per_side) *
           static_cast<std::size_t>(directions_per_side);
}

Vec3d texel_direction(int morton, int directions_per_side)
{
    const TexelXY<std::int32_t> texel = morton_decode<std::int32_t>(morton);
    const double n = directions_per_side;
    return direction_from_oct(UV<double>{(texel.x + 0.5) / n, (texel.y + 0.5) / n});
}

} // namespace lumisweep
