#include "lumisweep/volume/scalar_grid.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

ScalarGrid random_grid(VoxelType type, Vec3i size, unsigned seed)
{
    ScalarGrid grid(type, size, Affine3d{}, 0.5, -3.0);
    std::mt19937 random(seed);
    for (std::size_t i = 0; i < grid.bytes() / (type == VoxelType::f32 ? 4 : 1); ++i)
        if (type == VoxelType::f32)
            grid.voxels<float>()[i] = float(random()) / 1e6F;
        else
            grid.data()[i] = std::byte(random() & 255);
    return grid;
}

TEST(ScalarGrid, RefusesBadSizesAndMaps)
{
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {0, 1, 1}, {}), Error);
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {1, -1, 1}, {}), Error);
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {8193, 1, 1}, {}), Error);
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {2048, 2048, 512}, {}), Error); // 2^31
    EXPECT_NO_THROW(ScalarGrid(VoxelType::u8, {8192, 1, 1}, {}));
    Affine3d singular;
    singular.column[2] = {1, 1, 0};
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {2, 2, 2}, singular), Error);
    Affine3d infinite;
    infinite.offset.x = INFINITY;
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {2, 2, 2}, infinite), Error);
    Affine3d micrometres; // small, not singular
    for (int i = 0; i < 3; ++i)
        micrometres.column[std::size_t(i)] = micrometres.column[std::size_t(i)] * 1e-6;
    EXPECT_NO_THROW(ScalarGrid(VoxelType::u8, {2, 2, 2}, micrometres));
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {2, 2, 2}, {}, 0.0), Error);
    EXPECT_THROW(ScalarGrid(VoxelType::u8, {2, 2, 2}, {}, 1.0, nan), Error);
}

TEST(ScalarGrid, ValuesInDataUnits)
{
    ScalarGrid grid(VoxelType::i16, {3, 2, 2}, {}, 2.0, -1024.0);
    grid.voxels<std::int16_t>()[2 + 3 * (1 + 2 * 1)] = -7;
    EXPECT_EQ(grid.value(2, 1, 1), -1038.0);
    EXPECT_EQ(grid.value(0, 0, 0), -1024.0);
    EXPECT_EQ(grid.voxel_count(), 12U);
    EXPECT_EQ(grid.bytes(), 24U);
    ScalarGrid large(VoxelType::u16, {1, 1, 1}, {});
    large.voxels<std::uint16_t>()[0] = 65535;
    EXPECT_EQ(large.value(0, 0, 0), 65535.0);
}

TEST(ScalarGrid, InverseMapUndoesTheMap)
{
    Affine3d map;
    map.column = {{{0, 2, 0.1}, {-3, 0, 0.5}, {0.2, 0.3, 4}}};
    map.offset = {10, -20, 30};
    const ScalarGrid grid(VoxelType::u8, {4, 4, 4}, map);
    const Vec3d p = grid.voxel_from_world().point(grid.world_from_voxel().point({1.25, 2.5, 3.75}));
    EXPECT_NEAR(p.x, 1.25, 1e-12);
    EXPECT_NEAR(p.y, 2.5, 1e-12);
    EXPECT_NEAR(p.z, 3.75, 1e-12);
}

TEST(ScalarGrid, InterpolationMeetsTheVoxelsAtTheirCentres)
{
    for (VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::i16, VoxelType::f32}) {
        const ScalarGrid grid = random_grid(type, {5, 4, 3}, 7);
        for (int k = 0; k < 3; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 5; ++i)
                    EXPECT_DOUBLE_EQ(grid.interpolate({i + 0.5, j + 0.5, k + 0.5}), grid.value(i, j, k));
    }
}

TEST(ScalarGrid, InterpolationIsExactForTrilinearFunctions)
{
    const auto f = [](double x, double y, double z) {
        return 3 + x - 2 * y + 0.5 * z + x * y - y * z + 0.25 * x * y * z;
    };
    ScalarGrid grid(VoxelType::f32, {4, 5, 6}, {});
    for (int k = 0; k < 6; ++k)
        for (int j = 0; j < 5; ++j)
            for (int i = 0; i < 4; ++i)
                grid.voxels<float>()[i + 4 * (j + 5 * k)] = float(f(i + 0.5, j + 0.5, k + 0.5));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int n = 0; n < 1000; ++n) {
        const Vec3d p{0.5 + 3 * unit(random), 0.5 + 4 * unit(random), 0.5 + 5 * unit(random)};
        EXPECT_NEAR(grid.interpolate(p), f(p.x, p.y, p.z), 1e-5);
    }
}

TEST(ScalarGrid, OutsideTheCentresTheEdgeVoxelHolds)
{
    const ScalarGrid grid = random_grid(VoxelType::u8, {3, 3, 3}, 11);
    EXPECT_DOUBLE_EQ(grid.interpolate({0, 0, 0}), grid.value(0, 0, 0));
    EXPECT_DOUBLE_EQ(grid.interpolate({3, 3, 3}), grid.value(2, 2, 2));
    EXPECT_DOUBLE_EQ(grid.interpolate({-1e9, 1.5, INFINITY}), grid.value(0, 1, 2));
    EXPECT_TRUE(std::isnan(grid.interpolate({nan, 1, 1})));
    const ScalarGrid flat = random_grid(VoxelType::u8, {3, 1, 1}, 11);
    EXPECT_DOUBLE_EQ(flat.interpolate({2.0, 0.9, 0.1}), 0.5 * (flat.value(1, 0, 0) + flat.value(2, 0, 0)));
}

TEST(ScalarGrid, NonFiniteVoxelsBecomeNanAndSpreadToTheirCells)
{
    ScalarGrid grid(VoxelType::f32, {6, 1, 1}, {});
    const float inf = std::numeric_limits<float>::infinity();
    const float values[] = {5, 6, -inf, std::nanf(""), 7, 8};
    std::copy(values, values + 6, grid.voxels<float>());
    EXPECT_EQ(grid.mark_non_finite(), 2U);
    EXPECT_TRUE(std::isnan(grid.value(2, 0, 0)));
    for (double x : {1.75, 2.5, 3.0, 4.25})
        EXPECT_TRUE(std::isnan(grid.interpolate({x, 0.5, 0.5}))) << x;
    EXPECT_EQ(grid.interpolate({0.25, 0.5, 0.5}), 5.0);
    EXPECT_EQ(grid.interpolate({1.0, 0.5, 0.5}), 5.5);
    EXPECT_EQ(grid.interpolate({5.0, 0.5, 0.5}), 7.5);
    EXPECT_EQ(grid.interpolate({5.75, 0.5, 0.5}), 8.0);
    EXPECT_EQ(random_grid(VoxelType::u8, {3, 3, 3}, 1).mark_non_finite(), 0U);
}

TEST(ScalarGrid, VisitCallsTheTypeOfTheVoxels)
{
    const auto size_of_voxel = [](VoxelType type) {
        return visit_voxels(ScalarGrid(type, {1, 1, 1}, {}), [](const auto* v) { return sizeof(*v); });
    };
    for (VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::i16, VoxelType::f32})
        EXPECT_EQ(size_of_voxel(type), size_of(type));
}

} // namespace
} // namespace lumisweep
