// Sessions on the device, beside the same on the CPU's scalar instantiation. The tests are built twice: over the
// emulated device, where arithmetic is the host's and all bits are equal, and over the GPU, whose log and exp round
// otherwise.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "lumisweep/backends/cuda/cuda_backend.h"
#include "lumisweep/render/backend.h"
#include "support/films.h"
#include "support/scenes.h"

namespace lumisweep::test {

#if defined(LUMISWEEP_EMULATED)
inline constexpr bool same_arithmetic = true;
#else
inline constexpr bool same_arithmetic = false;
#endif

inline std::unique_ptr<Session> cuda_session(const SessionInput& input)
{
    return std::make_unique<Session>(input, LUMISWEEP_CUDA::make_cuda_backend());
}

inline std::unique_ptr<Session> scalar_session(const SessionInput& input)
{
    return std::make_unique<Session>(input, make_cpu_backend("baseline"));
}

inline void render(Session& session, int passes)
{
    for (int i = 0; i < passes; ++i)
        ASSERT_EQ(session.render_pass(), PassEnd::complete);
}

/// A CT-like scene of 16-bit voxels, in a grid that is neither cubic nor even.
inline SessionInput small_ct(Vec3i size = {27, 30, 25})
{
    SessionInput input;
    input.volume = ct_like(size, centered(size, {1.0, 1.1, 0.9}));
    input.transfer_function = ct_transfer_function();
    input.environment = sky_with_sun(64);
    input.image = {53, 35, true};
    input.camera.position = {25.0, -70.0, 20.0};
    input.camera.vertical_fov_deg = 30.0;
    return input;
}

/// Thin smoke of 8-bit voxels, whose blocks have a least extinction, seen through a lens.
inline SessionInput small_smoke(Vec3i size = {32, 24, 28})
{
    SessionInput input = small_ct();
    input.volume = smoke_like(size, centered(size, {1.0, 1.0, 1.0}));
    input.transfer_function = smoke_transfer_function();
    input.camera.lens_radius = 1.0;
    return input;
}

/// Whether a film on the device is that of the CPU: to the bit where arithmetic is the same, else but for the few
/// samples for which a rounding has decided otherwise.
inline ::testing::AssertionResult same_paths(const Film& device, const Film& host)
{
    if (same_arithmetic)
        return same_film(device, host);
    const AlignedArray<double>&a = device.color_sum(), &b = host.color_sum();
    std::size_t differ = a.size() == b.size() ? 0 : a.size();
    for (std::size_t i = 0; differ < a.size() && i < a.size(); ++i)
        differ += std::fabs(a[i] - b[i]) > 1e-3 * std::fabs(b[i]) + 1e-6 ? 1 : 0;
    if (differ > 3 && differ * 50 > a.size()) // of the smallest images one pixel
        return ::testing::AssertionFailure() << differ << " of " << a.size() << " values differ";
    return ::testing::AssertionSuccess();
}

inline SessionInput two_step_ct()
{
    SessionInput input = small_ct();
    input.render.strategy = Strategy::two_step;
    return input;
}

/// The image of a session that was made with this input.
inline void expect_fresh(Session& edited, const SessionInput& input, const std::string& what)
{
    const auto fresh = scalar_session(input);
    render(edited, 2);
    render(*fresh, 2);
    EXPECT_TRUE(same_paths(edited.film(), fresh->film())) << what;
}

} // namespace lumisweep::test
