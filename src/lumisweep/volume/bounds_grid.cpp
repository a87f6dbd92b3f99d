#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <type_traits>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/raw_range.h"

namespace lumisweep {

namespace {

template <class Voxel>
struct Extremes {
    std::vector<Voxel> low, high;

    explicit Extremes(std::size_t n) : low(n), high(n) {}
    void clear()
    {
        using Limits = std::numeric_limits<Voxel>;
        std::fill(low.begin(), low.end(), Limits::has_infinity ? Limits::infinity() : Limits::max());
        std::fill(high.begin(), high.end(), Limits::has_infinity ? -Limits::infinity() : Limits::lowest());
    }
    /// Comparisons are false for NaN, which leaves it out.
    void take(const Voxel* from_low, const Voxel* from_high, std::size_t n)
    {
        Voxel* l = low.data();
        Voxel* h = high.data();
        for (std::size_t i = 0; i < n; ++i) {
            l[i] = from_low[i] < l[i] ? from_low[i] : l[i];
            h[i] = from_high[i] > h[i] ? from_high[i] : h[i];
        }
    }
};

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

/// Bounds the relative error of lookups in single precision: three interpolations of some 1.2e-7 each, then the value's
/// slope, intercept and comparison with a knot, 6e-8 each.
constexpr double rounding = 1e-6;

struct Range {
    int begin, end;
};

/// The voxels that interpolation within cell c of an axis of n voxels depends on. At the last one it is between that
/// and the one before still, which rounds.
Range voxels_of_cell(int c, int n)
{
    return {std::max(std::min(c * majorant_cell - 1, n - 2), 0), std::min((c + 1) * majorant_cell, n)};
}

} // namespace

void BoundsGrid::Bounds::include(const Bounds& other)
{
    if (other.empty())
        return;
    *this = empty() ? other : Bounds{std::min(low, other.low), std::max(high, other.high)};
}

BoundsGrid::BoundsGrid(const ScalarGrid& volume)
    : volume_size_(volume.size()), slope_(volume.slope()), intercept_(volume.intercept())
{
    const Vec3i blocks = majorant_blocks(volume_size_);
    blocks_ = AlignedArray<Bounds>(static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) *
                                       static_cast<std::size_t>(blocks.z),
                                   Contents::uninitialised);
    cells_ = AlignedArray<Bounds>(blocks_.size() * majorant_block_cells, Contents::uninitialised);
    const auto& axes = volume.world_from_voxel().column;
    block_side_ = majorant_block * majorant_cell * std::cbrt(length(axes[0]) * length(axes[1]) * length(axes[2]));
    diagonal_ = length(
        volume.world_from_voxel().vector({static_cast<double>(volume_size_.x), static_cast<double>(volume_size_.y),
                                          static_cast<double>(volume_size_.z)}));
    visit_voxels(volume, [&](const auto* voxels) {
        using Voxel = std::remove_cv_t<std::remove_pointer_t<decltype(voxels)>>;
        if constexpr (std::is_integral_v<Voxel>) {
            first_ = std::numeric_limits<Voxel>::min();
            low_end_ = first_;
            high_end_ = std::numeric_limits<Voxel>::max();
        } else if (const RawRange range = raw_range(volume); !range.empty()) {
            low_end_ = static_cast<double>(range.low);
            high_end_ = static_cast<double>(range.high);
            const RawRange usual = usual_range(voxels, volume.voxel_count(), range);
            first_ = static_cast<double>(usual.low);
            first_bound_ = 1.0;
            // A little more, so that rounding leaves the last step above the range's end.
            step_ = (static_cast<double>(usual.high) - first_) / 65533.0 * (1.0 + 1e-8);
            near_ = std::fabs(first_) + std::fabs(static_cast<double>(usual.high));
            far_ = std::fabs(low_end_) + std::fabs(high_end_);
        }
        fill(voxels);
        if constexpr (std::is_integral_v<Voxel>)
            near_ = far_ = std::fabs(raw(range_.low)) + std::fabs(raw(range_.high));
    });
    // Lookups that overflow give 0, too.
    if (far_ * std::max(std::fabs(slope_), 1.0) + std::fabs(intercept_) > 1e38)
        has_gaps_ = true;
}

double BoundsGrid::raw(double bound) const
{
    return bound <= 0.0 ? low_end_ : bound >= 65535.0 ? high_end_ : first_ + step_ * (bound - first_bound_);
}

BoundsGrid::Values BoundsGrid::values(double low, double high) const
{
    const auto slack = [&](double bound) {
        const bool is_end = bound <= 0.0 || bound >= 65535.0;
        // Interpolation between equal voxels is exact: space of value 0 stays empty next to a flank.
        const double size = low == high ? 2.0 * std::fabs(raw(bound)) : is_end ? far_ : near_;
        return rounding * (std::fabs(slope_) * size + std::fabs(intercept_));
    };
    const double a = slope_ * raw(low) + intercept_, b = slope_ * raw(high) + intercept_;
    return slope_ > 0.0 ? Values{a - slack(low), b + slack(high)} : Values{b - slack(high), a + slack(low)};
}

