#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <tbb/task_arena.h>

#include "generated_volumes.h"
#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

using namespace test;

TEST(Classify, ScaleIsTheLargestExtinctionWithinTheRange)
{
    // The transfer function's peaks at -500 and 5000 lie outside of the volume's range.
    ScalarGrid volume(VoxelType::u8, {3, 1, 1}, Affine3d{}, 10.0, -100.0);
    volume.voxels<std::uint8_t>()[0] = 10;  // 0
    volume.voxels<std::uint8_t>()[1] = 20;  // 100
    volume.voxels<std::uint8_t>()[2] = 110; // 1000
    const TransferFunction tf({{-500.0, 90.0}, {-1.0, 0.0}, {100.0, 2.0}, {500.0, 3.0}, {1000.0, 1.0}, {5000.0, 70.0}},
                              3.0);
    const ExtinctionGrid grid = classified(volume, tf);
    EXPECT_NEAR(grid.scale * 255.0F, 9.0F, 1e-5F);
    EXPECT_NEAR(grid.stored[0], 255.0 * 2.0 / 101.0 / 3.0, 1.0);
    EXPECT_EQ(grid.stored[1], 170);
    EXPECT_EQ(grid.stored[2], 85);
}

TEST(Classify, AllVoxelTypesAgree)
{
    const Vec3i size{7, 5, 3};
    const TransferFunction tf({{0.0, 0.0}, {200.0, 5.0}});
    const auto fill = [&](VoxelType type, auto zero, int mip_level) {
        ScalarGrid grid(type, size, Affine3d{});
        using T = decltype(zero);
        for (std::size_t i = 0; i < grid.voxel_count(); ++i)
            grid.voxels<T>()[i] = static_cast<T>(i * 37 % 199);
        return classified(grid, tf, mip_level);
    };
    for (const int level : {0, 1}) {
        const ExtinctionGrid u8 = fill(VoxelType::u8, std::uint8_t{}, level);
        const ExtinctionGrid others[] = {fill(VoxelType::u16, std::uint16_t{}, level),
                                         fill(VoxelType::i16, std::int16_t{}, level),
                                         fill(VoxelType::f32, float{}, level)};
        for (const ExtinctionGrid& other : others) {
            EXPECT_FLOAT_EQ(other.scale, u8.scale);
            EXPECT_TRUE(std::equal(u8.stored.begin(), u8.stored.end(), other.stored.begin()));
        }
        EXPECT_EQ(u8.stored.bytes() + u8.transposed.bytes(), level == 0 ? 2U * 7 * 5 * 3 : 2U * 4 * 3 * 2);
    }
}

TEST(Classify, MipsKeepExtinctionTimesLengthAtOddEnds)
{
    const Vec3i size{5, 7, 9};
    const ScalarGrid volume = fill_i16(size, Affine3d{}, [](double, double, double) { return 7.0; });
    const auto level = [&](int l) { return classified(volume, TransferFunction({{7.0, 2.0}}), l); };
    const ExtinctionGrid fine = level(0), half = level(1);
    EXPECT_EQ(half.volume_size, size);
    EXPECT_EQ(half.mip_level, 1);
    EXPECT_EQ(half.size, (Vec3i{3, 4, 5}));
    EXPECT_EQ(level(2).size, (Vec3i{2, 2, 3}));
    EXPECT_EQ(level(4).size, (Vec3i{1, 1, 1}));
    EXPECT_EQ(half.stored[0], 255);
    EXPECT_NEAR(half.stored[2], 127.5, 0.51); // one of two voxels along x is missing
    EXPECT_NEAR(8.0 * total(half), total(fine), 8.0 * 0.5 * 3 * 4 * 5);
}

TEST(Classify, EveryLevelIsTheRoundedMeanOfTheFinestVoxels)
{
    const TransferFunction tf({{0.0, 0.0}, {100.0, 1.0}, {1000.0, 4.0}});
    for (const Vec3i size : {Vec3i{1, 1, 1}, {37, 11, 5}, {130, 3, 6}, {3, 2, 300}, {2, 300, 3}, {300, 2, 3}}) {
        const ScalarGrid volume = smoke_volume(size, Affine3d{});
        for (int level = 0; level <= 13; ++level) {
            const ExtinctionGrid grid = classified(volume, tf, level);
            const double inverse_volume = std::exp2(-3.0 * level);
            for (int k = 0; k < grid.size.z; ++k)
                for (int j = 0; j < grid.size.y; ++j)
                    for (int i = 0; i < grid.size.x; ++i) {
                        double mean = 0.0;
                        for (int z = k << level; z < std::min((k + 1) << level, size.z); ++z)
                            for (int y = j << level; y < std::min((j + 1) << level, size.y); ++y)
                                for (int x = i << level; x < std::min((i + 1) << level, size.x); ++x)
                                    mean += tf.evaluate(volume.value(x, y, z)).extinction * inverse_volume;
                        const double steps = grid.scale > 0.0F ? mean / static_cast<double>(grid.scale) : 0.0;
                        const std::size_t index = static_cast<std::size_t>((k * grid.size.y + j) * grid.size.x + i);
                        // Rounded up or down, nothing else.
                        ASSERT_GT(grid.stored[index], steps - 1.0 - 1e-3) << level;
                        ASSERT_LT(grid.stored[index], steps + 1.0 + 1e-3) << level;
                    }
        }
    }
}

