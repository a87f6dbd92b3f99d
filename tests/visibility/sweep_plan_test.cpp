// Where rays run, what they count, and which directions are swept together.
#include "lumisweep/visibility/sweep_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "generated_volumes.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {
namespace {

using namespace test;

Vec3d random_direction(std::mt19937& random)
{
    std::normal_distribution<double> normal;
    return normalized(Vec3d{normal(random), normal(random), normal(random)});
}

TEST(SweepGeometry, EverySliceHasTheWholeWeightHoweverItIsCut)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform;
    for (int repeat = 0; repeat < 200; ++repeat) {
        const SweepGeometry g({31, 17, 24}, oblique(), random_direction(random));
        std::vector<double> cuts{0.0, static_cast<double>(g.slices)};
        for (int i = 0; i < repeat % 40; ++i)
            cuts.push_back(uniform(random) * g.slices);
        std::sort(cuts.begin(), cuts.end());
        std::vector<int> weight(static_cast<std::size_t>(g.slices), 0);
        std::int32_t until_cut = 0;
        for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
            for (const SweepPiece& piece : g.pieces(cuts[c], cuts[c + 1])) {
                const double middle_u = g.u.slope * (piece.slice + 0.5), middle_v = g.v.slope * (piece.slice + 0.5);
                EXPECT_LE(std::fabs(piece.shift_u + 0.5 - middle_u), 1.01);
                EXPECT_LE(std::fabs(piece.shift_v + 0.5 - middle_v), 1.01);
                for (const std::int8_t w : piece.weight) {
                    EXPECT_GE(w, 0);
                    weight[static_cast<std::size_t>(piece.slice)] += w;
                    until_cut += w;
                }
            }
            EXPECT_EQ(until_cut, weight_at(cuts[c + 1]));
        }
        for (const int w : weight)
            EXPECT_EQ(w, slice_weight);
    }
}

TEST(SweepGeometry, RaysCountTheSlicesThatTheyAreInsideOf)
{
    std::mt19937 random(2);
    for (int repeat = 0; repeat < 100; ++repeat) {
        const SweepGeometry g({13, 40, 22}, oblique(), random_direction(random));
        for (const SweepAxis* axis : {&g.u, &g.v}) {
            EXPECT_EQ(axis->first_ray % 2, 0);
            ASSERT_EQ(axis->begin.size(), static_cast<std::size_t>(axis->ray_count));
            for (int i = 0; i < axis->ray_count; ++i)
                for (int slice = 0; slice < g.slices; ++slice) {
                    // Of the line between two depths, the part with −1/2 ≤ x ≤ size − 1/2.
                    const double a = axis->first_ray + i + axis->slope * slice, b = a + axis->slope;
                    const double inside = std::min(std::max(a, b), axis->size - 0.5) - std::max(std::min(a, b), -0.5);
                    if (std::fabs(inside) < 1e-6)
                        continue;
                    const std::size_t ray = static_cast<std::size_t>(i), s = static_cast<std::size_t>(slice);
                    EXPECT_EQ(axis->begin[ray] <= slice && slice<axis->end[ray], inside> 0.0);
                    EXPECT_EQ(axis->first[s] <= i && i<axis->last[s], inside> 0.0);
                }
        }
    }
}

TEST(SweepGeometry, OppositeDirectionsHaveTheSameRays)
{
    std::mt19937 random(3);
    for (int repeat = 0; repeat < 50; ++repeat) {
        const Vec3d w = random_direction(random);
        const SweepGeometry a({13, 40, 22}, oblique(), w), b({13, 40, 22}, oblique(), Vec3d{-w.x, -w.y, -w.z});
        EXPECT_EQ(a.axis, b.axis);
        EXPECT_NE(a.towards_high_side, b.towards_high_side);
        EXPECT_EQ(a.u.slope, b.u.slope);
        EXPECT_EQ(a.v.slope, b.v.slope);
        EXPECT_EQ(a.u.begin, b.u.begin);
        EXPECT_EQ(a.v.end, b.v.end);
    }
}

