// Level voxels on the device: steps of one, and how they lie in rows; for kernels of classification.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/classify_kernels.h"
#include "lumisweep/visibility/dither.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Calls f with a typed pointer to the voxels on the device.
template <class Function>
void visit_voxels(const ClassifyWork& work, Function&& f)
{
    switch (work.type) {
    case VoxelType::u8: return f(static_cast<const std::uint8_t*>(work.voxels));
    case VoxelType::u16: return f(static_cast<const std::uint16_t*>(work.voxels));
    case VoxelType::i16: return f(static_cast<const std::int16_t*>(work.voxels));
    default: return f(static_cast<const float*>(work.voxels));
    }
}

/// Whether every row of finest voxels begins at a multiple of `alignment` bytes.
template <class T>
bool rows_aligned(const ClassifyWork& work, std::size_t alignment)
{
    return reinterpret_cast<std::uintptr_t>(work.voxels) % alignment == 0 &&
           static_cast<std::size_t>(work.volume_size.x) * sizeof(T) % alignment == 0;
}

/// Steps of a raw voxel of 8 or 16 bits.
template <class T>
LUMISWEEP_HD std::int32_t steps_of(const ClassifyWork& work, T raw)
{
    return work.table[raw - work.table_first];
}
LUMISWEEP_HD std::int32_t steps_of(const ClassifyWork& work, float raw)
{
    const FloatSteps<float, GatheredSegments<float>> steps(work.floats);
    const float value = steps.value_of(raw);
    return steps.empty(value) ? 0 : steps(value);
}

/// Row y of slice z of the finest voxels.
template <class T>
LUMISWEEP_HD const T* finest_row(const ClassifyWork& work, int y, int z)
{
    const std::size_t row =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(work.volume_size.y) + static_cast<std::size_t>(y);
    return static_cast<const T*>(work.voxels) + row * static_cast<std::size_t>(work.volume_size.x);
}

/// The numbers that dither level voxel i of a row and those that follow it in its run.
LUMISWEEP_HD const std::uint16_t* dither_of(const ClassifyWork& work, int row, int i)
{
    const auto place = static_cast<std::uint32_t>(i);
    return work.dither + dither_start(static_cast<std::uint32_t>(row), place / dither_run) + place % dither_run;
}

LUMISWEEP_HD std::uint8_t* stored_row(const ClassifyWork& work, int row)
{
    return work.rows + static_cast<std::size_t>(row) * static_cast<std::size_t>(work.pitch);
}

} // namespace lumisweep::LUMISWEEP_CUDA
