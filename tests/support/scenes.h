// Sessions for tests: a scene in one struct, images by channel, and means with their standard errors.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/light/sky.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/render/session.h"
#include "support/statistics.h"
#include "support/volumes.h"

namespace lumisweep::test {

inline std::shared_ptr<const Environment> constant_light(const Vec3d& radiance = {1.0, 1.0, 1.0})
{
    return std::make_shared<Environment>(Environment::constant(radiance));
}

/// A map that is black but for the texel that holds w_world.
inline std::shared_ptr<const Environment> one_texel_light(int n, const Vec3d& w_world, const Vec3d& radiance,
                                                          const Vec3d& elsewhere = {0.0, 0.0, 0.0})
{
    AlignedArray<float> texels(3 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    const UV<double> uv = oct_from_direction(normalized(w_world));
    const auto texel = static_cast<std::size_t>(
        morton_encode(static_cast<std::int32_t>(uv.u * n), static_cast<std::int32_t>(uv.v * n)));
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = static_cast<float>(component(i / 3 == texel ? radiance : elsewhere, static_cast<int>(i % 3)));
    return std::make_shared<Environment>(n, std::move(texels));
}

inline std::shared_ptr<const Environment> sky_with_sun(int n = 64, double diameter_deg = 4.0)
{
    SkySettings sky;
    sky.sun_angular_diameter_deg = diameter_deg;
    return std::make_shared<Environment>(environment_from_sky(sky, n));
}

/// A homogeneous box of the given extinction and albedo: one voxel value everywhere.
inline SessionInput homogeneous(const Vec3i& size, const Affine3d& world_from_voxel, double extinction,
                                const Vec3d& albedo)
{
    SessionInput input;
    input.volume = constant_grid(size, world_from_voxel);
    input.transfer_function = TransferFunction({{0.0, extinction, albedo}});
    input.environment = constant_light();
    return input;
}

/// A pinhole so narrow that all its rays are one.
inline Camera needle(const Vec3d& position, const Vec3d& target)
{
    Camera camera;
    camera.position = position;
    camera.target = target;
    const Vec3d d = normalized(target - position);
    camera.up = std::fabs(d.z) < 0.9 ? Vec3d{0.0, 0.0, 1.0} : Vec3d{0.0, 1.0, 0.0};
    camera.vertical_fov_deg = 1e-4;
    return camera;
}

inline std::unique_ptr<Session> rendered(const SessionInput& input, int passes, const std::string& isa = "auto")
{
    auto session = std::make_unique<Session>(input, make_cpu_backend(isa));
    for (int i = 0; i < passes; ++i)
        session->render_pass();
    return session;
}

inline const std::vector<float>& channel(const Image& image, const std::string& name)
{
    return image.find(name)->pixels;
}

/// Mean and standard error.
struct Estimate {
    double mean = 0.0, error = 0.0;
};

/// Of a colour channel over all pixels and samples of a film whose pixels all see the same.
inline Estimate overall(const Film& film, int color = 0)
{
    double sum = 0.0, variance = 0.0;
    const auto pixels = static_cast<std::size_t>(film.width()) * static_cast<std::size_t>(film.height());
    for (std::size_t p = 0; p < pixels; ++p) {
        sum += film.color_sum()[3 * p + static_cast<std::size_t>(color)];
        variance += film.unbiased_variance_of_mean(3 * p + static_cast<std::size_t>(color));
    }
    const auto n = static_cast<double>(pixels);
    return {sum / n / static_cast<double>(film.samples()), std::sqrt(variance) / n};
}

/// Likewise of the coverage A: a binomial proportion; the error is too large where samples are stratified.
inline Estimate overall_alpha(const Film& film)
{
    double sum = 0.0;
    const auto pixels = static_cast<std::size_t>(film.width()) * static_cast<std::size_t>(film.height());
    for (std::size_t p = 0; p < pixels; ++p)
        sum += film.features()[feature_count * p + 7];
    const double n = static_cast<double>(pixels) * static_cast<double>(film.samples());
    return {sum / n, std::sqrt(std::max(sum / n * (1.0 - sum / n), 0.0) / n)};
}

/// Expects |z| < 4 and a standard error that makes that worth something; float rounding is allowed 2e-6.
inline void expect_close(const Estimate& estimate, double expected, double largest_error, const std::string& what)
{
    EXPECT_LE(estimate.error, largest_error) << what;
    EXPECT_LE(std::fabs(estimate.mean - expected), 4.0 * estimate.error + 2e-6 * std::fabs(expected))
        << what << ": " << estimate.mean << " ± " << estimate.error << ", expected " << expected;
}

inline const Strategy all_strategies[] = {Strategy::uniform,  Strategy::environment, Strategy::visibility,
                                          Strategy::combined, Strategy::two_step,    Strategy::automatic};

} // namespace lumisweep::test
