#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include <tbb/task_arena.h>

#include "generated_volumes.h"
#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

using namespace test;

double total(const ExtinctionGrid& grid) { return std::accumulate(grid.stored.begin(), grid.stored.end(), 0.0); }

TEST(Classify, ScaleComesFromTheLargestExtinctionPresent)
{
    // The transfer function's peak at 500 occurs nowhere in the volume.
    ScalarGrid volume(VoxelType::u8, {3, 1, 1}, Affine3d{}, 10.0, -100.0);
    volume.voxels<std::uint8_t>()[0] = 10;  // 0
    volume.voxels<std::uint8_t>()[1] = 20;  // 100
    volume.voxels<std::uint8_t>()[2] = 110; // 1000
    const TransferFunction tf({{0.0, 0.0}, {100.0, 2.0}, {500.0, 80.0}, {1000.0, 1.0}}, 3.0);
    const ExtinctionPyramid pyramid = classify(volume, tf, 0);
    EXPECT_NEAR(pyramid.scale * 255.0F, 6.0F, 1e-5F);
    EXPECT_EQ(pyramid.levels[0].stored[0], 0);
    EXPECT_EQ(pyramid.levels[0].stored[1], 255);
    EXPECT_NEAR(pyramid.levels[0].stored[2], 127.5, 0.51);
}

TEST(Classify, AllVoxelTypesAgree)
{
    const Vec3i size{7, 5, 3};
    const TransferFunction tf({{0.0, 0.0}, {200.0, 5.0}});
    const auto fill = [&](VoxelType type, auto zero) {
        ScalarGrid grid(type, size, Affine3d{});
        using T = decltype(zero);
        for (std::size_t i = 0; i < grid.voxel_count(); ++i)
            grid.voxels<T>()[i] = static_cast<T>(i * 37 % 199);
        return classify(grid, tf, 1);
    };
    const ExtinctionPyramid u8 = fill(VoxelType::u8, std::uint8_t{}), u16 = fill(VoxelType::u16, std::uint16_t{});
    const ExtinctionPyramid i16 = fill(VoxelType::i16, std::int16_t{}), f32 = fill(VoxelType::f32, float{});
    for (const ExtinctionPyramid* other : {&u16, &i16, &f32}) {
        EXPECT_FLOAT_EQ(other->scale, u8.scale);
        for (std::size_t l = 0; l < 2; ++l)
            EXPECT_TRUE(
                std::equal(u8.levels[l].stored.begin(), u8.levels[l].stored.end(), other->levels[l].stored.begin()));
    }
    EXPECT_EQ(u8.bytes(), 7U * 5 * 3 + 4U * 3 * 2);
}

TEST(Classify, DitherKeepsThinMediaOnAverage)
{
    // One opaque voxel sets the scale; the rest is a tenth of a step, which rounding would lose.
    const Vec3i size{64, 64, 16};
    ScalarGrid volume = fill_i16(size, Affine3d{}, [](double, double, double) { return 1.0; });
    volume.voxels<std::int16_t>()[0] = 2550;
    const ExtinctionPyramid pyramid = classify(volume, TransferFunction({{0.0, 0.0}, {2550.0, 255.0}}), 2);
    const double count = static_cast<double>(volume.voxel_count()) - 1.0;
    // Standard error of the mean of a 0/1 variable with p = 0.1 over 65535 voxels: 0.0012.
    EXPECT_NEAR((total(pyramid.levels[0]) - 255.0) / count, 0.1, 0.005);
    EXPECT_NEAR((8.0 * total(pyramid.levels[1]) - 255.0) / count, 0.1, 0.01);
    EXPECT_NEAR((64.0 * total(pyramid.levels[2]) - 255.0) / count, 0.1, 0.03);
}

TEST(Classify, MipsKeepExtinctionTimesLengthAtOddEnds)
{
    const Vec3i size{5, 7, 9};
    const ExtinctionPyramid fine = homogeneous(size, Affine3d{}, 2.0);
    const ScalarGrid volume = fill_i16(size, Affine3d{}, [](double, double, double) { return 7.0; });
    const ExtinctionPyramid pyramid = classify(volume, TransferFunction({{7.0, 2.0}}), 4);
    ASSERT_EQ(pyramid.levels.size(), 5U);
    EXPECT_EQ(pyramid.levels[1].size, (Vec3i{3, 4, 5}));
    EXPECT_EQ(pyramid.levels[2].size, (Vec3i{2, 2, 3}));
    EXPECT_EQ(pyramid.levels[4].size, (Vec3i{1, 1, 1}));
    EXPECT_EQ(pyramid.levels[1].stored[0], 255);
    EXPECT_NEAR(pyramid.levels[1].stored[2], 127.5, 0.51); // one of two voxels along x is missing
    EXPECT_NEAR(8.0 * total(pyramid.levels[1]), total(fine.levels[0]), 8.0 * 0.5 * 3 * 4 * 5);
}

TEST(Classify, NonFiniteVoxelsAndNoExtinctionAreEmpty)
{
    ScalarGrid volume(VoxelType::f32, {4, 1, 1}, Affine3d{});
    float* v = volume.voxels<float>();
    v[0] = std::numeric_limits<float>::quiet_NaN();
    v[1] = std::numeric_limits<float>::infinity();
    v[2] = 1.0F;
    v[3] = -std::numeric_limits<float>::infinity();
    const ExtinctionPyramid pyramid = classify(volume, TransferFunction({{0.0, 3.0}}), 0);
    EXPECT_EQ(pyramid.levels[0].stored[0], 0);
    EXPECT_EQ(pyramid.levels[0].stored[1], 0);
    EXPECT_EQ(pyramid.levels[0].stored[2], 255);
    EXPECT_EQ(pyramid.levels[0].stored[3], 0);
    EXPECT_EQ(classify(volume, TransferFunction({{0.0, 0.0}}), 0).scale, 0.0F);
}

TEST(Classify, SameForAnyNumberOfThreads)
{
    const ScalarGrid volume = smoke_like({33, 21, 17}, Affine3d{});
    const ExtinctionPyramid expected = classify(volume, smoke(), 2);
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        const ExtinctionPyramid pyramid = arena.execute([&] { return classify(volume, smoke(), 2); });
        EXPECT_EQ(pyramid.scale, expected.scale);
        for (std::size_t l = 0; l < 3; ++l)
            EXPECT_TRUE(std::equal(expected.levels[l].stored.begin(), expected.levels[l].stored.end(),
                                   pyramid.levels[l].stored.begin()));
    }
}

TEST(Classify, RefusesImpossibleLevels)
{
    const ScalarGrid volume = smoke_like({4, 4, 4}, Affine3d{});
    EXPECT_THROW(classify(volume, smoke(), -1), Error);
    EXPECT_THROW(classify(volume, smoke(), 99), Error);
}

} // namespace
} // namespace lumisweep