TEST(Classify, CoarseLevelsDoNotOverflow)
{
    // 2^24 voxels of the largest value in one level voxel, and level voxels that hold next to nothing.
    ScalarGrid volume(VoxelType::u8, {256, 256, 256}, Affine3d{});
    std::fill_n(volume.voxels<std::uint8_t>(), volume.voxel_count(), std::uint8_t{255});
    const TransferFunction tf({{0.0, 0.0}, {255.0, 1.0}});
    EXPECT_EQ(classified(volume, tf, 8).stored[0], 255);
    EXPECT_NEAR(classified(volume, tf, 9).stored[0], 255.0 / 8.0, 1.0);
    EXPECT_LE(classified(volume, tf, 13).stored[0], 1);
    const ExtinctionGrid quarter = classified(volume, tf, 6);
    EXPECT_EQ(std::count(quarter.stored.begin(), quarter.stored.end(), 255), 64);
}

TEST(Classify, LayoutsAgree)
{
    for (const Vec3i size : {Vec3i{1, 1, 1},
                             {67, 1, 3},
                             {1, 70, 2},
                             {33, 65, 7},
                             {129, 130, 3},
                             {16, 192, 4},
                             {200, 64, 2},
                             {70, 1025, 2},
                             {128, 575, 1},
                             {20, 513, 2}})
        for (const int level : {0, 1}) {
            const ScalarGrid volume = smoke_volume(size, Affine3d{});
            const ExtinctionGrid grid = classified(volume, smoke(), level);
            const ExtinctionGrid straight = classified(volume, smoke(), level, ExtinctionLayouts::straight);
            EXPECT_TRUE(straight.transposed.empty());
            EXPECT_EQ(grid.stored.bytes() + grid.transposed.bytes(), 2 * straight.stored.bytes());
            ASSERT_TRUE(std::equal(grid.stored.begin(), grid.stored.end(), straight.stored.begin()));
            const Vec3i n = grid.size;
            for (int k = 0; k < n.z; ++k)
                for (int j = 0; j < n.y; ++j)
                    for (int i = 0; i < n.x; ++i)
                        ASSERT_EQ(grid.transposed[static_cast<std::size_t>((i * n.z + k) * n.y + j)],
                                  grid.stored[static_cast<std::size_t>((k * n.y + j) * n.x + i)]);
        }
}

TEST(Classify, FilledPartsLeaveOutWhatIsEmpty)
{
    std::mt19937 random(9);
    for (const Vec3i size : {Vec3i{1, 1, 1}, {64, 64, 2}, {200, 63, 5}, {65, 190, 4}, {300, 1100, 2}, {1, 2000, 1}}) {
        // A few filled voxels: many lines are empty, some in parts.
        ScalarGrid volume(VoxelType::u8, size, Affine3d{});
        const std::size_t voxels = volume.voxel_count();
        for (std::size_t i = 0; i < 1 + voxels / 300; ++i)
            volume.voxels<std::uint8_t>()[random() % voxels] = 200;
        const ExtinctionGrid grid = classified(volume, TransferFunction({{0.0, 0.0}, {200.0, 1.0}}));
        const auto expect_tight = [](const std::vector<ExtinctionGrid::Filled>& filled, const std::uint8_t* line,
                                     std::size_t length, std::size_t lines) {
            ASSERT_EQ(filled.size(), lines);
            for (std::size_t l = 0; l < lines; ++l, line += length) {
                const int n = static_cast<int>(length);
                const int first =
                    static_cast<int>(std::find_if(line, line + length, [](int v) { return v > 0; }) - line);
                int last = n;
                while (last > 0 && line[last - 1] == 0)
                    --last;
                if (last == 0) {
                    ASSERT_EQ(filled[l].first, filled[l].last);
                    continue;
                }
                ASSERT_EQ(filled[l].first, first / 64 * 64);
                ASSERT_EQ(filled[l].last, std::min((last + 63) / 64 * 64, n));
            }
        };
        EXPECT_LE(grid.bytes(), ExtinctionGrid::bytes_needed(size));
        const auto n = [](int side) { return static_cast<std::size_t>(side); };
        expect_tight(grid.filled, grid.stored.data(), n(size.x), n(size.y) * n(size.z));
        expect_tight(grid.filled_transposed, grid.transposed.data(), n(size.y), n(size.x) * n(size.z));
    }
}

