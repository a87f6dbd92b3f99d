// Every transmittance estimator on every instruction set against quadrature in double, along single rays.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "../tests/support/statistics.h"
#include "transmittance.h"

namespace lumisweep::bench {
namespace {

struct Medium {
    ScalarGrid volume;
    TransferFunction transfer_function;
};

/// Smooth noise: a random value per voxel, blurred by trilinear interpolation only, so that it varies within cells.
Medium noise(double mean_depth, const std::vector<TransferPoint>& shape)
{
    const Vec3i size{21, 18, 23};
    Affine3d world_from_voxel;
    world_from_voxel.column = {{{0.9, 0.0, 0.0}, {0.0, 1.1, 0.0}, {0.1, 0.0, 1.0}}};
    world_from_voxel.offset = {-9.0, -10.0, -11.0};
    Medium medium{ScalarGrid(VoxelType::f32, size, world_from_voxel), TransferFunction(shape, mean_depth / 20.0)};
    std::mt19937_64 random(7);
    std::uniform_real_distribution<float> unit;
    float* voxels = medium.volume.voxels<float>();
    std::generate_n(voxels, size.x * size.y * size.z, [&] { return unit(random); });
    return medium;
}

struct Ray {
    Vec3f origin, direction; // voxels; voxels per world unit
};

/// From inside the volume; single precision, as the estimators have it.
std::vector<Ray> random_rays(const ScalarGrid& volume, int count)
{
    std::mt19937_64 random(8);
    std::uniform_real_distribution<double> unit;
    std::normal_distribution<double> normal;
    std::vector<Ray> rays;
    for (int i = 0; i < count; ++i) {
        const Vec3i n = volume.size();
        const Vec3d w = normalized({normal(random), normal(random), normal(random)});
        rays.push_back({to_float(Vec3d{unit(random) * n.x, unit(random) * n.y, unit(random) * n.z}),
                        to_float(volume.voxel_from_world().vector(w))});
    }
    return rays;
}

double trilinear_value(const ScalarGrid& volume, const Vec3d& p)
{
    const float* voxels = volume.voxels<float>();
    const Vec3i n = volume.size();
    const auto axis = [](double x, int count, int& base, double& fraction) {
        const double q = std::clamp(x - 0.5, 0.0, count - 1.0);
        base = std::min(static_cast<int>(q), count - 2);
        fraction = q - base;
    };
    int i = 0, j = 0, k = 0;
    double fx = 0.0, fy = 0.0, fz = 0.0;
    axis(p.x, n.x, i, fx), axis(p.y, n.y, j, fy), axis(p.z, n.z, k, fz);
    double value = 0.0;
    for (int c = 0; c < 8; ++c) {
        const int x = i + (c & 1), y = j + (c >> 1 & 1), z = k + (c >> 2);
        const double w =
            ((c & 1) != 0 ? fx : 1.0 - fx) * ((c & 2) != 0 ? fy : 1.0 - fy) * ((c & 4) != 0 ? fz : 1.0 - fz);
        value += w * static_cast<double>(voxels[x + n.x * (y + n.y * z)]);
    }
    return value;
}

/// ∫σ to the border of the volume by the midpoint rule.
double optical_depth(const Medium& medium, const Ray& ray)
{
    const Vec3i n = medium.volume.size();
    const Vec3d o = to_double(ray.origin), d = to_double(ray.direction);
    double length = 1e9;
    for (int axis = 0; axis < 3; ++axis)
        length = std::min(length, ((component(d, axis) > 0.0 ? component(n, axis) : 0.0) - component(o, axis)) /
                                      component(d, axis));
    const int steps = 40000;
    double sum = 0.0;
    for (int i = 0; i < steps; ++i)
        sum += medium.transfer_function.evaluate(trilinear_value(medium.volume, o + d * (length * (i + 0.5) / steps)))
                   .extinction;
    return sum * length / steps;
}

struct Case {
    Transmittance method;
    float threshold;
    Control control = Control::smallest;
};
// The roulette's thresholds: none, the renderer's, the start, and before the start.
const std::vector<Case> cases{{Transmittance::delta, 1.0F},
                              {Transmittance::ratio, 0.0F},
                              {Transmittance::ratio, 0.1F},
                              {Transmittance::ratio, 1.0F},
                              {Transmittance::ratio, 3.0F},
                              {Transmittance::residual, 0.1F},
                              {Transmittance::residual, 1.0F},
                              {Transmittance::residual, 3.0F},
                              {Transmittance::residual, 0.0F},
                              {Transmittance::residual, 0.1F, Control::centred},
                              {Transmittance::residual, 3.0F, Control::centred},
                              {Transmittance::march, 0.0F},
                              {Transmittance::bounded_march, 0.1F},
                              {Transmittance::bounded_march, 1.0F}};

/// `count` independent estimates along one ray.
std::vector<float> estimates(const TransmittanceKernels& kernels, const Medium& medium, const Ray& ray, const Case& c,
                             int count)
{
    const CellBounds bounds(medium.volume, medium.transfer_function);
    ShadowRays rays(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
            rays.sink().origin[axis][i] = component(ray.origin, axis);
            rays.sink().direction[axis][i] = component(ray.direction, axis);
        }
        rays.sink().key[0][i] = i;
        rays.sink().key[1][i] = 77;
    }
    rays.sink().count = count;
    std::vector<float> threshold(static_cast<std::size_t>(count) + 16, c.threshold), out(threshold.size());
    std::vector<float> combs(threshold.size() * (largest_order + 1));
    TransmittanceJob job;
    job.scene.voxel_type = VoxelType::f32;
    job.scene.voxels = medium.volume.data();
    job.scene.size = medium.volume.size();
    job.scene.transfer_function = medium.transfer_function.view(medium.volume.slope(), medium.volume.intercept());
    job.bounds = bounds.view(c.control);
    job.rays = rays.view();
    job.method = c.method;
    job.threshold = threshold.data();
    job.estimates = out.data();
    job.combs = combs.data();
    kernels.estimate(job);
    out.resize(static_cast<std::size_t>(count));
    return out;
}

void expect_quadrature(const Medium& medium, int ray_count, int estimate_count)
{
    const std::vector<Ray> rays = random_rays(medium.volume, ray_count);
    const auto kernels = transmittance_kernels();
    const double tests = static_cast<double>(rays.size() * kernels.size() * cases.size());
    int varied = 0;
    for (const Ray& ray : rays) {
        const double expected = std::exp(-optical_depth(medium, ray));
        for (const TransmittanceKernels& k : kernels) {
            for (const Case& c : cases) {
                test::Moments moments;
                for (const float t : estimates(k, medium, ray, c, estimate_count))
                    moments.add(static_cast<double>(t));
                const double difference = std::fabs(moments.mean() - expected);
                varied += moments.standard_error() > 0.0 ? 1 : 0;
                // Rounding: positions of cells in single precision.
                if (difference > 2e-5 * expected + 1e-9) {
                    EXPECT_GT(test::normal_p(difference / std::max(moments.standard_error(), 1e-12)),
                              test::sidak(1e-3, tests))
                        << k.name << " method " << static_cast<int>(c.method) << " threshold " << c.threshold
                        << " control " << static_cast<int>(c.control) << " mean " << moments.mean() << " expected "
                        << expected;
                }
            }
        }
    }
    EXPECT_GT(varied, static_cast<int>(tests) / 2);
}

TEST(Transmittance, ThinMedium) { expect_quadrature(noise(0.5, {{0.0, 0.2}, {1.0, 1.5}}), 3, 200000); }

TEST(Transmittance, MeanOpticalDepthOfThree)
{
    expect_quadrature(noise(6.0, {{0.3, 0.0}, {0.5, 0.3}, {0.5, 1.0}, {1.0, 2.0}}), 3, 200000);
}

// Steep and mostly opaque: only rays that start near the border see light, so the answer is often almost 0.
TEST(Transmittance, OpaqueMedium) { expect_quadrature(noise(60.0, {{0.6, 0.0}, {0.7, 3.0}, {1.0, 6.0}}), 3, 60000); }

// Thousands of mean free paths: every estimate is finite, all but 0, and soon there.
TEST(Transmittance, OpticalDepthOfThousands)
{
    const Medium medium = noise(8000.0, {{0.0, 1.0}, {1.0, 1.2}});
    const Ray ray{{0.7F, 9.1F, 11.3F}, {1.0F, 0.07F, 0.03F}};
    ASSERT_GT(optical_depth(medium, ray), 5000.0);
    for (const TransmittanceKernels& k : transmittance_kernels())
        for (const Case& c : cases)
            for (const float t : estimates(k, medium, ray, c, 64))
                EXPECT_TRUE(t >= 0.0F && t < 1e-30F) << k.name << " " << static_cast<int>(c.method) << " " << t;
}

// Where nothing is, no random number may matter; where extinction is constant, marching and the closed part are
// exact.
TEST(Transmittance, HomogeneousMediumWithoutVariance)
{
    Medium medium = noise(20.0, {{0.0, 0.25}});
    const Ray ray{{3.2F, 9.1F, 11.3F}, {1.0F, 0.07F, 0.03F}};
    const double expected = std::exp(-optical_depth(medium, ray));
    for (const TransmittanceKernels& k : transmittance_kernels())
        for (const Transmittance method : {Transmittance::march, Transmittance::bounded_march})
            for (const float t : estimates(k, medium, ray, {method, 0.0F}, 64))
                EXPECT_NEAR(t, expected, 2e-4 * expected) << k.name;
    medium = noise(20.0, {{0.0, 0.0}});
    for (const TransmittanceKernels& k : transmittance_kernels())
        for (const Case& c : cases)
            if (c.threshold <= 1.0F) {
                const std::vector<float> all = estimates(k, medium, ray, c, 64);
                EXPECT_EQ(std::accumulate(all.begin(), all.end(), 0.0F), 64.0F) << k.name;
            }
}

} // namespace
} // namespace lumisweep::bench
