// Closed forms in homogeneous boxes: transmittance, single scattering against quadrature, white light, orientation.
#include <gtest/gtest.h>

#include "support/box_oracle.h"
#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;
using test::expect_close;
using test::needle;

constexpr Vec3d white{1.0, 1.0, 1.0};

/// Single scattering per unit albedo and light along a ray from `from` (on the surface) to `to`.
double single_scattering(const Vec3d& half, double sigma, const Vec3d& from, const Vec3d& to)
{
    const test::GaussLegendre rule(24), fine(32);
    const double d = length(to - from);
    return fine(0.0, d, [&](double t) {
        const Vec3d p = from + (to - from) * (t / d);
        return std::exp(-sigma * t) * sigma * test::mean_light_in_box(half, sigma, p, rule);
    });
}

SessionInput with_image(SessionInput input, int side)
{
    input.image = {side, side, true};
    return input;
}

TEST(Oracle, MeanLightInBox)
{
    const test::GaussLegendre rule(24);
    const Vec3d half{1.0, 2.0, 0.5}, p{0.3, -1.1, 0.2};
    EXPECT_NEAR(test::mean_light_in_box(half, 0.0, p, rule), 1.0, 1e-10);
    // Against a plain midpoint rule over the octahedral map.
    const int n = 1024;
    double sum = 0.0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            sum += std::exp(
                -0.7 * test::distance_to_box(half, p, direction_from_oct(UV<double>{(x + 0.5) / n, (y + 0.5) / n})));
    EXPECT_NEAR(test::mean_light_in_box(half, 0.7, p, rule), sum / (double(n) * n), 1e-6);
}

// Sides that are not multiples of the majorant's cell: the medium must end with the volume's box.
TEST(Homogeneous, SingleScatteringOfOddBoxes)
{
    struct Case {
        Vec3i size;
        Vec3d spacing;
        Vec3d from, to; ///< in units of the half sides
    };
    const Case cases[] = {
        {{8, 8, 8}, {0.25, 0.25, 0.25}, {-1.0, 0.1, 0.2}, {1.0, 0.1, 0.2}},
        {{5, 7, 9}, {0.3, 0.2, 0.25}, {-1.0, 0.1, -0.2}, {1.0, 0.1, -0.2}},
        {{5, 7, 9}, {0.3, 0.2, 0.25}, {0.2, 1.0, -0.2}, {0.1, -1.0, 0.5}},
        {{1, 1, 1}, {1.0, 2.0, 3.0}, {0.0, 0.0, 1.0}, {0.3, 0.3, -1.0}},
        {{1, 6, 13}, {0.7, 0.4, 0.1}, {0.3, -1.0, 0.2}, {-0.5, 1.0, 0.0}},
    };
    const double sigma = 0.9;
    for (const Case& c : cases) {
        const Vec3d half{0.5 * c.size.x * c.spacing.x, 0.5 * c.size.y * c.spacing.y, 0.5 * c.size.z * c.spacing.z};
        const Vec3d from = half * c.from, to = half * c.to;
        SessionInput input =
            with_image(test::homogeneous(c.size, test::centered(c.size, c.spacing), sigma, {1.0, 0.5, 0.25}), 64);
        input.camera = needle(from + (from - to) * 3.0, to);
        const double expected = single_scattering(half, sigma, from, to);
        const double transmittance = std::exp(-sigma * length(to - from));
        EXPECT_LT(expected + transmittance, 1.0); // what single scattering loses
        for (const std::string& isa : available_isas()) {
            const std::string what = isa + " " + std::to_string(c.size.x) + "x" + std::to_string(c.size.y);
            // Four digits once: on the best instruction set, in the first two boxes.
            const bool precise = isa == available_isas().front() && &c < cases + 2;
            const auto session = test::rendered(input, effort(precise ? 1600 : 200), isa);
            const double allowed = (precise ? 2e-4 : 6e-4) * (test::full_effort ? 1.0 : 3.0);
            expect_close(test::overall(session->film(), 0), expected + transmittance, allowed, what);
            expect_close(test::overall(session->film(), 1), 0.5 * expected + transmittance, allowed, what);
            expect_close(test::overall(session->film(), 2), 0.25 * expected + transmittance, allowed, what);
            expect_close(test::overall_alpha(session->film()), 1.0 - transmittance, 2 * allowed, what);
        }
    }
}

