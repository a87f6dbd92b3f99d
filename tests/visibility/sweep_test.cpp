#include "lumisweep/visibility/sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "generated_volumes.h"
#include "lumisweep/base/error.h"
#include "lumisweep/visibility/brute_force.h"

namespace lumisweep {
namespace {

using namespace test;

constexpr int all_rays = 8192; // level 0 whatever the size

VisibilitySettings settings_of(int directions, int cell, int rays, SweepFilter filter)
{
    VisibilitySettings settings;
    settings.directions = directions;
    settings.cell = cell;
    settings.rays = rays;
    settings.filter = filter;
    return settings;
}

bool same(const VisibilityGrid& a, const VisibilityGrid& b)
{
    for (int d = 0; a.same_shape(b) && d < a.direction_count(); ++d)
        if (std::memcmp(a.direction(d), b.direction(d), a.cell_count()) != 0)
            return false;
    return a.same_shape(b);
}

/// exp(−σ × path to the box's faces) at every cell and direction.
void expect_closed_form(Vec3i size, const Affine3d& world_from_voxel, int directions, int cell)
{
    // Optical depths from 0 to about 3 across the longest side.
    const double diagonal = length(world_from_voxel.vector({1.0 * size.x, 1.0 * size.y, 1.0 * size.z}));
    const double sigma = 3.0 / diagonal;
    const ExtinctionGrid medium = homogeneous(size, world_from_voxel, sigma);
    const VisibilityGrid grid = swept(medium, settings_of(directions, cell, all_rays, SweepFilter::none));
    const Affine3d voxel_from_world = inverse(world_from_voxel);
    const Vec3i cells = grid.cells();
    double worst = 0.0;
    for (int d = 0; d < grid.direction_count(); ++d) {
        const Vec3d w_voxel = voxel_from_world.vector(texel_direction(d, directions));
        for (int k = 0; k < cells.z; ++k)
            for (int j = 0; j < cells.y; ++j)
                for (int i = 0; i < cells.x; ++i) {
                    const Vec3d p{(i + 0.5) * size.x / cells.x, (j + 0.5) * size.y / cells.y,
                                  (k + 0.5) * size.z / cells.z};
                    double path = std::numeric_limits<double>::infinity();
                    for (int axis = 0; axis < 3; ++axis) {
                        const double dx = component(w_voxel, axis);
                        const double face = dx > 0.0 ? component(size, axis) : 0.0;
                        if (std::fabs(dx) > 1e-14)
                            path = std::min(path, (face - component(p, axis)) / dx);
                    }
                    const double v = grid.direction(d)[grid.cell_index(i, j, k)] / 255.0;
                    worst = std::max(worst, std::fabs(v - std::exp(-sigma * path)));
                }
    }
    // V is rounded twice, to 1/4080 for the filter and then to 8 bits.
    EXPECT_LE(worst, 0.5 / 255.0 + 0.5 / 4080.0 + 1e-4)
        << size.x << " x " << size.y << " x " << size.z << ", cell " << cell << ", n " << directions;
}

TEST(Sweep, HomogeneousBoxHasItsClosedForm)
{
    expect_closed_form({32, 32, 32}, Affine3d{}, 8, 4);
    expect_closed_form({37, 29, 23}, Affine3d{}, 8, 4);
    expect_closed_form({37, 29, 23}, spaced({0.5, 1.0, 2.5}), 8, 4);
    expect_closed_form({16, 40, 24}, spaced({3.0, 0.7, 0.9}), 8, 4);
    expect_closed_form({21, 34, 19}, oblique(), 8, 4);
}

TEST(Sweep, HomogeneousThinVolumes)
{
    for (const Vec3i size :
         {Vec3i{1, 1, 1}, {1, 1, 40}, {40, 1, 1}, {1, 33, 1}, {1, 30, 21}, {30, 1, 21}, {30, 21, 1}, {2, 2, 2}})
        for (const int cell : {1, 4}) {
            expect_closed_form(size, Affine3d{}, 8, cell);
            expect_closed_form(size, oblique(), 4, cell);
        }
}

TEST(Sweep, HomogeneousForEveryCellSize)
{
    for (int cell = 1; cell <= 9; ++cell)
        expect_closed_form({23, 17, 20}, spaced({1.0, 1.3, 0.8}), 4, cell);
    expect_closed_form({23, 17, 20}, Affine3d{}, 4, 64);
}

TEST(Sweep, HomogeneousForEveryNumberOfDirections)
{
    // 1 × 1 and 2 × 2 texel centres lie on axes and on exact ties between axes.
    for (const int n : {1, 2, 4, 8, 16, 32})
        expect_closed_form({14, 15, 11}, Affine3d{}, n, 3);
}

TEST(Sweep, SameBitsForAnyNumberOfThreads)
{
    const ExtinctionGrid ct = classified(ct_volume({45, 38, 41}, oblique()), bone(), 0);
    const VisibilitySettings settings = settings_of(8, 3, all_rays, SweepFilter::half_angle);
    const VisibilityGrid expected = swept(ct, settings);
    const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 8);
    for (const int threads : {1, 2, 7}) {
        tbb::task_arena arena(threads);
        EXPECT_TRUE(arena.execute([&] { return same(swept(ct, settings), expected); })) << threads;
    }
}

TEST(Sweep, SubsetsTouchOnlyTheirDirections)
{
    const ExtinctionGrid ct = classified(ct_volume({30, 26, 28}, Affine3d{}), bone(), 0);
    const VisibilitySettings settings = settings_of(8, 4, all_rays, SweepFilter::half_angle);
    const VisibilityGrid all = swept(ct, settings);
    VisibilityGrid grid({30, 26, 28}, 4, 8);
    const std::vector<int> subset{63, 5, 20, 5};
    sweep_visibility(grid, ct, settings, subset);
    for (int d = 0; d < 64; ++d) {
        const bool chosen = std::find(subset.begin(), subset.end(), d) != subset.end();
        for (std::size_t i = 0; i < grid.cell_count(); ++i)
            ASSERT_EQ(grid.direction(d)[i], chosen ? all.direction(d)[i] : 255) << d;
    }
}

TEST(Sweep, CancelLeavesOldValues)
{
    const ExtinctionGrid ct = classified(ct_volume({30, 26, 28}, Affine3d{}), bone(), 0);
    const VisibilitySettings settings = settings_of(8, 4, all_rays, SweepFilter::half_angle);
    VisibilityGrid grid({30, 26, 28}, 4, 8);
    const VisibilityGrid before({30, 26, 28}, 4, 8);
    const std::atomic<bool> cancel{true};
    sweep_visibility(grid, ct, settings, {}, &cancel);
    EXPECT_TRUE(same(grid, before));
}

TEST(Sweep, EmptyVolumeIsAllVisible)
{
    const ExtinctionGrid empty = homogeneous({10, 11, 12}, Affine3d{}, 0.0);
    VisibilityGrid grid({10, 11, 12}, 4, 4);
    std::memset(grid.direction(0), 3, grid.bytes());
    sweep_visibility(grid, empty, settings_of(4, 4, 0, SweepFilter::half_angle));
    EXPECT_TRUE(same(grid, VisibilityGrid({10, 11, 12}, 4, 4)));
}

TEST(Sweep, RaysChooseTheLevel)
{
    EXPECT_EQ(sweep_mip_level({256, 256, 108}, 0), 0);
    EXPECT_EQ(sweep_mip_level({512, 512, 460}, 0), 1);
    EXPECT_EQ(sweep_mip_level({64, 1024, 64}, 0), 2);
    EXPECT_EQ(sweep_mip_level({256, 256, 108}, 128), 1);
    EXPECT_EQ(sweep_mip_level({256, 256, 108}, 127), 2);
    EXPECT_EQ(sweep_mip_level({1, 1, 1}, 1), 0);
    EXPECT_EQ(sweep_mip_level({8192, 1, 1}, 1), 13);
}

TEST(Sweep, RefusesWhatDoesNotFit)
{
    const ExtinctionGrid ct = classified(ct_volume({30, 26, 28}, Affine3d{}), bone(), 0);
    VisibilityGrid grid({30, 26, 28}, 4, 8);
    EXPECT_THROW(sweep_visibility(grid, ct, settings_of(4, 4, 0, SweepFilter::none)), Error);
    EXPECT_THROW(sweep_visibility(grid, ct, settings_of(8, 5, 0, SweepFilter::none)), Error);
    EXPECT_THROW(sweep_visibility(grid, ct, settings_of(8, 4, 15, SweepFilter::none)), Error); // needs level 1
    const ExtinctionGrid straight =
        classified(ct_volume({30, 26, 28}, Affine3d{}), bone(), 0, ExtinctionLayouts::straight);
    EXPECT_THROW(sweep_visibility(grid, straight, settings_of(8, 4, 0, SweepFilter::none)), Error);
    EXPECT_THROW(sweep_visibility(grid, ExtinctionGrid{}, settings_of(8, 4, 0, SweepFilter::none)), Error);
    const std::vector<int> outside{64};
    EXPECT_THROW(sweep_visibility(grid, ct, settings_of(8, 4, 0, SweepFilter::none), outside), Error);
}

} // namespace
} // namespace lumisweep
