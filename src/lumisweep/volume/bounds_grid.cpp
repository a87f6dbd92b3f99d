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
    /// Entry at + i takes part in low[i], high[i]. Comparisons are false for NaN, which leaves it out.
    void take(const Voxel* from_low, const Voxel* from_high, std::size_t n, std::size_t at)
    {
        Voxel* l = low.data() + at;
        Voxel* h = high.data() + at;
        for (std::size_t i = 0; i < n; ++i) {
            l[i] = from_low[i] < l[i] ? from_low[i] : l[i];
            h[i] = from_high[i] > h[i] ? from_high[i] : h[i];
        }
    }
};

struct Range {
    int begin, end;
};

/// The voxels that interpolation within cell c of an axis of n voxels depends on.
Range voxels_of_cell(int c, int n)
{
    return {std::max(c * majorant_cell - 1, 0), std::min((c + 1) * majorant_cell, n)};
}

} // namespace

BoundsGrid::BoundsGrid(const ScalarGrid& volume)
    : cells_(majorant_cells(volume.size())),
      bounds_(static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) *
                  static_cast<std::size_t>(cells_.z),
              Contents::uninitialised),
      slope_(volume.slope()), intercept_(volume.intercept())
{
    visit_voxels(volume, [&](const auto* voxels) {
        using Voxel = std::remove_cv_t<std::remove_pointer_t<decltype(voxels)>>;
        if constexpr (std::is_integral_v<Voxel>) {
            first_ = std::numeric_limits<Voxel>::min();
        } else if (const RawRange range = raw_range(volume); !range.empty()) {
            first_ = static_cast<double>(range.low);
            // A little more, so that rounding leaves the last step above the range's end.
            step_ = (static_cast<double>(range.high) - first_) / 65535.0 * (1.0 + 1e-8);
        }
        fill(volume.size(), voxels);
    });
}

double BoundsGrid::slack(double low, double high) const
{
    return 1e-6 * (std::fabs(low) + std::fabs(high) + std::fabs(intercept_));
}

std::uint64_t BoundsGrid::bytes_needed(const Vec3i& volume_size)
{
    const Vec3i cells = majorant_cells(volume_size);
    return static_cast<std::uint64_t>(cells.x) * static_cast<std::uint64_t>(cells.y) *
           static_cast<std::uint64_t>(cells.z) * sizeof(Bounds);
}

/// Extremes along z of whole slices, then along y, then along x.
template <class Voxel>
void BoundsGrid::fill(const Vec3i& size, const Voxel* voxels)
{
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
                const double exact = step_ > 0.0 ? std::clamp((v - first_) / step_, 0.0, 65535.0) : 0.0;
                double b = toward < 0.0 ? std::floor(exact) : std::ceil(exact);
                if ((first_ + step_ * b - v) * toward < 0.0)
                    b += toward; // rounding
                return static_cast<std::uint16_t>(std::clamp(b, 0.0, 65535.0));
            };
            return {bound(static_cast<double>(low), -1.0), bound(static_cast<double>(high), 1.0)};
        }
    };
    std::mutex mutex;
    std::atomic<bool> gaps = false;
    parallel_for(0, cells_.z, [&](int cz) {
        Extremes<Voxel> along_z(slice), along_y(nx);
        along_z.clear();
        const Range rz = voxels_of_cell(cz, size.z);
        for (int z = rz.begin; z < rz.end; ++z) {
            const Voxel* from = voxels + static_cast<std::size_t>(z) * slice;
            along_z.take(from, from, slice, 0);
            if constexpr (std::is_floating_point_v<Voxel>)
                if (!std::all_of(from, from + slice, [](Voxel v) { return std::isfinite(v); }))
                    gaps = true;
        }
        Bounds least{1, 0};
        for (int cy = 0; cy < cells_.y; ++cy) {
            along_y.clear();
            const Range ry = voxels_of_cell(cy, size.y);
            for (int y = ry.begin; y < ry.end; ++y) {
                const std::size_t line = static_cast<std::size_t>(y) * nx;
                along_y.take(along_z.low.data() + line, along_z.high.data() + line, nx, 0);
            }
            Bounds* out = bounds_.data() + (static_cast<std::size_t>(cz) * static_cast<std::size_t>(cells_.y) +
                                            static_cast<std::size_t>(cy)) *
                                               static_cast<std::size_t>(cells_.x);
            for (int cx = 0; cx < cells_.x; ++cx) {
                const Range rx = voxels_of_cell(cx, size.x);
                auto x = static_cast<std::size_t>(rx.begin);
                Voxel low = along_y.low[x], high = along_y.high[x];
                for (++x; x < static_cast<std::size_t>(rx.end); ++x) {
                    low = along_y.low[x] < low ? along_y.low[x] : low;
                    high = along_y.high[x] > high ? along_y.high[x] : high;
                }
                const Bounds b = out[cx] = to_bounds(low, high);
                if (b.low <= b.high)
                    least =
                        least.low > least.high ? b : Bounds{std::min(least.low, b.low), std::max(least.high, b.high)};
            }
        }
        const std::lock_guard lock(mutex);
        if (least.low <= least.high)
            range_ = range_.low > range_.high
                         ? least
                         : Bounds{std::min(range_.low, least.low), std::max(range_.high, least.high)};
    });
    has_gaps_ = gaps;
}

} // namespace lumisweep
