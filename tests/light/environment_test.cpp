#include "lumisweep/light/environment.h"

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "lumisweep/base/error.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

AlignedArray<float> random_texels(int n, unsigned seed)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> exponent(-10.0F, 12.0F);
    AlignedArray<float> texels(3 * static_cast<std::size_t>(n * n));
    for (float& value : texels)
        value = std::exp(exponent(random));
    return texels;
}

TEST(Environment, EveryNodeIsTheMeanOfTheTexelsBelow)
{
    for (const int n : {1, 2, 8, 64}) {
        const Environment environment(n, random_texels(n, 7));
        const EnvironmentView view = environment.view();
        ASSERT_EQ(1 << view.levels, n);
        for (int l = 0; l <= view.levels; ++l) {
            const std::size_t nodes = std::size_t{1} << (2 * l), begin = (nodes - 1) / 3;
            const std::size_t texels = static_cast<std::size_t>(n * n) / nodes;
            for (std::size_t m = 0; m < nodes; ++m) {
                double sum = 0.0;
                for (std::size_t i = m * texels; i < (m + 1) * texels; ++i)
                    sum += luminance(view.radiance[3 * i], view.radiance[3 * i + 1], view.radiance[3 * i + 2]);
                const double mean = sum / static_cast<double>(texels);
                ASSERT_NEAR(view.luminance[begin + m], mean, 4e-7 * mean) << "level " << l << " node " << m;
            }
        }
        EXPECT_EQ(environment.mean_luminance(), view.luminance[0]);
        EXPECT_EQ(environment.bytes(), 4 * (3 * n * n + (4 * static_cast<std::size_t>(n * n) - 1) / 3));
    }
}

TEST(Environment, LooksUpTheTexelUnderADirection)
{
    constexpr int n = 16;
    const Environment environment(n, random_texels(n, 11));
    for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
            const Vec3d w = direction_from_oct(UV<double>{(x + 0.4) / n, (y + 0.6) / n});
            const Vec3d found = environment.radiance(w);
            const float* rgb = environment.view().radiance + 3 * morton_encode(x, y);
            EXPECT_EQ(found, (Vec3d{rgb[0], rgb[1], rgb[2]}));
        }
    }
    // The corners of the square are all −Z: any of the four texels there will do, but none outside.
    for (const Vec3d& w : {Vec3d{0, 0, -1}, Vec3d{-0.0, -0.0, -1}, Vec3d{1, 0, 0}, Vec3d{0, 0, 1}, Vec3d{0, -1, 0}})
        EXPECT_GT(environment.radiance(w).x, 0.0);
}

TEST(Environment, ConstantIsTheSameEverywhere)
{
    const Environment environment = Environment::constant({0.25, 0.5, 2.0});
    EXPECT_EQ(environment.resolution(), 8);
    EXPECT_EQ(environment.radiance(normalized({0.3, -0.8, -0.1})), (Vec3d{0.25, 0.5, 2.0}));
    EXPECT_NEAR(environment.mean_luminance(), luminance(0.25, 0.5, 2.0), 1e-7);
}

TEST(Environment, RefiningKeepsTheLight)
{
    const Environment coarse(4, random_texels(4, 13));
    const Environment fine = coarse.refined(32);
    EXPECT_EQ(fine.resolution(), 32);
    EXPECT_EQ(fine.mean_luminance(), coarse.mean_luminance());
    for (int i = 0; i < 32 * 32; ++i) {
        const UV<double> uv{(i % 32 + 0.5) / 32, (i / 32 + 0.5) / 32};
        const Vec3d w = direction_from_oct(uv);
        EXPECT_EQ(fine.radiance(w), coarse.radiance(w));
    }
    EXPECT_EQ(coarse.refined(4).mean_luminance(), coarse.mean_luminance());
}

TEST(Environment, RefusesWhatCannotBe)
{
    EXPECT_THROW(Environment(12, AlignedArray<float>(3 * 12 * 12)), Error);
    EXPECT_THROW(Environment(0, AlignedArray<float>()), Error);
    EXPECT_THROW(Environment(32768, AlignedArray<float>()), Error);
    EXPECT_THROW(Environment(8, AlignedArray<float>(10)), Error);
    for (const float bad : {-1e-3F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        AlignedArray<float> texels(3 * 64);
        texels[100] = bad;
        EXPECT_THROW(Environment(8, std::move(texels)), Error);
    }
}

} // namespace
} // namespace lumisweep