int texel_of(const Vec3d& w, int n)
{
    const UV<double> uv = oct_from_direction(w);
    return morton_encode<std::int32_t>(static_cast<std::int32_t>(uv.u * n), static_cast<std::int32_t>(uv.v * n));
}

/// Of `chosen` directions: each written by one task, over all its lines; groups share an axis and a sense.
void expect_plan(const std::vector<int>& chosen, const VisibilitySettings& settings, std::size_t largest)
{
    const Vec3i size{30, 20, 25};
    const int n = settings.directions, lines = settings.oversampling;
    const std::vector<SweepTask> tasks = plan_sweeps(oblique(), settings, chosen, largest);
    std::vector<int> line_count(static_cast<std::size_t>(n * n), 0), task_count = line_count;
    for (const SweepTask& task : tasks) {
        for (const int d : task.directions())
            ++task_count[static_cast<std::size_t>(d)];
        ASSERT_TRUE(lines > 1 || task.groups.size() == 1);
        for (const SweepGroup& group : task.groups) {
            ASSERT_FALSE(group.empty());
            EXPECT_LE(group.size(), largest);
            const SweepGeometry first(size, oblique(), group.front().w_world);
            for (const SweepPair& pair : group) {
                const SweepGeometry g(size, oblique(), pair.w_world);
                EXPECT_EQ(g.axis, first.axis);
                EXPECT_EQ(g.v.slope > 0.0, first.v.slope > 0.0);
                EXPECT_TRUE(pair.towards_low >= 0 || pair.towards_high >= 0);
                for (const bool high : {false, true}) {
                    const int d = high ? pair.towards_high : pair.towards_low;
                    if (d < 0)
                        continue;
                    ++line_count[static_cast<std::size_t>(d)];
                    // The line runs through the texel, towards the side that it is swept for.
                    const double sense = high == g.towards_high_side ? 1.0 : -1.0;
                    EXPECT_EQ(texel_of(pair.w_world * sense, n), d);
                    if (lines == 1) {
                        EXPECT_GT(sense * dot(pair.w_world, texel_direction(d, n)), 1.0 - 1e-9);
                    }
                }
            }
        }
    }
    for (int d = 0; d < n * n; ++d) {
        const bool wanted = std::find(chosen.begin(), chosen.end(), d) != chosen.end();
        EXPECT_EQ(task_count[static_cast<std::size_t>(d)], wanted ? 1 : 0) << d;
        EXPECT_EQ(line_count[static_cast<std::size_t>(d)], wanted ? lines : 0) << d;
    }
}

TEST(SweepPlan, EveryDirectionOnceInGroupsOfOneSense)
{
    std::mt19937 random(4);
    for (const int n : {1, 2, 4, 8, 16})
        for (const int oversampling : {1, 4, 16})
            for (const std::size_t largest : {1U, 2U, 5U, 100U}) {
                VisibilitySettings settings;
                settings.directions = n;
                settings.oversampling = oversampling;
                std::vector<int> all(static_cast<std::size_t>(n * n));
                std::iota(all.begin(), all.end(), 0);
                expect_plan(all, settings, largest);
                std::shuffle(all.begin(), all.end(), random);
                all.resize(1 + all.size() / 3);
                expect_plan(all, settings, largest);
            }
}

TEST(SweepPlan, GroupsFitIntoMemoryAndFeedAllThreads)
{
    VisibilitySettings settings;
    const auto largest = [&](int side, int cells, int threads) {
        return largest_sweep_group({side, side, side}, {cells, cells, cells}, settings, 64, threads);
    };
    EXPECT_EQ(largest(128, 32, 1), 6U);
    EXPECT_EQ(largest(128, 32, 64), 1U);
    EXPECT_EQ(largest(1024, 1024, 1), 1U);
    const std::size_t few = largest(512, 250, 1);
    EXPECT_GE(few, 2U);
    EXPECT_LE(few * sweep_pair_bytes({512, 512, 512}, {250, 250, 250}), std::uint64_t{256} << 20);
    // All lines of a texel are one thread's.
    settings.oversampling = 16;
    EXPECT_EQ(largest_sweep_group({128, 128, 128}, {32, 32, 32}, settings, 2, 64), 6U);
}

} // namespace
} // namespace lumisweep
