#include "lumisweep/visibility/brute_force.h"

#include <gtest/gtest.h>

#include <random>

#include "generated_volumes.h"

namespace lumisweep {
namespace {

using namespace test;

TEST(BruteForce, HomogeneousSlab)
{
    const ExtinctionGrid medium = homogeneous({5, 4, 3}, spaced({2.0, 1.0, 0.5}), 0.3);
    const Vec3d p_voxel{1.5, 2.0, 1.0};
    EXPECT_NEAR(transmittance_classified(medium, p_voxel, {1.0, 0.0, 0.0}), std::exp(-0.3 * 3.5 * 2.0), 1e-6);
    EXPECT_NEAR(transmittance_classified(medium, p_voxel, {0.0, -1.0, 0.0}), std::exp(-0.3 * 2.0), 1e-6);
    EXPECT_NEAR(transmittance_classified(medium, p_voxel, {0.0, 0.6, 0.8}), std::exp(-0.3 * 1.0 / 0.8), 1e-6);
    EXPECT_EQ(transmittance_classified(medium, {-0.1, 2.0, 1.0}, {1.0, 0.0, 0.0}), 1.0);
}

TEST(BruteForce, GaussLegendreEqualsAFineMidpointRule)
{
    // The classified grid as a volume of its own: both oracles then describe the same field.
    const ExtinctionGrid ct = classified(ct_volume({19, 14, 11}, oblique()), bone());
    ScalarGrid stored(VoxelType::u8, ct.size, oblique());
    std::copy(ct.stored.begin(), ct.stored.end(), stored.voxels<std::uint8_t>());
    const TransferFunction linear({{0.0, 0.0}, {255.0, 255.0 * static_cast<double>(ct.scale)}});
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform;
    for (int s = 0; s < 60; ++s) {
        const Vec3d p_voxel = Vec3d{19.0, 14.0, 11.0} * Vec3d{uniform(random), uniform(random), uniform(random)};
        const Vec3d w = normalized({uniform(random) - 0.5, uniform(random) - 0.5, uniform(random) - 0.5});
        EXPECT_NEAR(transmittance_classified(ct, p_voxel, w), transmittance_exact(stored, linear, p_voxel, w, 0.002),
                    2e-5);
    }
}

TEST(BruteForce, ExactGridIsTheExactTransmittance)
{
    const Vec3i size{11, 9, 7};
    const ScalarGrid volume = ct_volume(size, oblique());
    const VisibilityGrid grid = brute_force_visibility_exact(volume, bone(), 4, 2, 0.5);
    ASSERT_EQ(grid.cells(), (Vec3i{3, 3, 2}));
    int partly = 0;
    for (int d = 0; d < 4; ++d)
        for (int i = 0; i < 3; ++i) {
            const Vec3d p_voxel{(i + 0.5) * 11.0 / 3.0, 4.5, 7.0 / 4.0};
            const double v = transmittance_exact(volume, bone(), p_voxel, texel_direction(d, 2), 0.5);
            EXPECT_NEAR(grid.direction(d)[grid.cell_index(i, 1, 0)] / 255.0, v, 0.5 / 255.0 + 1e-9);
            partly += v > 0.01 && v < 0.99 ? 1 : 0;
        }
    EXPECT_GT(partly, 0);
}

TEST(BruteForce, EndsWhenCancelled)
{
    const std::atomic<bool> cancelled = true;
    const ScalarGrid volume = ct_volume({11, 9, 7}, oblique());
    const VisibilityGrid grid = brute_force_visibility_exact(volume, bone(), 4, 2, 0.5, &cancelled);
    for (int d = 0; d < 4; ++d)
        EXPECT_EQ(grid.direction(d)[0], 255); // as it was made
}

TEST(BruteForce, WholeGridAndCheckAgree)
{
    const Vec3i size{13, 9, 10};
    const ExtinctionGrid smoky = classified(smoke_volume(size, spaced({4.0, 5.0, 6.0})), smoke());
    const VisibilityGrid grid = brute_force_visibility(smoky, 3, 4);
    const SweepCheck check = sweep_check(grid, smoky, 50, 3);
    EXPECT_LE(check.max, 0.5 / 255.0 + 1e-9); // only the 8 bits of storage
    EXPECT_GT(check.rms_averaged, check.rms);
    const SweepCheck again = sweep_check(grid, smoky, 50, 3);
    EXPECT_EQ(again.rms_averaged, check.rms_averaged);
}

TEST(BruteForce, AverageConvergesToTheMeanOfManyPoints)
{
    const ExtinctionGrid smoky = classified(smoke_volume({12, 12, 12}, spaced({8.0, 8.0, 8.0})), smoke());
    const VisibilityGrid grid({12, 12, 12}, 4, 2);
    double coarse = 0.0; // of 40 small samples: each alone has a standard error of about 0.015 over so large a texel
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
        coarse += transmittance_averaged(smoky, grid, {1, 0, 2}, 1, 4, seed) / 40.0;
    const double fine = transmittance_averaged(smoky, grid, {1, 0, 2}, 1, 14, 99);
    EXPECT_NEAR(coarse, fine, 0.01);
    const double centre = transmittance_classified(smoky, {6.0, 2.0, 10.0}, texel_direction(1, 2));
    EXPECT_GT(std::fabs(fine - centre), 0.002); // so that the comparison above means something
}

} // namespace
} // namespace lumisweep
