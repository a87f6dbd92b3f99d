// Majorants bound the extinction that kernels find, everywhere in their cells.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lumisweep/volume/grid_view.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/transfer_function_view.h"

namespace lumisweep {
namespace {

template <class T>
GridView<T> view_of(const ScalarGrid& grid)
{
    const Vec3i n = grid.size();
    return {grid.voxels<T>(), n.x, n.y, n.z, n.y > 1 ? n.x : 0, n.z > 1 ? n.x * n.y : 0, n.x > 1 ? 1 : 0};
}

/// Fills a grid at random, then looks everywhere at random, on cell borders too.
template <class T, class Value>
void expect_bounded(VoxelType type, Vec3i size, double slope, double intercept, const TransferFunction& tf,
                    Value&& value)
{
    ScalarGrid grid(type, size, Affine3d{}, slope, intercept);
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<T>()[i] = static_cast<T>(value());
    const MajorantGrid majorants(BoundsGrid(grid), tf);
    const MajorantView m = majorants.view();
    ASSERT_EQ(m.nx, (size.x + majorant_cell - 1) / majorant_cell);
    const TransferFunctionView lookup = tf.view(slope, intercept);
    const GridView<T> voxels = view_of<T>(grid);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform;
    double tightest = 0.0;
    for (int i = 0; i < 40000; ++i) {
        Vec3f p{uniform(random) * static_cast<float>(size.x), uniform(random) * static_cast<float>(size.y),
                uniform(random) * static_cast<float>(size.z)};
        if (i % 4 == 0) // on cell borders and voxel centres: either neighbour's majorant must do
            p = {std::round(p.x * 2.0F) * 0.5F, std::round(p.y * 2.0F) * 0.5F, std::round(p.z * 2.0F) * 0.5F};
        const float extinction = extinction_at(lookup, trilinear(voxels, p));
        ASSERT_GE(extinction, 0.0F);
        for (const float shift : {-1e-5F, 1e-5F}) {
            const auto cell = [&](float q, int n) {
                return std::clamp(static_cast<int>(std::floor((q + shift) / majorant_cell)), 0, n - 1);
            };
            const float bound = m.majorant[(cell(p.z, m.nz) * m.ny + cell(p.y, m.ny)) * m.nx + cell(p.x, m.nx)];
            ASSERT_LE(extinction, bound) << p.x << " " << p.y << " " << p.z;
            if (bound > 0.0F)
                tightest = std::max(tightest, double(extinction) / bound);
        }
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
    EXPECT_GT(bounds.low(0), bounds.high(0));
    const MajorantGrid majorants(bounds, TransferFunction({{0.0, 5.0}}));
    for (int i = 0; i < 27; ++i)
        EXPECT_EQ(majorants.view().majorant[i], 0.0F);
}

TEST(MajorantGridTest, HugeValuesStayBounded)
{
    std::mt19937 random(6);
    const TransferFunction tf({{-1.0, 0.5}, {1.0, 2.0}});
    expect_bounded<float>(VoxelType::f32, {9, 9, 9}, 1.0, 0.0, tf, [&] { return random() % 2 == 0 ? 3e38F : -3e38F; });
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
