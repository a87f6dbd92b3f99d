// Bounds of the data are strict however voxels in single precision round, and fill values cost no empty space.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
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

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/// A position along an axis of n voxels, often on or next to a voxel's centre, where a fraction is near 0 or 1. Every
/// other centre is a cell's border.
float position(std::mt19937& random, int n)
{
    std::uniform_real_distribution<float> uniform;
    const unsigned how = random() % 8;
    const float centre = static_cast<float>(random() % static_cast<unsigned>(n)) + 0.5F;
    const float p = how == 0   ? uniform(random) * static_cast<float>(n)
                    : how == 1 ? centre
                    : how < 5  ? std::nextafter(centre, how == 2 ? infinity : 0.0F)
                               : centre + std::ldexp(uniform(random) - 0.5F, -static_cast<int>(random() % 20));
    return std::clamp(p, 0.0F, static_cast<float>(n));
}

/// Lookups as renderers do them, each against all cells that touch its position: rays clamp to either.
template <class T>
void expect_strict(const ScalarGrid& grid, const TransferFunction& tf, int lookups)
{
    const MajorantGrid majorants(BoundsGrid(grid), tf);
    const MajorantView m = majorants.view();
    const TransferFunctionView lookup = tf.view(grid.slope(), grid.intercept());
    const GridView<T> voxels = view_of<T>(grid);
    std::mt19937 random(44);
    double above = 0.0, below = 0.0, at = 0.0;
    for (int i = 0; i < lookups; ++i) {
        const Vec3f anywhere{position(random, grid.size().x), position(random, grid.size().y),
                             position(random, grid.size().z)};
        const CellXYZ<float> cell = cell_at(m, anywhere);
        // Finding the cell may round across its side; lookups are clamped to it.
        const auto within = [](float x, int c) {
            const float low = static_cast<float>(c * majorant_cell) - 0.5F;
            return std::clamp(x, low, low + static_cast<float>(majorant_cell));
        };
        const Vec3f p{within(anywhere.x, cell.x), within(anywhere.y, cell.y), within(anywhere.z, cell.z)};
        const float extinction = extinction_at(lookup, trilinear(voxels, p));
        const auto others = [](float x, int c) { // the cell on the other side of a border, too
            return x == static_cast<float>(c * majorant_cell) - 0.5F && c > 0 ? c - 1 : c;
        };
        for (int z = others(p.z, cell.z); z <= cell.z; ++z)
            for (int y = others(p.y, cell.y); y <= cell.y; ++y)
                for (int x = others(p.x, cell.x); x <= cell.x; ++x) {
                    const float bound = majorant_at<float>(m, {x, y, z}).value;
                    if (extinction > bound && extinction - bound > above) {
                        above = extinction - bound;
                        at = bound;
                    }
                    if (m.smallest != nullptr) {
                        const int block = block_of_cell<float>(m, {x, y, z});
                        const float smallest = static_cast<float>(m.smallest[block]) * m.largest / 256.0F;
                        below = std::max(below, static_cast<double>(smallest - extinction));
                    }
                }
    }
    EXPECT_EQ(above, 0.0) << "above a majorant of " << at;
    EXPECT_EQ(below, 0.0) << "below the least extinction of a block";
}

template <class T, class Value>
ScalarGrid filled(VoxelType type, Vec3i size, Value&& value, double slope = 1.0, double intercept = 0.0)
{
    ScalarGrid grid(type, size, Affine3d{}, slope, intercept);
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<T>()[i] = static_cast<T>(value());
    return grid;
}

