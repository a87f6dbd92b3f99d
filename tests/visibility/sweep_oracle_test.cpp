// The sweep against slow versions of itself.
#include "sweep_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "kernel_tables.h"
#include "lumisweep/visibility/sweep.h"
#include "sweep_case.h"

namespace lumisweep {
namespace {

using namespace test;

VisibilityGrid empty_grid(const SweepCase& c)
{
    return VisibilityGrid(c.extinction.volume_size, c.settings.cell, c.settings.directions);
}

::testing::AssertionResult equal_in(int direction, const VisibilityGrid& grid, const std::uint8_t* expected)
{
    for (std::size_t i = 0; i < grid.cell_count(); ++i)
        if (grid.direction(direction)[i] != expected[i])
            return ::testing::AssertionFailure()
                   << "direction " << direction << ", cell " << i << " of " << grid.cells().x << " x " << grid.cells().y
                   << " x " << grid.cells().z << ": " << int{grid.direction(direction)[i]} << ", not "
                   << int{expected[i]};
    return ::testing::AssertionSuccess();
}

/// Everything that a direction's V must not depend on.
void expect_same_bits(SweepCase& c)
{
    VisibilityGrid all = empty_grid(c);
    tbb::task_arena(1).execute([&] { sweep_visibility(all, c.extinction, c.settings); });
    for (const int d : c.compared)
        ASSERT_TRUE(equal_in(d, all, sweep_in_integers(c.extinction, c.settings, d).data())) << c;
    for (const SweepKernels* kernels : runnable_kernels()) {
        VisibilityGrid grid = empty_grid(c);
        tbb::task_arena(c.integer(1, 5)).execute([&] {
            sweep_visibility_with(*kernels, grid, c.extinction, c.settings, c.subset);
        });
        for (int d = 0; d < grid.direction_count(); ++d) {
            const bool chosen = std::find(c.subset.begin(), c.subset.end(), d) != c.subset.end();
            const std::vector<std::uint8_t> untouched(grid.cell_count(), 255);
            ASSERT_TRUE(equal_in(d, grid, chosen ? all.direction(d) : untouched.data())) << kernels->name << ", " << c;
        }
    }
    VisibilityGrid grid = empty_grid(c);
    for (int d = 0; d < grid.direction_count(); ++d)
        std::memset(grid.direction(d), 1, grid.cell_count());
    tbb::task_arena(c.integer(2, 4)).execute([&] {
        for (const std::vector<int>& group : sweep_groups(c.extinction, c.settings))
            sweep_visibility(grid, c.extinction, c.settings, group);
    });
    for (int d = 0; d < grid.direction_count(); ++d)
        ASSERT_TRUE(equal_in(d, grid, all.direction(d))) << "in groups, " << c;
}

TEST(SweepOracle, EqualsPlainLoopsToTheBit)
{
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 8); // more than there may be cores
    for (std::uint32_t number = 1; number <= 150 && !HasFatalFailure(); ++number) {
        SweepCase c(number);
        expect_same_bits(c);
    }
}

} // namespace
} // namespace lumisweep
