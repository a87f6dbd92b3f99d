// The kernels of classification: what they take, and their launch.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device_extinction.h"
#include "lumisweep/visibility/voxel_steps.h"
#include "lumisweep/volume/voxel_type.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Steps by raw value, table[raw − first], as steps_of_raw() says.
struct TableWork {
    std::int32_t* table;
    int first, count; ///< raw values
    TransferPointsView tf;
    double slope, intercept, scale;
};

/// A level from the finest voxels, in rows along x.
struct ClassifyWork {
    const void* voxels = nullptr;
    VoxelType type = VoxelType::u8;
    Vec3i volume_size{0, 0, 0}; ///< finest voxels
    int mip_level = 0;
    Vec3i size{0, 0, 0};                 ///< level voxels
    const std::int32_t* table = nullptr; ///< of 8 and 16 bits: steps at table[raw − table_first]
    int table_first = 0;
    FloatClassification floats; ///< of floats
    const std::uint16_t* dither = nullptr;
    std::uint8_t* rows = nullptr; ///< as DeviceExtinction::straight
    int pitch = 0;
};

/// Rows along y from rows along x.
struct TransposeWork {
    RowsView straight;
    std::uint8_t* transposed; ///< as DeviceExtinction::transposed
    int pitch;                ///< of `transposed`
    Vec3i size;               ///< level voxels
};

void launch_table(const TableWork& work, const Stream& stream);
void launch_classify_fine(const ClassifyWork& work, const Stream& stream);   ///< levels 0 and 1
void launch_classify_coarse(const ClassifyWork& work, const Stream& stream); ///< levels from 2 on
void launch_transpose(const TransposeWork& work, const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
