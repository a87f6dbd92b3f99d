// The coarse 5-D visibility grid V[direction][cell] that sweeps write and the direction strategies read
// (journal paper, section 5). It only steers sampling: whatever it holds, the image's mean does not move.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Cells divide the volume's box evenly: cells.x = ceil(size.x / cell), each cells' extent is size.x / cells.x ≤ cell
/// voxels, and V is meant at cell centres, p_voxel = (i + 1/2) · size.x / cells.x. Directions are the texel centres of
/// the n × n octahedral map of world space, in Morton order. Visibility is stored in 8 bits: V = stored / 255.
class VisibilityGrid {
public:
    VisibilityGrid() = default;
    VisibilityGrid(VisibilityGrid&&) = default;
    VisibilityGrid& operator=(VisibilityGrid&&) = default;
    /// All visible (V = 1). directions_per_side n must be a power of two.
    VisibilityGrid(Vec3i volume_size, int voxels_per_cell, int directions_per_side);

    static Vec3i cells_of(Vec3i volume_size, int voxels_per_cell);
    /// Bytes from one direction to the next: an odd number of cache lines, as the cells of one place in all directions
    /// would share a few sets of the caches if it were a power of two.
    static std::size_t direction_stride(std::size_t cell_count);
    /// What a grid of this shape takes.
    static std::size_t bytes_needed(std::size_t cell_count, int directions_per_side);
    bool same_shape(const VisibilityGrid& other) const { return cells_ == other.cells_ && n_ == other.n_; }

    const Vec3i& cells() const { return cells_; }
    std::size_t cell_count() const { return cell_count_; }
    int directions_per_side() const { return n_; }
    int direction_count() const { return n_ * n_; }
    std::size_t bytes() const { return stored_.bytes(); } ///< its own; 0 where the directions are stored elsewhere

    /// The grid of one direction (Morton index), x fastest.
    std::uint8_t* direction(int d) { return directions_[static_cast<std::size_t>(d)]; }
    const std::uint8_t* direction(int d) const { return directions_[static_cast<std::size_t>(d)]; }
    std::size_t cell_index(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(cells_.y) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(cells_.x) +
               static_cast<std::size_t>(i);
    }

private:
    friend class LiveVisibility; // moves directions about (visibility/live_visibility.h)

    Vec3i cells_{0, 0, 0};
    std::size_t cell_count_ = 0;
    int n_ = 0;
    std::vector<std::uint8_t*> directions_;
    AlignedArray<std::uint8_t> stored_;
};

/// The unit direction, in world space, of the centre of texel `morton` of the n × n map.
Vec3d texel_direction(int morton, int directions_per_side);

} // namespace lumisweep
