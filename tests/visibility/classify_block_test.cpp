#include "lumisweep/visibility/classify_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "generated_volumes.h"
#include "support/random_function.h"

namespace lumisweep {
namespace {

using namespace test;

TEST(ClassifyBlock, SameForEveryInstructionSet)
{
    std::vector<ClassifyBlock> blocks;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        blocks.push_back(classify_block_avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        blocks.push_back(classify_block_avx512);
#endif
    int cases_with_extinction = 0;
    const auto expect_same = [&](const ScalarGrid& volume, const TransferFunction& tf) {
        for (const int level : {0, 1, 2, 3, 5}) {
            const auto with = [&](ClassifyBlock block) {
                ExtinctionGrid grid;
                classify_with(block, grid, volume, raw_range(volume), tf, level, ExtinctionLayouts::with_transposed);
                return grid;
            };
            const ExtinctionGrid expected = with(classify_block_baseline);
            cases_with_extinction += total(expected) > 0.0 ? 1 : 0;
            for (const ClassifyBlock block : blocks) {
                const ExtinctionGrid grid = with(block);
                ASSERT_TRUE(std::equal(expected.stored.begin(), expected.stored.end(), grid.stored.begin())) << level;
                ASSERT_TRUE(std::equal(expected.transposed.begin(), expected.transposed.end(), grid.transposed.begin()))
                    << level;
            }
        }
    };
    std::mt19937 random(17);
    // Few points are searched in registers, many by gathers; steps, falling flanks, values at points, empty parts.
    std::vector<TransferFunction> functions{smoke(), bone(), TransferFunction({{400.0, 1.0}})};
    for (const int points : {2, 14, 15, 16, 17, 60})
        functions.push_back(test::random_function(points, random));
    for (const Vec3i size : {Vec3i{64, 64, 3}, {131, 77, 5}, {1, 1, 1}, {7, 130, 2}, {67, 515, 2}})
        for (const TransferFunction& tf : functions) {
            ScalarGrid i16 = smoke_volume(size, Affine3d{});
            i16.voxels<std::int16_t>()[i16.voxel_count() / 2] = 400;
            expect_same(i16, tf);
            ScalarGrid u8(VoxelType::u8, size, Affine3d{}, 4.3, 20.0),
                u16(VoxelType::u16, size, Affine3d{}, -1.0, 900.0);
            ScalarGrid f32(VoxelType::f32, size, Affine3d{}, 1.7, 3.0);
            for (std::size_t v = 0; v < i16.voxel_count(); ++v) {
                const int value = i16.voxels<std::int16_t>()[v];
                u8.voxels<std::uint8_t>()[v] = static_cast<std::uint8_t>(value / 4);
                u16.voxels<std::uint16_t>()[v] = static_cast<std::uint16_t>(value);
                f32.voxels<float>()[v] =
                    v % 97 == 5 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(value) * 0.61F;
            }
            expect_same(u8, tf);
            expect_same(u16, tf);
            expect_same(f32, tf);
        }
    EXPECT_GT(cases_with_extinction, 400);
}

TEST(ClassifyBlock, LargestSumsFit)
{
    // Hundreds of rows of the largest extinction a level voxel: more than 32 bits hold.
    const ScalarGrid volume = fill_i16({64, 64, 32}, Affine3d{}, [](double, double, double) { return 1000.0; });
    for (const int level : {3, 4, 5})
        for (const ClassifyBlock block : {classify_block_baseline, widest_classify_block()}) {
            ExtinctionGrid grid;
            classify_with(block, grid, volume, raw_range(volume), TransferFunction({{0.0, 0.0}, {1000.0, 2.0}}), level,
                          ExtinctionLayouts::straight);
            EXPECT_EQ(total(grid), 255.0 * static_cast<double>(grid.stored.size())) << "level " << level;
        }
}

TEST(ClassifyBlock, FloatsFollowTheTransferFunctionWithinItsSegments)
{
    // Far points, steps, points close together, and values far outside of them.
    const TransferFunction tf(
        {{-1e30, 0.0}, {-2.0, 0.0}, {-1.0, 7.0}, {0.25, 7.0}, {0.25, 1.0}, {0.2501, 9.0}, {3.0, 2.0}});
    std::mt19937 random(3);
    const Vec3i size{50, 40, 30};
    ScalarGrid volume(VoxelType::f32, size, Affine3d{}, 0.5, -0.125);
    float* voxels = volume.voxels<float>();
    for (std::size_t i = 0; i < volume.voxel_count(); ++i)
        voxels[i] = std::normal_distribution<float>(0.0F, 4.0F)(random);
    voxels[0] = 3e38F;
    voxels[1] = -3e38F;
    voxels[2] = 0.75F; // 0.25: the upper side of the step
    const ExtinctionGrid grid = classified(volume, tf);
    ASSERT_GT(grid.scale, 0.0F);
    for (std::size_t i = 0; i < volume.voxel_count(); ++i) {
        const double steps =
            tf.evaluate(0.5 * static_cast<double>(voxels[i]) - 0.125).extinction / static_cast<double>(grid.scale);
        const double slack = 1.0 + 0.02; // the steepest flank rises by 2e6 steps a unit, and values round to 1e-8 there
        ASSERT_NEAR(grid.stored[i], steps, slack) << voxels[i];
    }
}

TEST(ClassifyBlock, HostileRanges)
{
    ScalarGrid volume(VoxelType::f32, {5, 1, 1}, Affine3d{}, 1e30, -1e300);
    const float voxels[] = {3e38F, -3e38F, 1e-45F, 0.0F, 1.0F};
    std::copy(std::begin(voxels), std::end(voxels), volume.voxels<float>());
    const ExtinctionGrid beyond = classified(volume, TransferFunction({{0.0, 0.0}, {1.0, 1e30}}));
    EXPECT_LE(beyond.scale * 255.0F, 1.001e30F);

    ScalarGrid constant(VoxelType::i16, {3, 3, 3}, Affine3d{});
    std::fill_n(constant.voxels<std::int16_t>(), 27, std::int16_t{-32768});
    const ExtinctionGrid full = classified(constant, TransferFunction({{-32768.0, 1e-30}, {0.0, 1e30}}));
    EXPECT_EQ(std::count(full.stored.begin(), full.stored.end(), 255), 27);
    EXPECT_FLOAT_EQ(full.scale, 1e-30F / 255.0F);
    EXPECT_EQ(classified(constant, TransferFunction({{-32768.0, 1e-60}})).scale, 0.0F); // below single precision
    std::fill_n(constant.voxels<std::int16_t>(), 27, std::int16_t{32767});
    EXPECT_EQ(total(classified(constant, TransferFunction({{0.0, 0.0}, {32767.0, 2.0}}))), 27.0 * 255.0);
    EXPECT_EQ(total(classified(constant, TransferFunction({{0.0, 0.0}, {32768.0, 2.0}, {1e9, 0.0}}))), 27.0 * 255.0);
}

} // namespace
} // namespace lumisweep
