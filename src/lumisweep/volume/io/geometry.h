// Placing a grid in the world from what headers give: one vector per axis and the first sample's position.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "lumisweep/volume/io/load_volume.h"

namespace lumisweep {

/// world_from_voxel for samples at origin + i · step[0] + j · step[1] + k · step[2], all in LPS millimetres. Any
/// independent finite steps are good (mirrored and sheared grids too); otherwise throws Error that names `where`.
Affine3d place_grid(const std::array<Vec3d, 3>& step, const Vec3d& origin, const std::string& where);

/// The sides as Vec3i; throws Error for empty, too long or too many (see ScalarGrid).
Vec3i checked_size(const std::array<std::uint64_t, 3>& size, const std::string& where);

/// Number of frames as int; throws Error for none or more than 2^20.
int checked_frames(std::uint64_t frames, const std::string& where);

/// Fills spacing from world_from_voxel.
void set_spacing(VolumeHeader& header);

} // namespace lumisweep
