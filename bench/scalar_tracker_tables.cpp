// What the scalar tracker makes before it renders: majorants and the light's distributions.
#include <algorithm>
#include <cstdint>

#include "lumisweep/math/morton.h"
#include "scalar_tracker.h"

namespace lumisweep::bench {

void ScalarTracker::build_majorants()
{
    const Vec3i size = volume_->size();
    const auto cells = [](int n) { return (n + majorant_cell - 1) / majorant_cell; };
    cells_ = {cells(size.x), cells(size.y), cells(size.z)};
    majorants_.reserve(static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) *
                       static_cast<std::size_t>(cells_.z));
    const auto nx = static_cast<std::size_t>(size.x), ny = static_cast<std::size_t>(size.y);
    visit_voxels(*volume_, [&](const auto* voxels) {
        for (int cz = 0; cz < cells_.z; ++cz)
            for (int cy = 0; cy < cells_.y; ++cy)
                for (int cx = 0; cx < cells_.x; ++cx) {
                    // Interpolation reaches one voxel beyond the cell.
                    const auto first = [](int c) {
                        return static_cast<std::size_t>(std::max(c * majorant_cell - 1, 0));
                    };
                    const auto last = [](int c, int n) {
                        return static_cast<std::size_t>(std::min((c + 1) * majorant_cell, n - 1));
                    };
                    auto low = voxels[(first(cz) * ny + first(cy)) * nx + first(cx)], high = low;
                    for (std::size_t z = first(cz); z <= last(cz, size.z); ++z)
                        for (std::size_t y = first(cy); y <= last(cy, size.y); ++y)
                            for (std::size_t x = first(cx); x <= last(cx, size.x); ++x) {
                                low = std::min(low, voxels[(z * ny + y) * nx + x]);
                                high = std::max(high, voxels[(z * ny + y) * nx + x]);
                            }
                    const auto value = [&](auto raw) {
                        return volume_->slope() * static_cast<double>(raw) + volume_->intercept();
                    };
                    const double a = value(low), b = value(high);
                    // A little more, for what rounding adds to interpolated values.
                    majorants_.push_back(static_cast<float>(
                        1.00001 * transfer_function_.max_extinction(std::min(a, b), std::max(a, b))));
                }
    });
}

void ScalarTracker::build_light(const Environment& environment)
{
    light_side_ = environment.resolution();
    const auto side = static_cast<std::size_t>(light_side_);
    const float* morton = environment.view().radiance;
    radiance_.resize(3 * side * side);
    row_cdf_.assign(side + 1, 0.0F);
    cdf_in_row_.assign(side * (side + 1), 0.0F);
    double total = 0.0;
    std::vector<double> totals;
    for (std::size_t y = 0; y < side; ++y) {
        float* cdf = cdf_in_row_.data() + y * (side + 1);
        std::vector<double> sums{0.0};
        for (std::size_t x = 0; x < side; ++x) {
            const auto texel =
                static_cast<std::size_t>(morton_encode(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)));
            float* rgb = radiance_.data() + 3 * (y * side + x);
            std::copy_n(morton + 3 * texel, 3, rgb);
            sums.push_back(sums.back() + luminance(rgb[0], rgb[1], rgb[2]));
        }
        for (std::size_t x = 0; x <= side; ++x)
            cdf[x] = static_cast<float>(sums[x] / std::max(sums.back(), 1e-300));
        total += sums.back();
        totals.push_back(total);
    }
    for (std::size_t y = 0; y < side; ++y)
        row_cdf_[y + 1] = static_cast<float>(totals[y] / std::max(total, 1e-300));
    mean_luminance_ = total / static_cast<double>(side * side);
}

} // namespace lumisweep::bench
