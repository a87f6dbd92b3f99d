// Real files: the smoke that comes with the tests, and what scripts/fetch_data lays out (skipped where it is absent).
#include <algorithm>

#include <gmock/gmock.h>

#include "volume_io/test_files.h"

namespace lumisweep::test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct Range {
    double low, high;
};

Range range_of(const ScalarGrid& grid)
{
    return visit_voxels(grid, [&](const auto* voxel) {
        const auto [low, high] = std::minmax_element(voxel, voxel + grid.voxel_count());
        return Range{grid.slope() * double(*low) + grid.intercept(), grid.slope() * double(*high) + grid.intercept()};
    });
}

#define FETCHED(variable, name)                                                                                        \
    const std::filesystem::path variable = std::filesystem::path(LUMISWEEP_FETCHED_DATA) / name;                       \
    if (!std::filesystem::exists(variable))                                                                            \
    GTEST_SKIP() << variable << " is absent (fetch the data first)"

TEST(RealData, PlumeHasFortyFrames)
{
    const std::filesystem::path file = std::filesystem::path(LUMISWEEP_TEST_DATA) / "plume_4d_density.nrrd";
    const LoadedVolume first = load(file), last = load(file, 39);
    EXPECT_EQ(first.frames, 40);
    EXPECT_TRUE((first.grid.size() == Vec3i{48, 48, 96}));
    EXPECT_EQ(first.grid.type(), VoxelType::u8);
    EXPECT_THAT(first.warnings, IsEmpty());
    const auto sum = [](const ScalarGrid& g) {
        double s = 0;
        for (std::size_t i = 0; i < g.voxel_count(); ++i)
            s += g.voxels<std::uint8_t>()[i];
        return s;
    };
    EXPECT_GT(sum(last.grid), 2 * sum(first.grid)); // smoke rises and spreads
    EXPECT_NEAR(inspect_volume(file).spacing.z, 1.0 / 24.0, 1e-7);
}

TEST(RealData, CtHead)
{
    FETCHED(file, "ct_head.nrrd");
    const LoadedVolume v = load(file);
    EXPECT_TRUE((v.grid.size() == Vec3i{256, 256, 108}));
    EXPECT_EQ(v.grid.type(), VoxelType::i16);
    EXPECT_EQ(range_of(v.grid).low, -1024);
    EXPECT_EQ(range_of(v.grid).high, 2986);
    expect_point(inspect_volume(file).spacing, {0.957, 0.957, 1.5}, 1e-3);
}

TEST(RealData, Stent)
{
    FETCHED(file, "stent.nrrd");
    const LoadedVolume v = load(file);
    EXPECT_TRUE((v.grid.size() == Vec3i{128, 128, 256}));
    EXPECT_EQ(range_of(v.grid).low, 0);
    EXPECT_EQ(range_of(v.grid).high, 2000);
}

TEST(RealData, MrHeads)
{
    FETCHED(file, "ch2.nii.gz");
    const LoadedVolume v = load(file);
    EXPECT_TRUE((v.grid.size() == Vec3i{181, 217, 181}));
    EXPECT_EQ(v.grid.type(), VoxelType::u8);
    FETCHED(better, "ch2better.nii.gz");
    const LoadedVolume b = load(better);
    EXPECT_TRUE((b.grid.size() == Vec3i{301, 370, 316}));
    EXPECT_EQ(b.grid.type(), VoxelType::u8);
    // Both show the same head in the same (MNI) space: their boxes' centres are near each other and near the origin.
    const auto centre = [](const ScalarGrid& g) {
        return g.world_from_voxel().point({0.5 * g.size().x, 0.5 * g.size().y, 0.5 * g.size().z});
    };
    EXPECT_LT(length(centre(v.grid) - centre(b.grid)), 40.0);
    EXPECT_LT(length(centre(v.grid)), 60.0);
}

TEST(RealData, ObliqueMrSeries)
{
    FETCHED(directory, "mr_oblique");
    const LoadedVolume v = load(directory);
    EXPECT_EQ(v.format, "DICOM");
    EXPECT_EQ(v.modality, "MR");
    EXPECT_TRUE((v.grid.size() == Vec3i{256, 256, 20}));
    EXPECT_THAT(v.warnings, Contains(HasSubstr("irregular slice gaps of 6.958 to 7.071 mm")));
    EXPECT_NEAR(inspect_volume(directory).spacing.z, 7.0, 0.02);
}

} // namespace
} // namespace lumisweep::test
