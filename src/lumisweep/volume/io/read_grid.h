// From stored voxels of any scalar type to a ScalarGrid in the smallest type that keeps them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lumisweep/volume/io/load_volume.h"
#include "lumisweep/volume/io/voxel_source.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

enum class StoredType : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };
enum class ByteOrder : std::uint8_t { native, swapped };

std::size_t size_of(StoredType type);
const char* name_of(StoredType type);
/// The largest bytes per voxel that `type` may take in memory.
std::size_t loaded_size_of(StoredType type);

/// Reads size.x · size.y · size.z voxels. `where` names the file in messages; warnings are appended.
ScalarGrid read_grid(VoxelSource& source, StoredType type, ByteOrder order, const VolumeHeader& header,
                     const std::string& where, std::vector<std::string>& warnings);

} // namespace lumisweep