// A voxel of a much larger number next to one of a small: rounding leaves the small one by the large one's rounding.
TEST(BoundsGridTest, TwoValuesOfUnlikeSize)
{
    std::mt19937 random(3);
    const ScalarGrid whole = filled<std::int16_t>(
        VoxelType::i16, {16, 16, 16}, [&] { return random() % 2 == 0 ? std::int16_t{-32768} : std::int16_t{5}; });
    expect_strict<std::int16_t>(whole, TransferFunction({{5.00005, 0.0}, {5.002, 100.0}}), 1000000);
    const ScalarGrid real =
        filled<float>(VoxelType::f32, {16, 16, 16}, [&] { return random() % 2 == 0 ? -333.3F : 0.001F; });
    expect_strict<float>(real, TransferFunction({{0.00100001, 0.0}, {0.00103, 100.0}}), 1000000);
}

struct Tightness {
    double empty = 0.0, mean = 0.0; ///< share of cells that are empty, mean majorant
};

Tightness tightness(const ScalarGrid& grid, const TransferFunction& tf)
{
    const MajorantGrid majorants(BoundsGrid(grid), tf);
    const MajorantView m = majorants.view();
    Tightness result;
    const double weight = 1.0 / (static_cast<double>(m.size.x) * m.size.y * m.size.z);
    for (int z = 0; z < m.size.z; ++z)
        for (int y = 0; y < m.size.y; ++y)
            for (int x = 0; x < m.size.x; ++x) {
                const float majorant = majorant_at<float>(m, {x, y, z}).value;
                result.mean += static_cast<double>(majorant) * weight;
                result.empty += majorant == 0.0F ? weight : 0.0;
            }
    return result;
}

/// Data from 0 to 1 within a ball that touches the volume's faces, `fill` outside.
ScalarGrid ball(Vec3i size, float fill)
{
    ScalarGrid grid(VoxelType::f32, size, Affine3d{});
    float* voxel = grid.voxels<float>();
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const auto along = [](int i, int n) {
                    return (2.0F * static_cast<float>(i) + 1.0F) / static_cast<float>(n) - 1.0F;
                };
                const float px = along(x, size.x), py = along(y, size.y), pz = along(z, size.z);
                const float r = std::sqrt(px * px + py * py + pz * pz);
                *voxel++ =
                    r >= 1.0F ? fill : std::max(0.0F, std::sin(9.0F * px) * std::cos(7.0F * py + pz) * (1.2F - r));
            }
    return grid;
}

/// The share of cells with voxels both of the fill value, that of the first voxel, and of data.
double mixed_cells(const ScalarGrid& grid)
{
    const Vec3i size = grid.size(), cells = majorant_cells(size);
    const float* voxels = grid.voxels<float>();
    int mixed = 0;
    for (int z = 0; z < cells.z; ++z)
        for (int y = 0; y < cells.y; ++y)
            for (int x = 0; x < cells.x; ++x) {
                int all = 0, data = 0;
                for (int k = std::max(std::min(2 * z - 1, size.z - 2), 0); k <= std::min(2 * z + 1, size.z - 1); ++k)
                    for (int j = std::max(std::min(2 * y - 1, size.y - 2), 0); j <= std::min(2 * y + 1, size.y - 1);
                         ++j)
                        for (int i = std::max(std::min(2 * x - 1, size.x - 2), 0); i <= std::min(2 * x + 1, size.x - 1);
                             ++i) {
                            const float v = voxels[(k * size.y + j) * size.x + i];
                            ++all, data += v >= 0.0F && v <= 1.2F ? 1 : 0;
                        }
                mixed += data > 0 && data < all ? 1 : 0;
            }
    return static_cast<double>(mixed) / (static_cast<double>(cells.x) * cells.y * cells.z);
}

