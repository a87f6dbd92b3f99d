// Heterogeneous media against quadrature: a linear ramp under one texel of light, and a sphere from a distance field.
#include <gtest/gtest.h>

#include "support/box_oracle.h"
#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;
using test::expect_close;

// σ(x, y, z) = slope · z' with z' the value that clamps beyond the outer centres; light from one texel around +X, seen
// along Y: everything depends on z alone, so the light's path is a straight line of constant or linear extinction.
TEST(Heterogeneous, RampUnderOneTexel)
{
    const Vec3i size{6, 5, 11};
    const Vec3d spacing{0.5, 0.4, 0.3}, half{1.5, 1.0, 1.65};
    // i16 values −100 … with slope and intercept: σ = 0.1 + 0.2 · k at the centre of layer k.
    SessionInput input;
    input.volume = test::make_grid<std::int16_t>(
        VoxelType::i16, size, test::centered(size, spacing), [](int, int, int k) { return 40 * k - 100; }, 0.005, 0.6);
    input.transfer_function =
        TransferFunction({{-10.0, 0.0, {1.0, 1.0, 1.0}}, {0.0, 0.0, {1.0, 1.0, 1.0}}, {10.0, 10.0, {1.0, 1.0, 1.0}}});
    const auto sigma = [&](double z) { return 0.1 + 0.2 * std::clamp((z + half.z) / spacing.z - 0.5, 0.0, 10.0); };
    // ∫ σ over [a, b] in z, per unit of z.
    const test::GaussLegendre rule(16);
    const auto depth_between = [&](double a, double b) {
        double sum = 0.0;
        const double cuts[4] = {-half.z, -half.z + 0.5 * spacing.z, half.z - 0.5 * spacing.z, half.z};
        for (int i = 0; i < 3; ++i) {
            const double low = std::max(a, cuts[i]), high = std::min(b, cuts[i + 1]);
            if (low < high)
                sum += rule(low, high, sigma);
        }
        return sum;
    };
    const int n = 32;
    for (const Vec3d& towards : {Vec3d{1.0, 0.02, 0.01}, Vec3d{0.02, 0.3, 1.0}, Vec3d{0.3, 0.02, -1.0}}) {
        input.environment = test::one_texel_light(n, towards, {1024.0, 1024.0, 1024.0});
        input.image = {64, 64, false};
        const Vec3d from{0.4, -1.0, 0.35}, to{0.4, 1.0, 0.35};
        input.camera = test::needle({0.4, -20.0, 0.35}, to);
        const UV<double> uv = oct_from_direction(normalized(towards));
        const int tx = static_cast<int>(uv.u * n), ty = static_cast<int>(uv.v * n);
        const double at_ray = sigma(0.35);
        const double expected = rule(0.0, 2.0, [&](double t) {
            const Vec3d p = from + Vec3d{0.0, t, 0.0};
            const double step = 1.0 / n;
            const double light = rule(tx * step, (tx + 1) * step, [&](double u) {
                return rule(ty * step, (ty + 1) * step, [&](double v) {
                    const Vec3d w = direction_from_oct(UV<double>{u, v});
                    const double s = test::distance_to_box(half, p, w), z_end = p.z + s * w.z;
                    const double depth =
                        std::fabs(w.z) > 1e-9
                            ? depth_between(std::min(p.z, z_end), std::max(p.z, z_end)) / std::fabs(w.z)
                            : s * sigma(p.z);
                    return std::exp(-depth);
                });
            });
            return std::exp(-at_ray * t) * at_ray * 1024.0 * light;
        });
        for (const Strategy strategy : {Strategy::environment, Strategy::two_step}) {
            input.render.strategy = strategy;
            const auto session = test::rendered(input, effort(700));
            const test::Estimate light = test::overall(session->film());
            EXPECT_LT(light.error, test::full_effort ? 2.5e-4 : 1e-3);
            // The quadrature meets edges of the box within the texel: 3e-4.
            EXPECT_NEAR(light.mean, expected, 4.0 * light.error + 3e-4 * expected)
                << towards.x << " " << name_of(strategy);
        }
    }
}