TEST(Classify, NonFiniteVoxelsAndNoExtinctionAreEmpty)
{
    ScalarGrid volume(VoxelType::f32, {4, 1, 1}, Affine3d{});
    float* v = volume.voxels<float>();
    v[0] = std::numeric_limits<float>::quiet_NaN();
    v[1] = std::numeric_limits<float>::infinity();
    v[2] = 1.0F;
    v[3] = -std::numeric_limits<float>::infinity();
    const ExtinctionGrid grid = classified(volume, TransferFunction({{0.0, 3.0}}));
    EXPECT_EQ(grid.stored[0], 0);
    EXPECT_EQ(grid.stored[1], 0);
    EXPECT_EQ(grid.stored[2], 255);
    EXPECT_EQ(grid.stored[3], 0);
    EXPECT_EQ(classified(volume, TransferFunction({{0.0, 0.0}})).scale, 0.0F);
    v[2] = v[0];
    const ExtinctionGrid nothing = classified(volume, TransferFunction({{0.0, 3.0}}));
    EXPECT_EQ(nothing.scale, 0.0F);
    EXPECT_EQ(total(nothing), 0.0);
}

TEST(Classify, SameForAnyNumberOfThreads)
{
    const ScalarGrid volume = smoke_volume({33, 21, 17}, Affine3d{});
    for (const int level : {0, 2}) {
        const ExtinctionGrid expected = classified(volume, smoke(), level);
        for (const int threads : {1, 2, 7}) {
            tbb::task_arena arena(threads);
            const ExtinctionGrid grid = arena.execute([&] { return classified(volume, smoke(), level); });
            EXPECT_EQ(grid.scale, expected.scale);
            EXPECT_TRUE(std::equal(expected.stored.begin(), expected.stored.end(), grid.stored.begin()));
            EXPECT_TRUE(std::equal(expected.transposed.begin(), expected.transposed.end(), grid.transposed.begin()));
        }
    }
}

TEST(Classify, IntoAnyGridMadeBefore)
{
    ExtinctionGrid grid;
    const auto expect_same = [&](const ScalarGrid& volume, const TransferFunction& tf, int level,
                                 ExtinctionLayouts layouts) {
        const ExtinctionGrid expected = classified(volume, tf, level, layouts);
        EXPECT_TRUE(classify_into(grid, volume, raw_range(volume), tf, level, layouts));
        EXPECT_EQ(grid.volume_size, expected.volume_size);
        EXPECT_EQ(grid.size, expected.size);
        EXPECT_EQ(grid.mip_level, expected.mip_level);
        EXPECT_EQ(grid.scale, expected.scale);
        ASSERT_EQ(grid.bytes(), expected.bytes());
        EXPECT_TRUE(std::equal(expected.stored.begin(), expected.stored.end(), grid.stored.begin()));
        EXPECT_TRUE(std::equal(expected.transposed.begin(), expected.transposed.end(), grid.transposed.begin()));
    };
    const ScalarGrid small = smoke_volume({33, 70, 5}, oblique()), large = smoke_volume({170, 190, 160}, Affine3d{});
    const TransferFunction nothing({{0.0, 0.0}});
    expect_same(small, smoke(), 0, ExtinctionLayouts::with_transposed);
    const std::uint8_t* memory = grid.stored.data();
    expect_same(small, nothing, 0, ExtinctionLayouts::with_transposed);
    expect_same(small, bone(), 0, ExtinctionLayouts::straight);
    EXPECT_EQ(grid.stored.data(), memory);
    expect_same(large, smoke(), 0, ExtinctionLayouts::with_transposed);
    expect_same(large, nothing, 0, ExtinctionLayouts::with_transposed);
    expect_same(large, smoke(), 1, ExtinctionLayouts::with_transposed);
    expect_same(large, nothing, 0, ExtinctionLayouts::straight);
}

TEST(Classify, CanBeCancelled)
{
    const ScalarGrid volume = smoke_volume({16, 16, 16}, Affine3d{});
    ExtinctionGrid grid;
    std::atomic<bool> cancel{true};
    const auto into = [&] {
        return classify_into(grid, volume, raw_range(volume), smoke(), 0, ExtinctionLayouts::straight, &cancel);
    };
    EXPECT_FALSE(into());
    cancel = false;
    EXPECT_TRUE(into());
    const ExtinctionGrid expected = classified(volume, smoke());
    EXPECT_TRUE(std::equal(expected.stored.begin(), expected.stored.end(), grid.stored.begin()));
}

TEST(Classify, RefusesImpossibleLevels)
{
    const ScalarGrid volume = smoke_volume({4, 4, 4}, Affine3d{});
    EXPECT_THROW(classified(volume, smoke(), -1), Error);
    EXPECT_THROW(classified(volume, smoke(), 14), Error);
}

} // namespace
} // namespace lumisweep
