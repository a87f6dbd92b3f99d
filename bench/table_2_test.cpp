// Which copy of a volume, and which of its levels, has about as many rays as the paper's table asks for.
#include <gtest/gtest.h>

#include "lumisweep/visibility/sweep.h"
#include "table_2.h"

namespace lumisweep::bench {
namespace {

TEST(Table2, TakesTheNearestNumberOfRays)
{
    EXPECT_EQ(nearest_resolution({256, 256, 128}, 256), (Resolution{0, 256}));
    EXPECT_EQ(nearest_resolution({256, 256, 128}, 512), (Resolution{1, 512}));
    EXPECT_EQ(nearest_resolution({256, 256, 128}, 1024), (Resolution{2, 1024}));
    EXPECT_EQ(nearest_resolution({384, 384, 512}, 256), (Resolution{0, 256}));
    EXPECT_EQ(nearest_resolution({535, 342, 690}, 256), (Resolution{0, 345}));
    EXPECT_EQ(nearest_resolution({535, 342, 690}, 512), (Resolution{0, 690}));
    EXPECT_EQ(nearest_resolution({535, 342, 690}, 1024), (Resolution{1, 1380}));
}

TEST(Table2, SweepsTakeJustThoseRays)
{
    const Vec3i size{535, 342, 690};
    for (const int wanted : {43, 100, 256, 512}) {
        const int rays = nearest_resolution(size, wanted).rays, level = sweep_mip_level(size, rays);
        EXPECT_EQ(rays, (690 + (1 << level) - 1) >> level) << wanted;
    }
}

} // namespace
} // namespace lumisweep::bench