TEST(Homogeneous, OpticalDepthsFromNothingToOpaque)
{
    const Vec3i size{6, 6, 6};
    for (const double depth : {0.0, 1e-3, 1.0, 1e3, 1e5}) {
        SessionInput input =
            with_image(test::homogeneous(size, test::centered(size, {1.0, 1.0, 1.0}), depth / 6.0, white), 64);
        input.camera = needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
        const auto session = test::rendered(input, effort(200));
        const test::Estimate alpha = test::overall_alpha(session->film()), light = test::overall(session->film());
        const std::string what = "optical depth " + std::to_string(depth);
        expect_close(alpha, -std::expm1(-depth), 1e-3, what);
        const double scattered = single_scattering({3.0, 3.0, 3.0}, depth / 6.0, {0.0, -3.0, 0.0}, {0.0, 3.0, 0.0});
        if (depth < 100.0)
            expect_close(light, scattered + std::exp(-depth), 2e-3, what);
        else // a half space of white albedo seen at right angles: (1/2) ∫₀^1 μ/(1+μ) dμ = (1 − ln 2) / 2
            expect_close(light, 0.5 * (1.0 - std::log(2.0)), 2e-3, what);
        if (depth == 0.0) {
            EXPECT_EQ(alpha.mean, 0.0);
            EXPECT_EQ(light.mean, 1.0);
        }
    }
}

TEST(Homogeneous, AlbedoZeroAndHiddenBackground)
{
    const Vec3i size{6, 6, 6};
    SessionInput input =
        with_image(test::homogeneous(size, test::centered(size, {1.0, 1.0, 1.0}), 0.2, {0.0, 0.0, 0.0}), 32);
    input.camera = needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
    input.environment = test::constant_light({1.0, 2.0, 4.0});
    const auto shown = test::rendered(input, effort(400));
    const double t = std::exp(-1.2);
    for (int c = 0; c < 3; ++c)
        expect_close(test::overall(shown->film(), c), t * (1 << c), 5e-3, "channel " + std::to_string(c));
    input.image.show_environment = false;
    const auto hidden = test::rendered(input, effort(400));
    EXPECT_EQ(test::overall(hidden->film()).mean, 0.0);
    expect_close(test::overall_alpha(hidden->film()), 1.0 - t, 3e-3, "hidden");
}

TEST(Homogeneous, EveryPoseOfTheBoxIsTheSame)
{
    const Vec3i size{5, 7, 9};
    const Vec3d spacing{0.3, 0.2, 0.25}, half{0.75, 0.7, 1.125};
    const Vec3d from = half * Vec3d{0.2, 1.0, -0.2}, to = half * Vec3d{0.1, -1.0, 0.5};
    const double sigma = 0.9;
    const double expected = single_scattering(half, sigma, from, to) + std::exp(-sigma * length(to - from));
    const Vec3d a = normalized({1.0, 2.0, -0.5}), b = normalized(cross(a, {0.3, 0.1, 1.0})), c = cross(a, b);
    for (const double mirror : {1.0, -1.0}) {
        for (const double distance : {0.0, 1e5}) {
            const Vec3d offset{distance, -0.7 * distance, 0.3 * distance};
            const auto pose = [&](const Vec3d& p) { return a * p.x + b * p.y + c * (p.z * mirror) + offset; };
            Affine3d world_from_voxel;
            world_from_voxel.column = {{a * spacing.x, b * spacing.y, c * (spacing.z * mirror)}};
            world_from_voxel.offset = pose(half * -1.0);
            SessionInput input = with_image(test::homogeneous(size, world_from_voxel, sigma, white), 64);
            input.camera = needle(pose(from + (from - to) * 3.0), pose(to));
            const auto session = test::rendered(input, effort(400));
            expect_close(test::overall(session->film()), expected, test::full_effort ? 4e-4 : 2e-3, "pose");
        }
    }
}

