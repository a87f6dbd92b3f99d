#include "lumisweep/visibility/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "lumisweep/base/error.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {
namespace {

void expect_error(const std::function<void(VisibilitySettings&)>& change, const char* entry)
{
    VisibilitySettings settings;
    change(settings);
    try {
        settings.validate();
        FAIL() << entry << " was accepted";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(entry));
    }
}

TEST(VisibilitySettings, NamesTheEntryThatIsOutOfRange)
{
    EXPECT_NO_THROW(VisibilitySettings{}.validate());
    for (const int n : {-8, 0, 3, 64})
        expect_error([&](VisibilitySettings& s) { s.directions = n; }, "visibility.directions");
    for (const int cell : {-1, 0, 65})
        expect_error([&](VisibilitySettings& s) { s.cell = cell; }, "visibility.cell");
    for (const int rays : {-1, 8193})
        expect_error([&](VisibilitySettings& s) { s.rays = rays; }, "visibility.rays");
    for (const double epsilon : {0.0, -0.1, 1.5, std::numeric_limits<double>::quiet_NaN()})
        expect_error([&](VisibilitySettings& s) { s.epsilon = epsilon; }, "visibility.epsilon");
}

TEST(VisibilityGrid, StartsAllVisible)
{
    VisibilityGrid grid({9, 8, 1}, 4, 2);
    EXPECT_EQ(grid.cells(), (Vec3i{3, 2, 1}));
    EXPECT_EQ(grid.direction_count(), 4);
    EXPECT_EQ(grid.bytes(), VisibilityGrid::bytes_needed(3 * 2 * 1, 2));
    EXPECT_GE(grid.bytes(), 3U * 2 * 1 * 4);
    for (int d = 0; d < 4; ++d)
        for (std::size_t i = 0; i < grid.cell_count(); ++i)
            EXPECT_EQ(grid.direction(d)[i], 255);
    EXPECT_THROW(VisibilityGrid({9, 8, 1}, 0, 2), Error);
    EXPECT_THROW(VisibilityGrid({9, 0, 1}, 4, 2), Error);
    EXPECT_THROW(VisibilityGrid({9, 8, 1}, 4, 3), Error);
}

TEST(VisibilityGrid, TexelDirectionsAreInMortonOrder)
{
    // Texel 1 of 2 × 2 is at u = 3/4, v = 1/4: towards +X, −Y, on the equator.
    const Vec3d w = texel_direction(1, 2);
    EXPECT_NEAR(w.x, std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(w.y, -std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(w.z, 0.0, 1e-9);
}

} // namespace
} // namespace lumisweep