TEST(BoundsGridTest, FillValuesCostNoEmptySpace)
{
    const TransferFunction tf({{0.0, 0.0}, {0.2, 0.0}, {0.3, 20.0}, {0.6, 4.0}, {0.6, 30.0}, {1.1, 3.0}, {1e3, 0.0}});
    // Of the second one any regular choice of few voxels sees one of its faces only.
    for (const Vec3i& size : {Vec3i{64, 64, 64}, Vec3i{64, 256, 256}}) {
        const Tightness plain = tightness(ball(size, 0.0F), tf);
        ASSERT_GT(plain.empty, 0.4);
        ASSERT_GT(plain.mean, 1.0);
        for (const float fill : {-1e30F, -9999.0F, 1e20F, not_a_number}) {
            SCOPED_TRACE(fill);
            const ScalarGrid grid = ball(size, fill);
            if (size.y == 64)
                expect_strict<float>(grid, tf, 200000);
            const Tightness with_fill = tightness(grid, tf);
            // Only cells that mix data and fill may lose.
            const double mixed = mixed_cells(grid);
            EXPECT_GE(with_fill.empty, plain.empty - mixed - 0.001);
            EXPECT_LE(with_fill.empty, plain.empty + mixed);
            EXPECT_LE(with_fill.mean, plain.mean * 1.01 + mixed * 32.0);
        }
    }
}

// Empty space is often exactly where a flank begins: rounding must not lift it.
TEST(BoundsGridTest, ConstantSpaceAtAFlankIsEmpty)
{
    const TransferFunction flank({{0.0, 0.0}, {1.0, 3.0}});
    for (const float fill : {0.0F, -9999.0F, not_a_number}) {
        ScalarGrid grid = ball({64, 64, 64}, fill);
        EXPECT_GT(tightness(grid, flank).empty, 0.4) << fill;
        expect_strict<float>(grid, flank, 200000);
    }
    std::mt19937 random(5);
    for (const double slope : {1.0, -0.3}) {
        ScalarGrid grid(VoxelType::u8, {40, 40, 40}, Affine3d{}, slope, 0.0);
        for (int i = 0; i < 20; ++i)
            grid.voxels<std::uint8_t>()[random() % grid.voxel_count()] = 200;
        const TransferFunction tf = slope > 0.0 ? flank : TransferFunction({{-1.0, 3.0}, {0.0, 0.0}});
        EXPECT_GT(tightness(grid, tf).empty, 0.9);
        expect_strict<std::uint8_t>(grid, tf, 200000);
    }
}

TEST(BoundsGridTest, FillValuesAtASharpStep)
{
    std::mt19937 random(6);
    std::uniform_real_distribution<float> uniform;
    for (const double fill : {-9999.0, -1e30, 1e20, 4321.1})
        for (const double slope : {1.0, 0.1, -0.7, 1.0 / 3.0}) {
            const auto raw = static_cast<float>(fill);
            const double v = std::clamp(slope * static_cast<double>(raw), -1e30, 1e30);
            const auto noise = [&] { return random() % 3 == 0 ? uniform(random) : raw; };
            const ScalarGrid grid = filled<float>(VoxelType::f32, {12, 12, 12}, noise, slope);
            expect_strict<float>(grid, TransferFunction({{v, 0.5}, {v, 2.0}}), 20000);
            expect_strict<float>(grid, TransferFunction({{v, 2.0}, {v, 0.5}}), 20000);
            // What rounding brings beyond both the data and the fill.
            expect_strict<float>(grid, TransferFunction({{-2.0, 7.0}, {-1.0, 0.0}, {1.0, 0.0}, {2.0, 7.0}}), 20000);
        }
}

