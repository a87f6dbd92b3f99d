#include "lumisweep/light/sky.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "environments.h"
#include "lumisweep/base/error.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

using test::flux;
using test::texel;

SkySettings dark()
{
    SkySettings sky;
    sky.zenith = sky.horizon = sky.ground = sky.sun_irradiance = {0, 0, 0};
    return sky;
}

Vec3d texel_direction(const Environment& environment, int i)
{
    const int n = environment.resolution();
    const TexelXY<int> t = morton_decode(i);
    return direction_from_oct(UV<double>{(t.x + 0.5) / n, (t.y + 0.5) / n});
}

TEST(Sky, GradientHasItsClosedIntegral)
{
    // ∫ over the upper hemisphere of (1 − z)³ dω = 2π/4; ground over the lower one: 2π.
    for (const int n : {8, 64, 512}) {
        SkySettings sky = dark();
        sky.zenith = {1, 0, 0};
        sky.horizon = {0, 1, 0};
        sky.ground = {0, 0, 1};
        const Vec3d sum = flux(environment_from_sky(sky, n));
        EXPECT_NEAR(sum.x, 2 * pi * 0.75, 1e-6) << n;
        EXPECT_NEAR(sum.y, 2 * pi * 0.25, 1e-6) << n;
        EXPECT_NEAR(sum.z, 2 * pi, 1e-6) << n;
    }
}

TEST(Sky, GradientIsTheMeanOverEachTexel)
{
    SkySettings sky = dark();
    sky.zenith = {1, 0, 0};
    sky.horizon = {0, 1, 0};
    sky.ground = {0, 0, 1};
    constexpr int n = 16, s = 200;
    const Environment environment = environment_from_sky(sky, n);
    for (int i = 0; i < n * n; ++i) {
        const TexelXY<int> t = morton_decode(i);
        Vec3d mean{0, 0, 0};
        for (int k = 0; k < s * s; ++k) {
            // Points off the diagonals, on which the horizon runs.
            const UV<double> uv{(t.x + (k % s + 0.5) / s) / n, (t.y + (k / s + 0.25 + 0.5 * (k % 2)) / s) / n};
            const double z = direction_from_oct(uv).z, f = std::pow(1 - z, 3);
            mean = mean + (z > 0 ? Vec3d{1 - f, f, 0} : Vec3d{0, 0, 1}) * (1.0 / s / s);
        }
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(component(texel(environment, i), c), component(mean, c), 3e-3) << t.x << ", " << t.y;
    }
}

TEST(Sky, SunKeepsItsFluxWhateverItsSizeAndPlace)
{
    std::mt19937 random(21);
    std::normal_distribution<double> normal;
    std::vector<Vec3d> places{{0, 0, 1},  {0, 0, -1}, {1, 0, 0}, {0, 1, 0},
                              {-1, 0, 0}, {0, -3, 0}, {1, 1, 0}, {-1, 1, 1e-9}};
    for (int i = 0; i < 12; ++i)
        places.push_back({normal(random), normal(random), normal(random)});
    for (const double diameter_deg : {0.001, 0.05, 0.53, 2.0, 10.0, 100.0, 180.0}) {
        for (const Vec3d& place : places) {
            SkySettings sky = dark();
            sky.sun_direction = place;
            sky.sun_angular_diameter_deg = diameter_deg;
            sky.sun_irradiance = {10, 5, 1};
            const double radius = diameter_deg * pi / 360;
            const double expected = 2 * pi * (1 - std::cos(radius)) / (pi * std::sin(radius) * std::sin(radius));
            const Environment environment = environment_from_sky(sky, 256);
            const Vec3d sum = flux(environment);
            // 1 − cos loses its digits for the smallest; there the ratio is 1.
            const double ratio = diameter_deg < 0.1 ? 1.0 : expected;
            ASSERT_NEAR(sum.x, 10 * ratio, 3e-6 * 10 * ratio) << diameter_deg;
            ASSERT_NEAR(sum.z, 1 * ratio, 3e-6 * ratio) << diameter_deg;

            // All of it within a texel's reach of the disc, and full radiance well inside.
            const double radiance = 10 / (pi * std::sin(radius) * std::sin(radius));
            const Vec3d centre = normalized(place);
            for (int i = 0; i < 256 * 256; ++i) {
                const double angle =
                    2 * std::asin(std::min(1.0, 0.5 * length(texel_direction(environment, i) - centre)));
                if (angle > radius + 0.02) {
                    ASSERT_EQ(texel(environment, i).x, 0.0) << diameter_deg << " at " << angle;
                } else if (angle < radius - 0.02) {
                    ASSERT_NEAR(texel(environment, i).x, radiance, 2e-3 * radiance) << diameter_deg << " at " << angle;
                }
            }
        }
    }
}

TEST(Sky, SunIrradianceIsWhatASurfaceReceives)
{
    SkySettings sky = dark();
    sky.sun_irradiance = {2, 3, 4};
    for (const double diameter_deg : {0.53, 5.0, 40.0}) {
        sky.sun_angular_diameter_deg = diameter_deg;
        const Environment environment = environment_from_sky(sky, 512);
        const Vec3d normal = normalized(sky.sun_direction);
        double irradiance = 0;
        for (int i = 0; i < 512 * 512; ++i)
            irradiance += texel(environment, i).y * std::max(0.0, dot(texel_direction(environment, i), normal)) * 4 *
                          pi / 512 / 512;
        EXPECT_NEAR(irradiance, 3.0, 3e-4) << diameter_deg;
    }
}

TEST(Sky, DefaultIsBrightAboveAndHasItsSunInFrontAtTheLeft)
{
    const Environment environment = environment_from_sky(SkySettings{});
    EXPECT_EQ(environment.resolution(), 512);
    EXPECT_GT(environment.mean_luminance(), 0.3);
    EXPECT_LT(environment.mean_luminance(), 3.0);
    EXPECT_GT(environment.radiance({-0.5, -0.5, 0.70711}).x, 1000.0);
    const Vec3d zenith = environment.radiance({0, 0, 1}), ground = environment.radiance({0, 0, -1});
    EXPECT_GT(zenith.z, zenith.x);
    EXPECT_LT(ground.z, zenith.z);
}

TEST(Sky, RefusesImpossibleSettings)
{
    const auto refused = [](auto change) {
        SkySettings sky;
        change(sky);
        EXPECT_THROW(environment_from_sky(sky, 16), Error);
    };
    refused([](SkySettings& s) { s.zenith.x = -1; });
    refused([](SkySettings& s) { s.horizon.y = std::nan(""); });
    refused([](SkySettings& s) { s.ground.z = std::numeric_limits<double>::infinity(); });
    refused([](SkySettings& s) { s.sun_irradiance.x = -1; });
    refused([](SkySettings& s) { s.sun_direction = {0, 0, 0}; });
    refused([](SkySettings& s) { s.sun_direction.x = std::nan(""); });
    refused([](SkySettings& s) { s.sun_angular_diameter_deg = 0; });
    refused([](SkySettings& s) { s.sun_angular_diameter_deg = 181; });
    EXPECT_THROW(environment_from_sky(SkySettings{}, 12), Error);
    EXPECT_THROW(environment_from_sky(SkySettings{}, 4), Error);
}

} // namespace
} // namespace lumisweep
