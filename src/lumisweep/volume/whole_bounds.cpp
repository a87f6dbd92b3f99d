#include "lumisweep/volume/whole_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace lumisweep {

namespace {

/// The range that steps are spent on: the data's without a fill value far from everything else ("nothing here"), which
/// would leave one step for all that matters. Judged by some voxels, spread so that no lattice favours the volume's
/// faces; what lies beyond counts as an end.
RawRange usual_range(const float* voxels, std::size_t count, const RawRange& range)
{
    constexpr std::size_t looks = 65536;
    constexpr float far = 16.0F; // times the range of all other values
    std::vector<float> values;
    for (std::uint64_t k = 0; k < std::min(count, looks); ++k) {
        // Of many, those at multiples of the golden ratio (modulo 1).
        const std::size_t i = count <= looks ? k : ((k * 0x9e3779b9U & 0xffffffffU) * count) >> 32;
        if (std::isfinite(voxels[i]))
            values.push_back(voxels[i]);
    }
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    RawRange usual = range;
    if (const std::size_t n = values.size(); n > 2) {
        if ((values[1] - values[0]) / far > values[n - 1] - values[1])
            usual.low = values[1];
        else if ((values[n - 1] - values[n - 2]) / far > values[n - 2] - values[0])
            usual.high = values[n - 2];
    }
    return usual;
}

/// Integers from the type's smallest on.
template <class Voxel>
BoundsScale integer_steps()
{
    BoundsScale scale;
    scale.first = scale.low_end = std::numeric_limits<Voxel>::min();
    scale.high_end = std::numeric_limits<Voxel>::max();
    return scale;
}

BoundsScale float_steps(const ScalarGrid& volume, const RawRange& range)
{
    BoundsScale scale;
    if (range.empty())
        return scale;
    scale.low_end = static_cast<double>(range.low);
    scale.high_end = static_cast<double>(range.high);
    const RawRange usual = usual_range(volume.voxels<float>(), volume.voxel_count(), range);
    scale.first = static_cast<double>(usual.low);
    scale.first_bound = 1.0;
    // A little more, so that rounding leaves the last step above the range's end.
    scale.step = (static_cast<double>(usual.high) - scale.first) / 65533.0 * (1.0 + 1e-8);
    scale.near_size = std::fabs(scale.first) + std::fabs(static_cast<double>(usual.high));
    scale.far_size = std::fabs(scale.low_end) + std::fabs(scale.high_end);
    return scale;
}

BoundsScale steps(const ScalarGrid& volume, const RawRange& range)
{
    switch (volume.type()) {
    case VoxelType::u8: return integer_steps<std::uint8_t>();
    case VoxelType::u16: return integer_steps<std::uint16_t>();
    case VoxelType::i16: return integer_steps<std::int16_t>();
    default: return float_steps(volume, range);
    }
}

} // namespace

WholeBounds begin_bounds(const ScalarGrid& volume, const RawRange& range)
{
    WholeBounds bounds;
    bounds.volume_size = volume.size();
    bounds.scale = steps(volume, range);
    bounds.scale.slope = volume.slope();
    bounds.scale.intercept = volume.intercept();
    const auto& axes = volume.world_from_voxel().column;
    bounds.block_side = majorant_block * majorant_cell * std::cbrt(length(axes[0]) * length(axes[1]) * length(axes[2]));
    const Vec3i& size = volume.size();
    bounds.diagonal = length(volume.world_from_voxel().vector(
        {static_cast<double>(size.x), static_cast<double>(size.y), static_cast<double>(size.z)}));
    return bounds;
}

WholeBounds end_bounds(const WholeBounds& begun, VoxelType type, const CellBounds& range, bool non_finite)
{
    WholeBounds bounds = begun;
    bounds.range = range;
    BoundsScale& scale = bounds.scale;
    if (type != VoxelType::f32)
        scale.near_size = scale.far_size =
            std::fabs(raw_of_bound(scale, range.low)) + std::fabs(raw_of_bound(scale, range.high));
    // Lookups that overflow give 0, too.
    bounds.has_gaps =
        non_finite || scale.far_size * std::max(std::fabs(scale.slope), 1.0) + std::fabs(scale.intercept) > 1e38;
    return bounds;
}

} // namespace lumisweep