TEST(BoundsGridTest, UnusualVolumes)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform;
    const auto any = [&] { return uniform(random); };
    const TransferFunction tf({{-0.8, 2.0}, {-0.5, 0.0}, {0.2, 0.0}, {0.5, 3.0}, {0.5, 1.0}, {0.8, 0.0}, {2.0, 0.5}});
    const Vec3i size{12, 11, 10};
    for (const double slope : {1.0, -1.0, -0.37})
        for (const double intercept : {0.0, 0.6, -1000.0}) {
            SCOPED_TRACE(slope);
            SCOPED_TRACE(intercept);
            std::vector<TransferPoint> points = tf.points();
            for (TransferPoint& point : points)
                point.value += intercept;
            const TransferFunction shifted(points);
            const auto check = [&](auto&& value) {
                expect_strict<float>(filled<float>(VoxelType::f32, size, value, slope, intercept), shifted, 20000);
            };
            for (const float constant : {0.0F, 0.5F, -0.5F, 0.3F, 1e-41F, -9999.0F, -1e30F})
                check([&] { return constant; });
            check([&] { return random() % 2 == 0 ? 0.2F : 0.5F; });
            check([&] { return random() % 2 == 0 ? -1e30F : 0.5F; });
            check([&] { return random() % 9 == 0 ? infinity : random() % 9 == 0 ? -infinity : any(); });
            check([&] { return random() % 9 == 0 ? infinity : 0.5F; });
            check([&] { return random() % 4 == 0 ? -9999.0F : random() % 9 == 0 ? not_a_number : any(); });
            check([&] { return random() % 4 == 0 ? -1e30F : random() % 9 == 0 ? 1e20F : any(); });
            check([&] { return random() % 2 == 0 ? 3e38F : -3e38F; });
            int i = 0;
            check([&] { return ++i == 500 ? 1e-42F : 0.0F; });
            i = 0;
            check([&] { return ++i == 500 ? -1e-42F : any(); });
        }
    const ScalarGrid overflows =
        filled<float>(VoxelType::f32, size, [&] { return random() % 2 == 0 ? 3e38F : -3e38F; });
    expect_strict<float>(overflows, TransferFunction({{-1.0, 0.5}, {1.0, 2.0}}), 20000);
    int i = 0;
    expect_strict<float>(filled<float>(VoxelType::f32, size, [&] { return ++i == 500 ? 1e-42F : 0.0F; }),
                         TransferFunction({{0.0, 0.0}, {1e-42, 5.0}, {2e-42, 7.0}}), 20000);
}

// Rounding as of a fill value carries data beyond their cell's range, and beyond that of all data.
TEST(BoundsGridTest, FillValuesThatRoundDataUp)
{
    std::mt19937 random(9);
    std::uniform_real_distribution<float> uniform;
    for (const float fill : {-1e7F, -3e7F, 1e7F, 3e7F}) {
        SCOPED_TRACE(fill);
        int i = 0;
        const ScalarGrid grid = filled<float>(VoxelType::f32, {16, 16, 16}, [&] {
            const float data = ++i <= 2048 ? 0.6F + 0.05F * uniform(random) : 0.9F + 0.2F * uniform(random);
            return random() % 3 == 0 ? data : fill;
        });
        expect_strict<float>(grid, TransferFunction({{0.8, 0.0}, {0.9, 7.0}, {1.1, 7.0}, {1.2, 0.0}}), 100000);
        expect_strict<float>(grid, TransferFunction({{1.5, 0.0}, {2.0, 7.0}, {2.1, 7.0}, {2.2, 0.0}}), 100000);
        expect_strict<float>(grid, TransferFunction({{-1.0, 0.0}, {0.0, 7.0}, {0.1, 7.0}, {0.3, 0.0}}), 100000);
    }
}

// Of a flank that begins far outside of the data, lookups subtract two numbers of the far end's size.
TEST(BoundsGridTest, FlanksFromFarAway)
{
    std::mt19937 random(8);
    std::uniform_real_distribution<float> uniform;
    const Vec3i size{64, 9, 9};
    const ScalarGrid noise = filled<float>(VoxelType::f32, size, [&] { return 0.2F + uniform(random); });
    int i = 0;
    const ScalarGrid ramp =
        filled<float>(VoxelType::f32, size, [&] { return 0.9F + 0.002F * static_cast<float>(i++ % 64); });
    for (const double from : {-1e4, -7e4, -1e6, -3e6, -5e6, -1e8})
        for (const ScalarGrid* grid : {&noise, &ramp})
            expect_strict<float>(*grid, TransferFunction({{from, 100.0}, {1.0, 0.0}}), 50000);
}

} // namespace
} // namespace lumisweep
