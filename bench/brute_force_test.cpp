// The yardstick itself: brute force on every instruction set against the exact oracle.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "brute_force.h"
#include "lumisweep/visibility/brute_force.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

std::vector<VisibilityQuery> random_queries(Vec3i size, std::size_t count, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit;
    std::normal_distribution<double> normal;
    std::vector<VisibilityQuery> queries(count);
    for (VisibilityQuery& q : queries) {
        q.p_voxel = {unit(random) * size.x, unit(random) * size.y, unit(random) * size.z};
        q.w_world = normalized({normal(random), normal(random), normal(random)});
    }
    return queries;
}

double rms_against_oracle(const ExtinctionGrid& extinction, const BruteForceKernel& kernel, double samples_per_voxel)
{
    const std::vector<VisibilityQuery> queries = random_queries(extinction.size, 3001, 5);
    std::vector<float> v(queries.size());
    EXPECT_GT(BruteForce(extinction, kernel, samples_per_voxel).visibility(queries, v), queries.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const double exact = transmittance_classified(extinction, queries[i].p_voxel, queries[i].w_world);
        squares += (v[i] - exact) * (v[i] - exact);
    }
    return std::sqrt(squares / static_cast<double>(queries.size()));
}

/// The grid in other proportions: a longer z, a sheared x.
Specimen skewed(const Specimen& s)
{
    Affine3d a;
    a.column = {{{1.1, 0.2, 0.0}, {0.0, 0.8, 0.0}, {0.0, 0.3, 1.9}}};
    Specimen moved{s.name, ScalarGrid(VoxelType::i16, s.volume.size(), a), s.transfer_function};
    std::copy_n(s.volume.voxels<std::int16_t>(), s.volume.voxel_count(), moved.volume.voxels<std::int16_t>());
    return moved;
}

ExtinctionGrid classified(const Specimen& s)
{
    return classify(s.volume, raw_range(s.volume), s.transfer_function, 0, ExtinctionLayouts::straight);
}

TEST(BruteForce, EveryInstructionSetMeetsTheOracle)
{
    const Specimen ct = skewed(ct_like({61, 58, 47})), smoke = smoke_like({64, 51, 40});
    const ExtinctionGrid dense = classified(ct);
    const ExtinctionGrid thin = classified(smoke);
    for (const BruteForceKernel& kernel : brute_force_kernels()) {
        SCOPED_TRACE(kernel.name);
        // One sample a voxel of extinction that jumps from voxel to voxel; 8 samples a voxel show that it converges.
        EXPECT_LT(rms_against_oracle(dense, kernel, 1.0), 0.02);
        EXPECT_LT(rms_against_oracle(dense, kernel, 8.0), 0.002);
        EXPECT_LT(rms_against_oracle(thin, kernel, 1.0), 0.002);
    }
}

TEST(BruteForce, InstructionSetsTakeTheSameSamples)
{
    const Specimen ct = ct_like({50, 50, 50});
    const ExtinctionGrid extinction = classified(ct);
    const std::vector<VisibilityQuery> queries = random_queries(ct.volume.size(), 997, 9);
    std::vector<float> reference(queries.size()), v(queries.size());
    const auto samples =
        static_cast<double>(BruteForce(extinction, brute_force_kernels().back()).visibility(queries, reference));
    for (const BruteForceKernel& kernel : brute_force_kernels()) {
        SCOPED_TRACE(kernel.name);
        // Rounding may move an early exit by a sample.
        EXPECT_NEAR(static_cast<double>(BruteForce(extinction, kernel).visibility(queries, v)), samples,
                    0.001 * samples);
        for (std::size_t i = 0; i < v.size(); ++i)
            ASSERT_NEAR(v[i], reference[i], 0.002);
    }
}

TEST(BruteForce, FewerRaysThanLanesAndRaysOutside)
{
    const Specimen smoke = smoke_like({20, 20, 20});
    const ExtinctionGrid extinction = classified(smoke);
    for (const BruteForceKernel& kernel : brute_force_kernels())
        for (std::size_t count = 0; count <= 17; ++count) {
            std::vector<VisibilityQuery> queries = random_queries({20, 20, 20}, count, count);
            if (count > 3)
                queries[2].p_voxel = {-1.0, 5.0, 5.0};
            std::vector<float> v(count, -1.0F);
            BruteForce(extinction, kernel, 32.0).visibility(queries, v);
            for (std::size_t i = 0; i < count; ++i)
                // Rays end where 1/512 is left.
                EXPECT_NEAR(v[i], transmittance_classified(extinction, queries[i].p_voxel, queries[i].w_world),
                            1.0 / 512)
                    << kernel.name << ", ray " << i << " of " << count;
        }
}

} // namespace
} // namespace lumisweep::bench
