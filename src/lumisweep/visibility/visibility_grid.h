// The coarse 5-D visibility grid V[direction][cell] that sweeps write and the direction strategies read
// (journal paper, section 5). It only steers sampling: whatever it holds, the image's mean does not move.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Cells divide the volume's box evenly: cells.x = ceil(size.x / cell), each cells' extent is size.x / cells.x ≤ cell
/// voxels, and V is meant at cell centres, p_voxel = (i + 1/2) · size.x / cells.x. Directions are the texel centres of
/// the n × n octahedral map of world space, in Morton order. Visibility is stored in 8 bits: V = stored / 255.
class VisibilityGrid {
public:
    VisibilityGrid() = default;
    /// All visible (V = 1). directions_per_side n must be a power of two.
    VisibilityGrid(Vec3i volume_size, int voxels_per_cell, int directions_per_side);

    static Vec3i cells_of(Vec3i volume_size, int voxels_per_cell);

    const Vec3i& cells() const { return cells_; }
    std::size_t cell_count() const { return cell_count_; }
    int directions_per_side() const { return n_; }
    int direction_count() const { return n_ * n_; }
    std::size_t bytes() const { return stored_.bytes(); }

    /// The grid of one direction (Morton index), x fastest.
    std::uint8_t* direction(int d) { return stored_.data() + static_cast<std::size_t>(d) * cell_count_; }
    const std::uint8_t* direction(int d) const { return stored_.data() + static_cast<std::size_t>(d) * cell_count_; }
    std::size_t cell_index(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(cells_.y) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(cells_.x) +
               static_cast<std::size_t>(i);
    }

private:
    Vec3i cells_{0, 0, 0};
    std::size_t cell_count_ = 0;
    int n_ = 0;
    AlignedArray<std::uint8_t> stored_;
};

/// The unit direction, in world space, of the centre of texel `morton` of the n × n map.
Vec3d texel_direction(int morton, int directions_per_side);

} // namespace lumisweep
