// Majorants bound the extinction that kernels find, everywhere in their cells.
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "lumisweep/volume/grid_view.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/majorant_view.h"
#include "lumisweep/volume/transfer_function_view.h"
#include "support/volumes.h"

namespace lumisweep {
namespace {

using test::view_of;

float bound_at(const MajorantView& m, int x, int y, int z) { return majorant_at<float>(m, {x, y, z}).value; }

/// Fills a grid at random, then looks everywhere in its cells at random, on their sides, edges and corners too.
template <class T, class Value>
void expect_bounded(VoxelType type, Vec3i size, double slope, double intercept, const TransferFunction& tf,
                    Value&& value)
{
    ScalarGrid grid(type, size, Affine3d{}, slope, intercept);
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<T>()[i] = static_cast<T>(value());
    const MajorantGrid majorants(BoundsGrid(grid), tf);
    const MajorantView m = majorants.view();
    ASSERT_EQ(m.size.x, size.x / majorant_cell + 1);
    const TransferFunctionView lookup = tf.view(slope, intercept);
    const GridView<T> voxels = view_of<T>(grid);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform;
    double tightest = 0.0;
    for (int i = 0; i < 40000; ++i) {
        int cell[3];
        float p[3];
        for (int axis = 0; axis < 3; ++axis) {
            const auto n = static_cast<float>(component(size, axis));
            cell[axis] = static_cast<int>(random() % static_cast<unsigned>(component(m.size, axis)));
            const float low = static_cast<float>(cell[axis] * majorant_cell) - 0.5F;
            const unsigned where = random() % 8; // also on the sides: the cells on both must bound those
            const float t = where == 0 ? 0.0F : where == 1 ? 1.0F : uniform(random);
            p[axis] = std::clamp(low + t * static_cast<float>(majorant_cell), 0.0F, n);
        }
        const float extinction = extinction_at(lookup, trilinear(voxels, Vec3f{p[0], p[1], p[2]}));
        ASSERT_GE(extinction, 0.0F);
        const float bound = bound_at(m, cell[0], cell[1], cell[2]);
        ASSERT_LE(extinction, bound) << p[0] << " " << p[1] << " " << p[2];
        if (bound > 0.0F)
            tightest = std::max(tightest, double(extinction) / bound);
    }
    EXPECT_GT(tightest, 0.5); // the bounds are not far above either
}

const TransferFunction& steep()
{
    static const TransferFunction tf({{-500.0, 0.0},
                                      {-100.0, 0.3},
                                      {-99.0, 4.0},
                                      {50.0, 0.1},
                                      {50.0, 9.0},
                                      {300.0, 9.0},
                                      {301.0, 0.0},
                                      {900.0, 2.0}});
    return tf;
}

TEST(MajorantGridTest, BoundsTheKernelsExtinction)
{
    std::mt19937 random(8);
    for (const Vec3i& size :
         {Vec3i{16, 16, 16}, Vec3i{13, 9, 22}, Vec3i{1, 17, 5}, Vec3i{6, 1, 1}, Vec3i{1, 1, 1}, Vec3i{4, 5, 1}}) {
        const auto hu = [&] { return static_cast<int>(random() % 1600) - 700; };
        // A single voxel needs a value with extinction for the bound to be judged.
        const auto solid = [&] { return size.x * size.y * size.z == 1 ? 200 : hu(); };
        expect_bounded<std::int16_t>(VoxelType::i16, size, 1.0, 0.0, steep(), solid);
        expect_bounded<std::int16_t>(VoxelType::i16, size, -1.0, 100.0, steep(), [&] { return 100 - solid(); });
        expect_bounded<std::uint8_t>(VoxelType::u8, size, 5.0, -400.0, steep(), [&] { return (solid() + 700) / 8; });
        expect_bounded<std::uint16_t>(VoxelType::u16, size, 0.025, -500.0, steep(),
                                      [&] { return (solid() + 500) * 40 < 0 ? 0 : (solid() + 700) * 30; });
        expect_bounded<float>(VoxelType::f32, size, 0.3, 7.0, steep(), [&] { return (solid() - 7.0) / 0.3; });
    }
}

TEST(MajorantGridTest, ConstantVolumesAtSteps)
{
    // The one value is exactly a step's: the kernels and the bound must see the same side, or the higher one.
    for (const double v : {0.1, 0.7, 50.0, 1.0 / 3.0, -1e-3, 12345.678})
        for (const double slope : {1.0, 0.1, -0.7}) {
            const TransferFunction tf({{v, 0.5}, {v, 2.0}});
            const auto raw = static_cast<float>(v / slope);
            expect_bounded<float>(VoxelType::f32, {6, 5, 7}, slope, 0.0, tf, [&] { return raw; });
        }
}

TEST(MajorantGridTest, NotANumberIsEmpty)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::mt19937 random(6);
    expect_bounded<float>(VoxelType::f32, {13, 9, 22}, 1.0, 0.0, steep(),
                          [&] { return random() % 8 == 0 ? nan : static_cast<float>(random() % 1600) - 700.0F; });
    ScalarGrid grid(VoxelType::f32, {9, 9, 9}, Affine3d{});
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<float>()[i] = nan;
    const BoundsGrid bounds(grid);
    EXPECT_TRUE(bounds.whole().range.empty());
    const MajorantGrid majorants(bounds, TransferFunction({{0.0, 5.0}}));
    for (int i = 0; i < 125; ++i)
        EXPECT_EQ(bound_at(majorants.view(), i % 5, i / 5 % 5, i / 25), 0.0F);
}

TEST(MajorantGridTest, HugeValuesStayBounded)
{
    std::mt19937 random(6);
    const TransferFunction tf({{-1.0, 0.5}, {1.0, 2.0}});
    expect_bounded<float>(VoxelType::f32, {9, 9, 9}, 1.0, 0.0, tf, [&] { return random() % 2 == 0 ? 3e38F : -3e38F; });
}

// Single precision is rounded to 65536 steps: values that lie between steps, and a range that one huge voxel spoils.
TEST(MajorantGridTest, SinglePrecisionIsRoundedOutwards)
{
    std::mt19937 random(31);
    std::uniform_real_distribution<float> uniform;
    const TransferFunction tf({{0.2, 0.0}, {0.25, 5.0}, {0.9, 1.0}, {0.9, 3.0}, {0.95, 0.0}});
    expect_bounded<float>(VoxelType::f32, {13, 9, 11}, 1.0, 0.0, tf, [&] { return uniform(random); });
    int i = 0;
    expect_bounded<float>(VoxelType::f32, {13, 9, 11}, 1.0, 0.0, tf,
                          [&] { return ++i == 700 ? -1e30F : 0.9F + 0.02F * uniform(random); });
}

// Majorants against a search: a cell's is as tight as its code allows, a block's no larger than its largest cell's, and
// blocks have one only where that costs few tentative collisions.
TEST(MajorantGridTest, MajorantsAreAsTightAsTheirCodes)
{
    const Vec3i size{29, 14, 23};
    for (const double scale : {3.0, 0.3, 0.003}) {
        std::mt19937 random(5);
        ScalarGrid grid(VoxelType::i16, size, Affine3d{}, 1.0, 0.0);
        for (std::size_t i = 0; i < grid.voxel_count(); ++i) // a ramp along x, from empty to dense and back
            grid.voxels<std::int16_t>()[i] =
                static_cast<std::int16_t>(static_cast<int>(i % 29) * 40 - 700 + static_cast<int>(random() % 50));
        const TransferFunction tf(steep().points(), scale);
        const MajorantGrid majorants(BoundsGrid(grid), tf);
        const MajorantView m = majorants.view();
        int in_blocks = 0;
        for (int z = 0; z < m.size.z; ++z)
            for (int y = 0; y < m.size.y; ++y)
                for (int x = 0; x < m.size.x; ++x) {
                    const Majorant<float> majorant = majorant_at<float>(m, {x, y, z});
                    const int to = majorant.in_block ? majorant_block : 1;
                    double exact = 0.0;
                    for (int cz = z / to * to; cz < std::min(z / to * to + to, m.size.z); ++cz)
                        for (int cy = y / to * to; cy < std::min(y / to * to + to, m.size.y); ++cy)
                            for (int cx = x / to * to; cx < std::min(x / to * to + to, m.size.x); ++cx) {
                                int low = 32767, high = -32768;
                                for (int k = std::max(std::min(2 * cz - 1, size.z - 2), 0);
                                     k <= std::min(2 * cz + 1, size.z - 1); ++k)
                                    for (int j = std::max(std::min(2 * cy - 1, size.y - 2), 0);
                                         j <= std::min(2 * cy + 1, size.y - 1); ++j)
                                        for (int i = std::max(std::min(2 * cx - 1, size.x - 2), 0);
                                             i <= std::min(2 * cx + 1, size.x - 1); ++i) {
                                            const int v = grid.voxels<std::int16_t>()[(k * size.y + j) * size.x + i];
                                            low = std::min(low, v), high = std::max(high, v);
                                        }
                                exact = std::max(exact, tf.max_extinction(low, high));
                            }
                    EXPECT_GE(double(majorant.value), exact);
                    EXPECT_LE(double(majorant.value), exact * (1.0 + 1.0 / 16.0) + scale * 1e-3);
                    in_blocks += majorant.in_block ? 1 : 0;
                }
        const int cells = m.size.x * m.size.y * m.size.z;
        EXPECT_LT(in_blocks, scale == 3.0 ? cells / 2 : cells + 1);
        EXPECT_GE(in_blocks, scale == 0.003 ? cells : 0);
    }
}

// Distances of empty blocks against a search: all blocks that are nearer are empty, and one that far is not.
TEST(MajorantGridTest, EmptySpaceIsMeasuredExactly)
{
    std::mt19937 random(77);
    for (const Vec3i& size : {Vec3i{64, 50, 70}, Vec3i{300, 9, 9}, Vec3i{7, 1, 90}, Vec3i{20, 20, 20}})
        for (const int voxels : {0, 1, 3, 40}) {
            ScalarGrid grid(VoxelType::u8, size, Affine3d{});
            for (int i = 0; i < voxels; ++i)
                grid.voxels<std::uint8_t>()[random() % grid.voxel_count()] = 200;
            const MajorantGrid majorants(BoundsGrid(grid), TransferFunction({{100.0, 0.0}, {200.0, 1.0}}));
            const MajorantView m = majorants.view();
            std::vector<Vec3i> occupied; // blocks
            for (int z = 0; z < m.size.z; ++z)
                for (int y = 0; y < m.size.y; ++y)
                    for (int x = 0; x < m.size.x; ++x)
                        if (bound_at(m, x, y, z) > 0.0F)
                            occupied.push_back({x / majorant_block, y / majorant_block, z / majorant_block});
            ASSERT_EQ(occupied.empty(), voxels == 0);
            for (int z = 0; z < m.size.z; ++z)
                for (int y = 0; y < m.size.y; ++y)
                    for (int x = 0; x < m.size.x; ++x) {
                        int nearest = first_majorant_code - 1;
                        for (const Vec3i& b : occupied)
                            nearest = std::min(nearest, std::max({std::abs(b.x - x / majorant_block),
                                                                  std::abs(b.y - y / majorant_block),
                                                                  std::abs(b.z - z / majorant_block)}));
                        const Majorant<float> majorant = majorant_at<float>(m, {x, y, z});
                        if (nearest > 0) {
                            ASSERT_TRUE(majorant.in_block);
                            ASSERT_EQ(majorant.value, 0.0F);
                            ASSERT_EQ(majorant.distance, nearest);
                        } else if (majorant.in_block) {
                            ASSERT_EQ(majorant.distance, 1);
                        }
                    }
        }
}

// Thin media have lower bounds, too: nowhere above the extinction that kernels find, and not far below everywhere.
TEST(MajorantGridTest, ThinMediaHaveLowerBounds)
{
    std::mt19937 random(15);
    std::uniform_real_distribution<float> uniform;
    const Vec3i size{13, 9, 22};
    const auto scaled = [](double side) {
        Affine3d a;
        for (Vec3d& column : a.column)
            column = column * side;
        return a;
    };
    for (const TransferFunction& tf :
         {TransferFunction({{0.0, 0.1}, {0.5, 0.4}, {0.5, 0.3}, {1.0, 1.0}}), TransferFunction({{0.0, 0.7}})}) {
        ScalarGrid grid(VoxelType::f32, size, Affine3d{}), opaque(VoxelType::f32, size, scaled(60.0));
        for (std::size_t i = 0; i < grid.voxel_count(); ++i)
            grid.voxels<float>()[i] = opaque.voxels<float>()[i] = uniform(random);
        EXPECT_EQ(MajorantGrid(BoundsGrid(opaque), tf).view().smallest, nullptr);
        const MajorantGrid majorants(BoundsGrid(grid), tf);
        const MajorantView m = majorants.view();
        ASSERT_NE(m.smallest, nullptr);
        const TransferFunctionView lookup = tf.view(1.0, 0.0);
        const GridView<float> voxels = view_of<float>(grid);
        double tightest = 0.0;
        for (int i = 0; i < 100000; ++i) {
            const Vec3f p{uniform(random) * 13.0F, uniform(random) * 9.0F, uniform(random) * 22.0F};
            const CellXYZ<float> cell = cell_at(m, p);
            const float bound = static_cast<float>(m.smallest[block_of_cell(m, cell)]) * m.largest / 256.0F;
            const float extinction = extinction_at(lookup, trilinear(voxels, p));
            ASSERT_LE(bound, extinction);
            ASSERT_LT(bound, majorant_at<float>(m, cell).value);
            tightest = std::max(tightest, double(bound) / extinction);
        }
        EXPECT_GT(tightest, 0.95);
        grid.voxels<float>()[77] = std::numeric_limits<float>::quiet_NaN();
        EXPECT_EQ(MajorantGrid(BoundsGrid(grid), tf).view().smallest, nullptr);
    }
}

TEST(GridViewTest, TrilinearEqualsTheOracle)
{
    std::mt19937 random(12);
    std::uniform_real_distribution<float> uniform(-0.2F, 1.2F);
    for (const Vec3i& size : {Vec3i{7, 5, 9}, Vec3i{1, 4, 3}, Vec3i{3, 1, 4}, Vec3i{4, 3, 1}, Vec3i{1, 1, 1}}) {
        ScalarGrid grid(VoxelType::i16, size, Affine3d{}, 0.5, 3.0);
        for (std::size_t i = 0; i < grid.voxel_count(); ++i)
            grid.voxels<std::int16_t>()[i] = static_cast<std::int16_t>(random());
        const GridView<std::int16_t> view = view_of<std::int16_t>(grid);
        for (int i = 0; i < 2000; ++i) {
            const Vec3f p{uniform(random) * static_cast<float>(size.x), uniform(random) * static_cast<float>(size.y),
                          uniform(random) * static_cast<float>(size.z)};
            const ValueAndGradient<float> both = trilinear_gradient(view, p);
            EXPECT_NEAR(trilinear(view, p) * 0.5 + 3.0, grid.interpolate(to_double(p)), 0.05);
            EXPECT_EQ(both.value, trilinear(view, p));
            // Central differences of the oracle, where both sides are within one cell of centres.
            const double h = 1e-3;
            for (int axis = 0; axis < 3; ++axis) {
                const double q = component(p, axis) - 0.5;
                if (q < 0.01 || q > component(size, axis) - 1.01 || std::fabs(q - std::round(q)) < 0.01)
                    continue;
                Vec3d low = to_double(p), high = low;
                component(low, axis) -= h, component(high, axis) += h;
                EXPECT_NEAR(component(both.gradient, axis) * 0.5,
                            (grid.interpolate(high) - grid.interpolate(low)) / (2.0 * h), 0.5);
            }
        }
    }
}

} // namespace
} // namespace lumisweep