std::uint64_t BoundsGrid::bytes_needed(const Vec3i& volume_size)
{
    const Vec3i blocks = majorant_blocks(volume_size);
    return static_cast<std::uint64_t>(blocks.x) * static_cast<std::uint64_t>(blocks.y) *
           static_cast<std::uint64_t>(blocks.z) * (1 + majorant_block_cells) * sizeof(Bounds);
}

/// Extremes along z of whole slices, then along y, then along x.
template <class Voxel>
void BoundsGrid::fill(const Voxel* voxels)
{
    const Vec3i size = volume_size_, cells = majorant_cells(size), blocks = majorant_blocks(size);
    const auto nx = static_cast<std::size_t>(size.x), slice = nx * static_cast<std::size_t>(size.y);
    const auto to_bounds = [&](Voxel low, Voxel high) -> Bounds {
        if constexpr (std::is_integral_v<Voxel>) {
            const int first = std::numeric_limits<Voxel>::min();
            return {static_cast<std::uint16_t>(low - first), static_cast<std::uint16_t>(high - first)};
        } else {
            if (!(low <= high))
                return {1, 0};
            // Infinite voxels never give a finite value: they count as the ends of the range.
            const auto bound = [&](double v, double toward) {
                const double exact = step_ > 0.0 ? std::clamp((v - first_) / step_ + 1.0, 0.0, 65535.0) : 1.0;
                double b = toward < 0.0 ? std::floor(exact) : std::ceil(exact);
                if ((raw(b) - v) * toward < 0.0)
                    b += toward; // rounding, or beyond the steps
                return static_cast<std::uint16_t>(std::clamp(b, 0.0, 65535.0));
            };
            const double l = static_cast<double>(low), h = static_cast<double>(high);
            // Between data and a value far away interpolation rounds as the far one does.
            const bool is_far = l < h && (l < first_ || h > raw(65534.0));
            const double beyond = is_far ? rounding * (std::fabs(l) + std::fabs(h)) : 0.0;
            return {bound(l - beyond, -1.0), bound(h + beyond, 1.0)};
        }
    };
    std::mutex mutex;
    std::atomic<bool> gaps = false;
    parallel_for(0, blocks.z, [&](int bz) {
        const auto layer = static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y);
        const std::size_t first_block = static_cast<std::size_t>(bz) * layer;
        std::fill_n(cells_.data() + first_block * majorant_block_cells, layer * majorant_block_cells, Bounds{});
        Extremes<Voxel> along_z(slice), along_y(nx);
        for (int cz = bz * majorant_block; cz < std::min((bz + 1) * majorant_block, cells.z); ++cz) {
            along_z.clear();
            const Range rz = voxels_of_cell(cz, size.z);
            for (int z = rz.begin; z < rz.end; ++z) {
                const Voxel* from = voxels + static_cast<std::size_t>(z) * slice;
                along_z.take(from, from, slice);
                if constexpr (std::is_floating_point_v<Voxel>)
                    if (!std::all_of(from, from + slice, [](Voxel v) { return std::isfinite(v); }))
                        gaps = true;
            }
            for (int cy = 0; cy < cells.y; ++cy) {
                along_y.clear();
                const Range ry = voxels_of_cell(cy, size.y);
                for (int y = ry.begin; y < ry.end; ++y) {
                    const std::size_t line = static_cast<std::size_t>(y) * nx;
                    along_y.take(along_z.low.data() + line, along_z.high.data() + line, nx);
                }
                const std::size_t row = first_block + static_cast<std::size_t>(cy / majorant_block * blocks.x);
                Bounds* out = cells_.data() + row * majorant_block_cells +
                              (cz % majorant_block * majorant_block + cy % majorant_block) * majorant_block;
                for (int cx = 0; cx < cells.x; ++cx) {
                    const Range rx = voxels_of_cell(cx, size.x);
                    auto x = static_cast<std::size_t>(rx.begin);
                    Voxel low = along_y.low[x], high = along_y.high[x];
                    for (++x; x < static_cast<std::size_t>(rx.end); ++x) {
                        low = along_y.low[x] < low ? along_y.low[x] : low;
                        high = along_y.high[x] > high ? along_y.high[x] : high;
                    }
                    out[cx / majorant_block * majorant_block_cells + cx % majorant_block] = to_bounds(low, high);
                }
            }
        }
        Bounds all;
        for (std::size_t block = first_block; block < first_block + layer; ++block) {
            Bounds of_block;
            for (int i = 0; i < majorant_block_cells; ++i)
                of_block.include(this->cells(block)[i]);
            blocks_[block] = of_block;
            all.include(of_block);
        }
        const std::lock_guard lock(mutex);
        range_.include(all);
    });
    has_gaps_ = gaps;
}

} // namespace lumisweep
