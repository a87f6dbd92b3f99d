#include "lumisweep/visibility/sweep_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "kernel_tables.h"
#include "lumisweep/math/trigonometry.h"

namespace lumisweep {
namespace {

using namespace test;

using Slice = std::vector<std::uint16_t>;

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

Slice filtered(const SweepKernels& kernels, int width, int height, Slice slice, double box_u, double box_v)
{
    SliceFilter filter(kernels, width, height);
    const std::uint16_t* out = filter.apply(slice.data(), box_u, box_v);
    return Slice(out, out + slice.size());
}

Slice random_slice(int width, int height, std::mt19937& random)
{
    std::uniform_int_distribution<int> value(0, whole_visibility);
    Slice slice(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    std::generate(slice.begin(), slice.end(), [&] { return static_cast<std::uint16_t>(value(random)); });
    return slice;
}

/// Largest difference from the direct sum.
double worst_error(int width, int height, const Slice& in, double box_u, double box_v)
{
    const Slice out = filtered(sweep_kernels(), width, height, in, box_u, box_v);
    std::vector<double> rows(in.size());
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i)
            rows[static_cast<std::size_t>(j * width + i)] =
                direct_mean(width, i, box_u, [&](int u) { return in[static_cast<std::size_t>(j * width + u)]; });
    double worst = 0.0;
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            const double expected =
                direct_mean(height, j, box_v, [&](int v) { return rows[static_cast<std::size_t>(v * width + i)]; });
            worst = std::max(worst, std::fabs(out[static_cast<std::size_t>(j * width + i)] - expected));
        }
    return worst;
}

TEST(SweepFilter, RunningSumsEqualTheDirectSum)
{
    std::mt19937 random(1);
    for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {9, 1}, {17, 13}, {64, 5}, {3, 70}, {33, 31}})
        for (const double box_u : {1.0, 1.3, 2.0, 3.0, 4.7, 14.9, 15.0})
            for (const double box_v : {1.0, 2.5, 5.0, 14.2})
                EXPECT_LE(worst_error(width, height, random_slice(width, height, random), box_u, box_v),
                          (box_u > 1.0 ? 2.0 : 0.0) + (box_v > 1.0 ? 2.0 : 0.0))
                    << width << " x " << height << " box " << box_u << " x " << box_v;
}

TEST(SweepFilter, WideBoxesSumFewerBits)
{
    // Rounding all of V to fewer bits, the same way in the worst case, and two products down.
    std::mt19937 random(2);
    const auto worst = [&](int count, double box) {
        double error = 0.0;
        for (const int base : {-1, 8, 64}) {
            Slice slice = random_slice(count, 2, random);
            if (base >= 0)
                std::fill(slice.begin(), slice.end(), static_cast<std::uint16_t>(base));
            error = std::max({error, worst_error(count, 2, slice, box, 1.0), worst_error(2, count, slice, 1.0, box)});
        }
        return error;
    };
    for (const double box : {17.0, 25.2, 31.0})
        EXPECT_LE(worst(300, box), 3.0) << box;
    for (const double box : {33.3, 63.0, 100.5, 254.9, 255.0})
        EXPECT_LE(worst(300, box), 10.0) << box;
    for (const double box : {517.0, 900.0, 2047.0})
        EXPECT_LE(worst(2100, box), 66.0) << box;
    // Wider than the slice, at any width: the mean of all.
    for (const double box : {500.0, 1e16})
        EXPECT_LE(worst(15, box), 2.0) << box;
}

TEST(SweepFilter, ConstantStaysConstantIn8Bits)
{
    for (const auto& [width, height] : {std::pair{31, 12}, {257, 3}, {3, 257}, {1, 40}, {40, 1}})
        for (const double box_u : {1.0, 1.7, 7.31, 255.0})
            for (const double box_v : {1.0, 3.9, 255.0})
                for (const int stored : {0, 1, 77, 128, 254, 255}) {
                    const Slice slice(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                                      static_cast<std::uint16_t>(16 * stored));
                    const Slice out = filtered(sweep_kernels(), width, height, slice, box_u, box_v);
                    std::vector<std::uint8_t> bytes(out.size());
                    sweep_kernels().store(bytes.data(), out.data(), static_cast<int>(out.size()));
                    for (const std::uint8_t v : bytes)
                        ASSERT_EQ(v, stored) << width << " x " << height << " box " << box_u << " x " << box_v;
                }
}

TEST(SweepFilter, WhatIsAllVisibleStaysSoAtAnyWidth)
{
    for (const auto& [width, height] : {std::pair{258, 3}, {3, 258}, {600, 40}, {40, 600}, {1100, 2}, {2, 5000}})
        for (const double box_u : {1.0, 15.0, 259.0, 1100.0, 1e16})
            for (const double box_v : {1.0, 33.0, 257.9, 1e16}) {
                const Slice slice(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), whole_visibility);
                const Slice out = filtered(sweep_kernels(), width, height, slice, box_u, box_v);
                std::vector<std::uint8_t> bytes(out.size());
                sweep_kernels().store(bytes.data(), out.data(), static_cast<int>(out.size()));
                ASSERT_EQ(*std::min_element(bytes.begin(), bytes.end()), 255)
                    << width << " x " << height << " box " << box_u << " x " << box_v;
            }
}

TEST(SweepFilter, EveryInstructionSetGivesTheSameBits)
{
    std::mt19937 random(3);
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {31, 17}, {64, 20}, {129, 6}, {7, 90}})
        for (const double box : {1.2, 3.0, 8.8, 40.1, 1e9}) {
            const Slice in = random_slice(width, height, random);
            const Slice expected = filtered(sweep_kernels_baseline, width, height, in, box, 0.7 * box + 0.3);
            for (const SweepKernels* kernels : runnable_kernels())
                EXPECT_EQ(filtered(*kernels, width, height, in, box, 0.7 * box + 0.3), expected)
                    << kernels->name << ", " << width << " x " << height << " box " << box;
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
