#include "lumisweep/visibility/dither.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "generated_volumes.h"

namespace lumisweep {
namespace {

using namespace test;

/// A thin medium in all voxels but the first, which sets the scale.
ScalarGrid thin(Vec3i size, int thousandths_of_a_step)
{
    ScalarGrid volume(VoxelType::i16, size, Affine3d{});
    std::fill_n(volume.voxels<std::int16_t>(), volume.voxel_count(), static_cast<std::int16_t>(thousandths_of_a_step));
    volume.voxels<std::int16_t>()[0] = 32000;
    return volume;
}
const TransferFunction thousandths({{0.0, 0.0}, {2000.0, 2.0}, {32000.0, 255.0}});

TEST(Dither, KeepsThinMediaOnAverage)
{
    for (const int thousandth : {1, 10, 100, 250, 500, 777, 1003})
        for (const int level : {0, 1, 2}) {
            const ScalarGrid volume = thin({128, 128, 64}, thousandth);
            const ExtinctionGrid grid = classified(volume, thousandths, level);
            const double p = thousandth * 1e-3 - thousandth / 1000, voxels = static_cast<double>(grid.stored.size());
            const double opaque = (255.0 - thousandth * 1e-3) / std::exp2(3.0 * level);
            // Each voxel rounds up with probability p: within four standard errors.
            EXPECT_NEAR((total(grid) - opaque) / voxels, thousandth * 1e-3,
                        4.0 * std::sqrt(p * (1.0 - p) / voxels) + 1e-5)
                << thousandth << " at level " << level;
        }
}

TEST(Dither, HasNoPattern)
{
    // Neighbours round up independently of each other, near or far, and so do whole lines, which sweeps add up. Within
    // a run of 64 they go by one fixed shuffle of 2^16 numbers, which has its own small correlations.
    const Vec3i n{256, 128, 64};
    const ExtinctionGrid grid = classified(thin(n, 300), thousandths);
    const std::size_t count = grid.stored.size();
    const std::size_t row = static_cast<std::size_t>(n.x), slice = row * static_cast<std::size_t>(n.y);
    const auto up = [&](std::size_t i) { return static_cast<double>(grid.stored[i]) - 0.3; };
    for (const std::size_t lag : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{63}, std::size_t{64},
                                  std::size_t{128}, row, row + 1, 2 * row, slice, slice + row, 2 * slice}) {
        double sum = 0.0;
        for (std::size_t i = 1; i + lag < count; ++i)
            sum += up(i) * up(i + lag);
        const double pairs = static_cast<double>(count - lag - 1);
        const double variance = 1.0 / pairs + (lag < dither_run ? std::exp2(-16.0) : 0.0);
        EXPECT_NEAR(sum / pairs / 0.21, 0.0, 4.5 * std::sqrt(variance)) << lag;
    }
    const auto variance_of_lines = [&](std::size_t step, std::size_t length, const std::vector<std::size_t>& starts) {
        double squares = 0.0;
        for (const std::size_t start : starts) {
            double sum = 0.0;
            for (std::size_t i = 0; i < length; ++i)
                sum += up(start + i * step);
            squares += sum * sum / static_cast<double>(length);
        }
        return squares / static_cast<double>(starts.size()) / 0.21;
    };
    std::vector<std::size_t> along_x, along_y, along_z;
    for (std::size_t i = 1; i < count / row; ++i)
        along_x.push_back(i * row);
    for (std::size_t i = 1; i < count / static_cast<std::size_t>(n.y); ++i)
        along_y.push_back(i / row * slice + i % row);
    for (std::size_t i = 1; i < slice; ++i)
        along_z.push_back(i);
    // A mean of squares of nearly normal variables: its standard error is sqrt(2 / lines).
    EXPECT_NEAR(variance_of_lines(1, row, along_x), 1.0, 4.5 * std::sqrt(2.0 / static_cast<double>(along_x.size())));
    EXPECT_NEAR(variance_of_lines(row, static_cast<std::size_t>(n.y), along_y), 1.0,
                4.5 * std::sqrt(2.0 / static_cast<double>(along_y.size())));
    EXPECT_NEAR(variance_of_lines(slice, static_cast<std::size_t>(n.z), along_z), 1.0,
                4.5 * std::sqrt(2.0 / static_cast<double>(along_z.size())));
}

TEST(Dither, HasEveryNumberOnce)
{
    const std::uint16_t* numbers = dither_numbers();
    std::vector<int> times(1 << 16, 0);
    for (int i = 0; i < 1 << 16; ++i)
        ++times[numbers[i]];
    EXPECT_EQ(std::count(times.begin(), times.end(), 1), 1 << 16);
    EXPECT_TRUE(std::equal(numbers, numbers + dither_run, numbers + (1 << 16)));
}

} // namespace
} // namespace lumisweep
