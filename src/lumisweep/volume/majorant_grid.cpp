#include "lumisweep/volume/majorant_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/parallel.h"

namespace lumisweep {

namespace {

Vec3i cells_of(const Vec3i& size)
{
    const auto cells = [](int n) { return (n + majorant_cell - 1) / majorant_cell; };
    return {cells(size.x), cells(size.y), cells(size.z)};
}

struct Range {
    int begin, end;
};

/// The voxels whose samples can take part in interpolation within cell c of an axis of n voxels.
Range voxels_of_cell(int c, int n)
{
    return {std::max(c * majorant_cell - 1, 0), std::min((c + 1) * majorant_cell + 1, n)};
}

} // namespace

BoundsGrid::BoundsGrid(const ScalarGrid& volume)
    : cells_(cells_of(volume.size())), low_(static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) *
                                            static_cast<std::size_t>(cells_.z)),
      high_(low_.size())
{
    const Vec3i size = volume.size();
    visit_voxels(volume, [&](const auto* voxels) {
        parallel_for(0, cells_.y * cells_.z, [&](int row) {
            const int cy = row % cells_.y, cz = row / cells_.y;
            const Range ry = voxels_of_cell(cy, size.y), rz = voxels_of_cell(cz, size.z);
            for (int cx = 0; cx < cells_.x; ++cx) {
                const Range rx = voxels_of_cell(cx, size.x);
                float low = std::numeric_limits<float>::infinity(), high = -low;
                for (int z = rz.begin; z < rz.end; ++z) {
                    for (int y = ry.begin; y < ry.end; ++y) {
                        const auto* line = voxels + (static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) +
                                                     static_cast<std::size_t>(y)) *
                                                        static_cast<std::size_t>(size.x);
                        for (int x = rx.begin; x < rx.end; ++x) {
                            // Comparisons are false for NaN, which leaves it out.
                            const float v = static_cast<float>(line[x]);
                            low = v < low ? v : low;
                            high = v > high ? v : high;
                        }
                    }
                }
                const std::size_t cell =
                    static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_.x) + static_cast<std::size_t>(cx);
                if (low <= high) {
                    const double a = volume.slope() * low + volume.intercept();
                    const double b = volume.slope() * high + volume.intercept();
                    // Interpolation in single precision may leave the range of its corners by rounding.
                    const double slack = 1e-6 * (std::fabs(a) + std::fabs(b) + std::fabs(volume.intercept()));
                    low = static_cast<float>(std::min(a, b) - slack);
                    high = static_cast<float>(std::max(a, b) + slack);
                }
                low_[cell] = low;
                high_[cell] = high;
            }
        });
    });
}

MajorantGrid::MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function)
    : cells_(bounds.cells()), majorant_(bounds.size())
{
    constexpr float inflation = 1.0F + 1e-5F; // lookups in single precision round
    parallel_for(
        std::size_t{0}, bounds.size(),
        [&](std::size_t cell) {
            majorant_[cell] =
                static_cast<float>(transfer_function.max_extinction(bounds.low(cell), bounds.high(cell))) * inflation;
        },
        1024);
}

} // namespace lumisweep
