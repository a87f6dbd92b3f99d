// Volumes from arrays that a program has in memory, shared with it where that can be.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "lumisweep/volume/io/read_grid.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

/// Voxels [z][y][x] without gaps, which `owner` keeps alive.
struct ArrayVoxels {
    std::shared_ptr<const void> owner;
    const std::byte* data = nullptr;
    StoredType type = StoredType::u8;
    ByteOrder order = ByteOrder::native;
    Vec3i size{0, 0, 0};
    Affine3d world_from_voxel; ///< the sample of voxel i is at p_voxel = i + 0.5
    double slope = 1.0, intercept = 0.0;
};

/// Why voxels cannot be shared and must be copied; empty when they can. They can be when they are u8, u16, i16 or f32
/// in native byte order and aligned, when no float is infinite, and when the memory behind them is known to be readable
/// (ScalarGrid::readable_behind), which is as far as their last page goes.
std::string why_not_shared(const ArrayVoxels& array);

/// Whether any voxel is infinite, which a borrowed volume must not have: its owner may have written to it.
bool any_infinite(const ScalarGrid& volume);

enum class Sharing { where_possible, never, required };

struct ArrayVolume {
    ScalarGrid grid;
    std::vector<std::string> warnings; ///< one line each
};

/// Copies become the types that load_volume() gives, and infinite values NaN. Throws Error when sharing is required and
/// cannot be, and likewise.
ArrayVolume volume_from_array(const ArrayVoxels& array, Sharing sharing);

} // namespace lumisweep
