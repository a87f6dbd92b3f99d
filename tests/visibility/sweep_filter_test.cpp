#include "lumisweep/visibility/sweep_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lumisweep/math/trigonometry.h"

namespace lumisweep {
namespace {

/// Mean over the part of [centre − box/2, centre + box/2] that lies on the line, cells being constant.
template <class Cell>
double direct_mean(int count, int centre, double box, Cell&& cell)
{
    double sum = 0.0, covered = 0.0;
    for (int i = 0; i < count; ++i) {
        const double overlap =
            std::max(0.0, std::min(i + 1.0, centre + 0.5 + 0.5 * box) - std::max(i + 0.0, centre + 0.5 - 0.5 * box));
        sum += overlap * cell(i);
        covered += overlap;
    }
    return sum / covered;
}

TEST(SweepFilter, RunningSumsEqualTheDirectSum)
{
    std::mt19937 random(1);
    std::uniform_int_distribution<int> value(0, 65535);
    for (const std::pair<int, int>& size : {std::pair{1, 1}, {1, 9}, {9, 1}, {17, 13}, {64, 5}})
        for (const double box_u : {1.0, 1.3, 2.0, 3.0, 4.7, 16.9, 17.0, 500.0, 1e16})
            for (const double box_v : {1.0, 2.5, 5.0, 40.0}) {
                const int width = size.first, height = size.second;
                std::vector<std::int32_t> in(static_cast<std::size_t>(width * height));
                std::generate(in.begin(), in.end(), [&] { return value(random); });
                std::vector<std::int32_t> out = in;
                SliceFilter(width, height).apply(out.data(), box_u, box_v);
                for (int j = 0; j < height; ++j)
                    for (int i = 0; i < width; ++i) {
                        const double expected = direct_mean(height, j, box_v, [&](int v) {
                            return direct_mean(width, i, box_u,
                                               [&](int u) { return in[static_cast<std::size_t>(v * width + u)]; });
                        });
                        // Two roundings to whole 1/65535, and float products.
                        ASSERT_NEAR(out[static_cast<std::size_t>(j * width + i)], expected, 1.1)
                            << width << " x " << height << " box " << box_u << " x " << box_v << " at " << i << ", "
                            << j;
                    }
            }
}

TEST(SweepFilter, ConstantStaysConstant)
{
    for (const int constant : {0, 1, 32768, 65535}) {
        std::vector<std::int32_t> slice(31 * 12, constant);
        SliceFilter(31, 12).apply(slice.data(), 7.31, 3.9);
        for (const std::int32_t v : slice)
            EXPECT_EQ(v, constant);
    }
}

TEST(SweepFilter, AngleScalesWithTheTexel)
{
    EXPECT_EQ(filter_angle(SweepFilter::none, 8), 0.0);
    EXPECT_NEAR(filter_angle(SweepFilter::half_angle, 8), pi / 32.0, 1e-12);
    EXPECT_NEAR(filter_angle(SweepFilter::full_angle, 8), pi / 16.0, 1e-12);
    EXPECT_NEAR(filter_angle(SweepFilter::half_angle, 16), pi / 64.0, 1e-12);
}

} // namespace
} // namespace lumisweep