// A sphere of radius R as a distance field with a step at 0. Trilinear interpolation of the distance r errs by at most
// h²/(4R) (second derivatives 1/R in two directions, h²/8 each), so the surface is off by 6e-4 of the radius at 1/32
// spacing, and only inwards or outwards by that much, which bounds optical depth along the axis by 2 · 6e-4 · σ R.
TEST(Heterogeneous, SphereFromADistanceField)
{
    const Vec3i size{67, 66, 65};
    const double h = 1.0 / 32.0, sigma = 2.0;
    SessionInput input;
    input.volume =
        test::make_grid<float>(VoxelType::f32, size, test::centered(size, {h, h, h}), [&](int i, int j, int k) {
            const double x = (i + 0.5 - 33.5) * h, y = (j + 0.5 - 33.0) * h, z = (k + 0.5 - 32.5) * h;
            return 0.95 - std::sqrt(x * x + y * y + z * z);
        });
    const Vec3d albedo{0.8, 0.6, 0.4};
    input.transfer_function = TransferFunction({{0.0, 0.0, albedo}, {0.0, sigma, albedo}});
    input.environment = test::constant_light();
    input.image = {64, 64, true};
    input.visibility.cell = 8;
    input.camera = test::needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
    const double radius = 0.95, error = 2.0 * h * h / (4.0 * radius) * sigma;
    const test::GaussLegendre rule(48);
    // At distance r from the centre, a direction at cosine c to the radius leaves after −r c + √(R² − r²(1 − c²)).
    const double scattered = rule(0.0, 2.0 * radius, [&](double t) {
        const double r = std::fabs(t - radius);
        const double light =
            0.5 * rule(-1.0, 1.0, [&](double c) {
                return std::exp(-sigma * (-r * c + std::sqrt(radius * radius - r * r * (1.0 - c * c))));
            });
        return std::exp(-sigma * t) * sigma * light;
    });
    const double transmittance = std::exp(-2.0 * sigma * radius);
    const auto session = test::rendered(input, effort(500));
    for (int c = 0; c < 3; ++c) {
        const test::Estimate light = test::overall(session->film(), c);
        const double expected = component(albedo, c) * scattered + transmittance;
        EXPECT_LT(light.error, test::full_effort ? 3e-4 : 1e-3);
        EXPECT_NEAR(light.mean, expected, 4.0 * light.error + error * expected);
    }
    const test::Estimate alpha = test::overall_alpha(session->film());
    EXPECT_NEAR(alpha.mean, 1.0 - transmittance, 4.0 * alpha.error + error * transmittance);
}

// Empty space around an island, anisotropic: the same sphere in voxels of other shapes.
TEST(Heterogeneous, AnisotropicVoxelsShowTheSameSphere)
{
    test::Estimate estimates[2];
    int i = 0;
    for (const Vec3d& spacing : {Vec3d{0.05, 0.05, 0.05}, Vec3d{0.04, 0.05, 0.1}}) {
        const Vec3i size{static_cast<int>(2.0 / spacing.x) + 3, static_cast<int>(2.0 / spacing.y) + 3,
                         static_cast<int>(2.0 / spacing.z) + 3};
        const Affine3d world_from_voxel = test::centered(size, spacing);
        SessionInput input;
        input.volume = test::make_grid<float>(VoxelType::f32, size, world_from_voxel, [&](int x, int y, int z) {
            return 0.9 - length(world_from_voxel.point({x + 0.5, y + 0.5, z + 0.5}));
        });
        input.transfer_function = TransferFunction({{0.0, 0.0, {1.0, 1.0, 1.0}}, {0.3, 6.0, {1.0, 1.0, 1.0}}});
        input.environment = test::sky_with_sun(32, 10.0);
        input.image = {16, 16, false};
        input.camera.position = {0.0, -8.0, 1.0};
        input.camera.vertical_fov_deg = 20.0;
        const auto session = test::rendered(input, effort(2000));
        estimates[i++] = test::overall(session->film());
    }
    // Interpolation differs by h²/(4 r) of the distance: under 2 % of the light in the coarse volume.
    EXPECT_NEAR(estimates[0].mean, estimates[1].mean,
                4.0 * std::hypot(estimates[0].error, estimates[1].error) + 0.02 * estimates[0].mean);
}

} // namespace
} // namespace lumisweep
