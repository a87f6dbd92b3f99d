#include "lumisweep/visibility/extinction_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep {
namespace {

// Stored extinction in 16.16 fixed point; adding 16 random bits before the shift rounds up as often as the fraction
// says.
constexpr double fixed_one = 65536.0;

/// 16 bits that depend on nothing but the voxel's index, so that the result is the same for any number of threads.
inline std::uint32_t dither_bits(std::uint32_t index)
{
    std::uint32_t h = index * 0x9e3779b1U;
    h ^= h >> 15;
    h *= 0x85ebca77U;
    h ^= h >> 13;
    h *= 0xc2b2ae3dU;
    return h >> 16;
}

std::size_t count(Vec3i size)
{
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

/// Stored extinction of a raw value in 16.16 fixed point.
class FixedExtinction {
public:
    FixedExtinction(const ScalarGrid& volume, const RawRange& range, const TransferFunction& tf)
        : volume_(volume), tf_(tf)
    {
        if (range.empty())
            return;
        const double a = value(range.low), b = value(range.high);
        scale_ = tf.max_extinction(std::min(a, b), std::max(a, b)) / 255.0;
        if (volume.type() == VoxelType::f32 || !(scale_ > 0.0))
            return;
        low_ = static_cast<int>(range.low);
        for (int raw = low_; raw <= static_cast<int>(range.high); ++raw)
            table_.push_back(evaluate(raw));
    }

    double scale() const { return scale_; }

    template <class T>
    std::uint32_t operator()(T raw) const
    {
        if constexpr (std::is_same_v<T, float>)
            return std::isfinite(raw) ? evaluate(static_cast<double>(raw)) : 0;
        else
            return table_[static_cast<std::size_t>(static_cast<int>(raw) - low_)];
    }

private:
    double value(double raw) const { return volume_.slope() * raw + volume_.intercept(); }
    std::uint32_t evaluate(double raw) const
    {
        const double steps = std::min(tf_.evaluate(value(raw)).extinction / scale_, 255.0);
        return static_cast<std::uint32_t>(std::lround(steps * fixed_one));
    }

    const ScalarGrid& volume_;
    const TransferFunction& tf_;
    double scale_ = 0.0;
    int low_ = 0;
    std::vector<std::uint32_t> table_;
};

} // namespace

ExtinctionGrid classify(const ScalarGrid& volume, const RawRange& range, const TransferFunction& transfer_function,
                        int mip_level, ExtinctionLayouts layouts)
{
    require(mip_level >= 0 && mip_level <= 13, "classify: mip level {} (use 0 to 13)", mip_level);
    ExtinctionGrid grid;
    grid.volume_size = volume.size();
    grid.world_from_voxel = volume.world_from_voxel();
    grid.mip_level = mip_level;
    const auto level_side = [&](int side) { return (side + (1 << mip_level) - 1) >> mip_level; };
    grid.size = {level_side(volume.size().x), level_side(volume.size().y), level_side(volume.size().z)};
    grid.stored = AlignedArray<std::uint8_t>(count(grid.size));
    if (layouts == ExtinctionLayouts::with_transposed)
        grid.transposed = AlignedArray<std::uint8_t>(count(grid.size));
    const FixedExtinction fixed(volume, range, transfer_function);
    grid.scale = static_cast<float>(fixed.scale());
    if (!(grid.scale > 0.0F))
        return grid;

    const std::size_t nx = static_cast<std::size_t>(grid.size.x), ny = static_cast<std::size_t>(grid.size.y);
    const std::size_t nz = static_cast<std::size_t>(grid.size.z);
    visit_voxels(volume, [&](const auto* voxels) {
        parallel_for(std::size_t{0}, ny * nz, [&](std::size_t row) {
            const int j = static_cast<int>(row % ny), k = static_cast<int>(row / ny), n = volume.size().x;
            std::vector<std::uint64_t> sums(nx, 0);
            for (int z = k << mip_level; z < std::min((k + 1) << mip_level, volume.size().z); ++z)
                for (int y = j << mip_level; y < std::min((j + 1) << mip_level, volume.size().y); ++y) {
                    const auto* line =
                        voxels + (static_cast<std::size_t>(z) * static_cast<std::size_t>(volume.size().y) +
                                  static_cast<std::size_t>(y)) *
                                     static_cast<std::size_t>(n);
                    for (int x = 0; x < n; ++x)
                        sums[static_cast<std::size_t>(x >> mip_level)] += fixed(line[x]);
                }
            for (std::size_t i = 0; i < nx; ++i) {
                const auto mean = static_cast<std::uint32_t>(sums[i] >> (3 * mip_level));
                const auto stored =
                    static_cast<std::uint8_t>((mean + dither_bits(static_cast<std::uint32_t>(row * nx + i))) >> 16);
                grid.stored[row * nx + i] = stored;
                if (!grid.transposed.empty())
                    grid.transposed[(i * nz + static_cast<std::size_t>(k)) * ny + static_cast<std::size_t>(j)] = stored;
            }
        });
    });
    return grid;
}

} // namespace lumisweep
