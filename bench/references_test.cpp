// The errors that the report gives: references against the slow oracles, and the sums over them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <tbb/task_arena.h>

#include "lumisweep/visibility/brute_force.h"
#include "references.h"
#include "subject.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

class ReferencesTest : public testing::Test {
protected:
    ReferencesTest() : subject_(ct_like({45, 40, 37})), references_(subject_.references(4, 24)) {}
    Subject subject_;
    const References& references_;
};

TEST_F(ReferencesTest, AgreeWithTheOracles)
{
    const ExtinctionGrid& extinction = subject_.extinction(0);
    const VisibilityGrid& grid = subject_.grid(4);
    const Vec3d side{45.0 / grid.cells().x, 40.0 / grid.cells().y, 37.0 / grid.cells().z};
    double squares = 0.0;
    for (std::size_t c = 0; c < references_.cells.size(); ++c) {
        const Vec3i& cell = references_.cells[c];
        for (int d = 0; d < 64; ++d) {
            const std::size_t at = c * 64 + static_cast<std::size_t>(d);
            const Vec3d centre = Vec3d{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5} * side;
            EXPECT_NEAR(references_.exact[at], transmittance_classified(extinction, centre, texel_direction(d, 8)),
                        1e-6);
            const double averaged = transmittance_averaged(extinction, grid, cell, d, 6, 1000 + at);
            EXPECT_NEAR(references_.averaged[at], averaged, 0.12); // 216 rays, each off by up to ½ from the mean
            squares += std::pow(references_.averaged[at] - averaged, 2);
        }
    }
    // Both are means of stratified rays; without any strata 216 rays of spread ½ would leave .034.
    EXPECT_LT(std::sqrt(squares / static_cast<double>(references_.exact.size())), 0.02);
}

TEST_F(ReferencesTest, ErrorsOfGridsThatAreKnown)
{
    const VisibilityGrid exact = brute_force_visibility(subject_.extinction(0), 4, 8);
    EXPECT_LT(errors_of(exact, references_).rms, 0.002); // rounding to 8 bits
    // A grid of V = 1 is off by 1 − V.
    const GridErrors visible = errors_of(VisibilityGrid(subject_.volume().size(), 4, 8), references_);
    double squares = 0.0;
    for (const float v : references_.averaged)
        squares += (1.0 - static_cast<double>(v)) * (1.0 - static_cast<double>(v));
    EXPECT_NEAR(visible.rms_averaged, std::sqrt(squares / static_cast<double>(references_.averaged.size())), 1e-9);
    EXPECT_GT(visible.rms_averaged_error, 0.0);
}

TEST_F(ReferencesTest, TheSameOnOneThread)
{
    References alone;
    tbb::task_arena(1).execute(
        [&] { alone = make_references(subject_.extinction(0), subject_.grid(4), 24, reference_seed); });
    EXPECT_EQ(alone.exact, references_.exact);
    EXPECT_EQ(alone.averaged, references_.averaged);
}

TEST(MeanAndError, OfNumbersThatAreKnown)
{
    const double values[] = {1.0, 2.0, 3.0, 4.0};
    EXPECT_DOUBLE_EQ(mean_and_error(values).mean, 2.5);
    EXPECT_DOUBLE_EQ(mean_and_error(values).error, std::sqrt(5.0 / 3.0 / 4.0));
}

TEST(Volumes, AreTheSameOnOneThreadAndHoldWhatTheyShould)
{
    const Specimen together = ct_like({64, 60, 50});
    Specimen alone;
    tbb::task_arena(1).execute([&] { alone = ct_like({64, 60, 50}); });
    const auto* a = together.volume.voxels<std::int16_t>();
    const auto* b = alone.volume.voxels<std::int16_t>();
    std::size_t bone = 0, air = 0;
    for (std::size_t i = 0; i < together.volume.voxel_count(); ++i) {
        ASSERT_EQ(a[i], b[i]);
        bone += a[i] > 700 ? 1 : 0;
        air += a[i] < -800 ? 1 : 0;
    }
    EXPECT_GT(bone, together.volume.voxel_count() / 50);
    EXPECT_GT(air, together.volume.voxel_count() / 10);
}

TEST(Volumes, DoublingKeepsTheObject)
{
    const Specimen coarse = smoke_like({20, 17, 15}), fine = doubled(coarse);
    ASSERT_EQ(fine.volume.size(), (Vec3i{40, 34, 30}));
    double of_coarse = 0.0, of_fine = 0.0;
    for (int k = 0; k < 30; ++k)
        for (int j = 0; j < 34; ++j)
            for (int i = 0; i < 40; ++i) {
                of_fine += fine.volume.interpolate({i + 0.5, j + 0.5, k + 0.5});
                of_coarse += coarse.volume.interpolate({0.5 * i + 0.25, 0.5 * j + 0.25, 0.5 * k + 0.25});
            }
    const double count = static_cast<double>(fine.volume.voxel_count());
    EXPECT_NEAR(of_fine / count, of_coarse / count, 0.5); // rounded to steps of 16
    // Twice: from bytes, which keep their steps.
    const Specimen finest = doubled(fine);
    ASSERT_EQ(finest.volume.size(), (Vec3i{80, 68, 60}));
    double of_finest = 0.0, largest = 0.0;
    for (int k = 0; k < 60; ++k)
        for (int j = 0; j < 68; ++j)
            for (int i = 0; i < 80; ++i) {
                const double there = finest.volume.interpolate({i + 0.5, j + 0.5, k + 0.5});
                of_finest += there;
                largest = std::max(largest, std::fabs(there - fine.volume.interpolate(
                                                                  {0.5 * i + 0.25, 0.5 * j + 0.25, 0.5 * k + 0.25})));
            }
    EXPECT_NEAR(of_finest / (8.0 * count), of_fine / count, 0.5);
    EXPECT_LE(largest, 8.0 + 1e-3); // half a step
}

} // namespace
} // namespace lumisweep::bench