TEST(Homogeneous, CameraInside)
{
    const Vec3i size{5, 7, 9};
    const Vec3d half{2.5, 3.5, 4.5}, from{0.4, -1.0, 2.0}, to{0.4, 3.5, 2.0};
    SessionInput input = with_image(test::homogeneous(size, test::centered(size, {1.0, 1.0, 1.0}), 0.3, white), 64);
    input.camera = needle(from, to);
    const auto session = test::rendered(input, effort(400));
    const double expected = single_scattering(half, 0.3, from, to) + std::exp(-0.3 * 4.5);
    expect_close(test::overall(session->film()), expected, test::full_effort ? 4e-4 : 2e-3, "inside");
}

// One texel of light from +X: its direction is in world space, whatever the volume's own axes are.
TEST(Homogeneous, LightComesFromWhereItIs)
{
    const Vec3i size{6, 6, 6};
    const Vec3d half{3.0, 3.0, 3.0};
    const double sigma = 0.8;
    const int n = 8;
    const test::GaussLegendre rule(12);
    Affine3d straight = test::centered(size, {1.0, 1.0, 1.0});
    Affine3d turned = straight; // x of the voxels along −z of the world, y along x, z along y, mirrored
    turned.column = {{{0.0, 0.0, -1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}};
    turned.offset = {-3.0, -3.0, 3.0};
    const Vec3d lights[] = {{1.0, 0.05, 0.1}, {-0.1, 1.0, 0.1}, {0.1, 0.05, 1.0}, {0.05, 0.1, -1.0}, {-1.0, 0.1, 0.2}};
    for (const Affine3d& world_from_voxel : {straight, turned}) {
        for (const Vec3d& towards : lights) {
            SessionInput input = with_image(test::homogeneous(size, world_from_voxel, sigma, white), 32);
            input.environment = test::one_texel_light(n, towards, {64.0, 64.0, 64.0});
            input.image.show_environment = false;
            const UV<double> uv = oct_from_direction(normalized(towards));
            const Vec3d from{1.5, -3.0, 1.0}, to{1.5, 3.0, 1.0};
            input.camera = needle({1.5, -20.0, 1.0}, to);
            const double expected = rule(0.0, 6.0, [&](double t) {
                return std::exp(-sigma * t) * sigma * 64.0 *
                       test::texel_light_in_box(half, sigma, from + Vec3d{0.0, t, 0.0}, n, static_cast<int>(uv.u * n),
                                                static_cast<int>(uv.v * n), rule);
            });
            const auto session = test::rendered(input, effort(600));
            // The texel's quadrature crosses edges of the box: 1e-3 of the light.
            const test::Estimate light = test::overall(session->film());
            EXPECT_LT(light.error, test::full_effort ? 2e-3 : 8e-3);
            EXPECT_NEAR(light.mean, expected, 4.0 * light.error + 1e-3 * expected) << towards.x << " " << towards.y;
        }
    }
}

// Behind the volume stands the environment, the right way round: each texel's centre shows that texel and no other.
TEST(Homogeneous, BackgroundIsWhereItsLightComesFrom)
{
    Affine3d turned = test::centered({2, 2, 2}, {1.0, 1.0, 1.0});
    turned.column = {{{0.0, 0.0, -1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}};
    SessionInput input = with_image(test::homogeneous({2, 2, 2}, turned, 0.0, white), 4);
    const int n = 8;
    for (int lit = 0; lit < n * n; lit += 7) {
        input.environment = test::one_texel_light(n, texel_direction(lit, n), {3.0, 2.0, 1.0});
        for (int seen = 0; seen < n * n; ++seen) {
            input.camera = needle({0.1, 0.2, 0.3}, Vec3d{0.1, 0.2, 0.3} + texel_direction(seen, n));
            const auto session = test::rendered(input, 2);
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(test::overall(session->film(), c).mean, seen == lit ? 3.0 - c : 0.0) << lit << " " << seen;
        }
    }
}

} // namespace
} // namespace lumisweep
