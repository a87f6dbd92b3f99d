// The types that voxels are kept in.
#pragma once

#include <cstddef>
#include <cstdint>

namespace lumisweep {

enum class VoxelType : std::uint8_t { u8, u16, i16, f32 };

std::size_t size_of(VoxelType type);
const char* name_of(VoxelType type);

} // namespace lumisweep
