// What a session refuses, and scenes at the borders of what it takes.
#include <gtest/gtest.h>

#include <limits>

#include "lumisweep/base/error.h"
#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

SessionInput small_box(double extinction)
{
    SessionInput input =
        test::homogeneous({4, 4, 4}, test::centered({4, 4, 4}, {1.0, 1.0, 1.0}), extinction, {1.0, 1.0, 1.0});
    input.image = {8, 8, false};
    return input;
}

std::string refusal(const SessionInput& input)
{
    try {
        Session(input, make_cpu_backend());
        return "";
    } catch (const Error& error) {
        return error.what();
    }
}

TEST(SessionTest, RefusesWhatItCannotTrack)
{
    EXPECT_EQ(refusal(small_box(1e4)), "");
    EXPECT_NE(refusal(small_box(1e6)).find("transfer_function: extinction 1e+06"), std::string::npos);
    Session session(small_box(1.0), make_cpu_backend());
    EXPECT_THROW(session.set_transfer_function(TransferFunction({{0.0, 1e7, {1.0, 1.0, 1.0}}})), Error);
}

TEST(SessionTest, RefusesMissingAndImpossibleInput)
{
    SessionInput input = small_box(1.0);
    input.volume = nullptr;
    EXPECT_NE(refusal(input).find("volume"), std::string::npos);
    input = small_box(1.0);
    input.environment = nullptr;
    EXPECT_NE(refusal(input).find("environment"), std::string::npos);
    input = small_box(1.0);
    input.camera.position = {1e100, 0.0, 0.0};
    EXPECT_NE(refusal(input).find("camera.position"), std::string::npos);
    input = small_box(1.0);
    input.camera.up = {0.0, 1.0, 0.0}; // along the view
    EXPECT_NE(refusal(input).find("camera.up"), std::string::npos);
}

TEST(SessionTest, NonFiniteVoxelsAreEmpty)
{
    // Along y the upper half is NaN: interpolation touches it from the centre of voxel 7 on, so 7.5 voxels are left.
    auto volume =
        std::make_shared<ScalarGrid>(VoxelType::f32, Vec3i{3, 16, 3}, test::centered({3, 16, 3}, {1.0, 1.0, 1.0}));
    for (int i = 0; i < 3 * 16 * 3; ++i)
        volume->voxels<float>()[i] = i / 3 % 16 < 8 ? 1.0F : std::numeric_limits<float>::quiet_NaN();
    SessionInput input;
    input.volume = volume;
    input.transfer_function = TransferFunction({{0.0, 0.2, {1.0, 1.0, 1.0}}});
    input.environment = test::constant_light();
    input.image = {64, 64, false};
    input.camera = test::needle({0.0, -30.0, 0.0}, {0.0, 0.0, 0.0});
    const auto session = test::rendered(input, test::effort(100));
    test::expect_close(test::overall_alpha(session->film()), 1.0 - std::exp(-0.2 * 7.5),
                       test::full_effort ? 1e-3 : 5e-3, "coverage");
    EXPECT_TRUE(std::isfinite(test::overall(session->film()).mean));
}

TEST(SessionTest, EnvironmentCoarserThanTheDirections)
{
    SessionInput input = small_box(0.5);
    input.environment = test::one_texel_light(2, {1.0, 0.3, 0.4}, {3.0, 3.0, 3.0}, {0.2, 0.2, 0.2});
    input.visibility.directions = 16;
    input.image = {64, 64, false};
    input.camera = test::needle({0.0, -30.0, 0.0}, {0.0, 0.0, 0.0});
    input.render.strategy = Strategy::uniform;
    const auto expected = test::overall(test::rendered(input, test::effort(100))->film());
    input.render.seed = 1;
    for (const Strategy strategy :
         {Strategy::environment, Strategy::visibility, Strategy::combined, Strategy::two_step}) {
        input.render.strategy = strategy;
        const auto found = test::overall(test::rendered(input, test::effort(100))->film());
        const double error = std::hypot(expected.error, found.error);
        EXPECT_LT(error, 0.01 * expected.mean * (test::full_effort ? 1.0 : 3.0));
        EXPECT_LT(std::fabs(found.mean - expected.mean), 4.0 * error) << name_of(strategy);
    }
}

TEST(SessionTest, ShearedBoxAgainstQuadrature)
{
    // A parallelepiped: the y edges lean along +x, the z edges along +x and +y, as a tilted gantry leaves them.
    const Vec3i size{6, 7, 5};
    Affine3d world_from_voxel;
    world_from_voxel.column = {{{0.5, 0.0, 0.0}, {0.2, 0.4, 0.0}, {0.15, -0.1, 0.6}}};
    world_from_voxel.offset = world_from_voxel.vector({3.0, 3.5, 2.5}) * -1.0;
    const Affine3d voxel_from_world = inverse(world_from_voxel);
    const auto distance = [&](const Vec3d& p_world, const Vec3d& w_world) {
        const Vec3d p = voxel_from_world.point(p_world), w = voxel_from_world.vector(w_world);
        double t = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            const double d = component(w, axis);
            const double side = d > 0.0 ? component(size, axis) : 0.0;
            if (d != 0.0)
                t = std::min(t, (side - component(p, axis)) / d);
        }
        return t;
    };
    const double sigma = 0.8;
    constexpr int n = 16;
    const Vec3d w_light = normalized({0.7, -0.3, 0.6}), radiance{50.0, 50.0, 50.0};
    const UV<double> uv = oct_from_direction(w_light);
    const Vec3d forward = normalized({0.3, 1.0, 0.2});
    const double behind = distance({0.0, 0.0, 0.0}, forward * -1.0), ahead = distance({0.0, 0.0, 0.0}, forward);

    constexpr int steps = 400, fine = 12;
    double expected = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double t = (i + 0.5) / steps * (behind + ahead);
        const Vec3d p = forward * (t - behind);
        double light = 0.0;
        for (int a = 0; a < fine * fine; ++a) {
            const UV<double> point{(std::floor(uv.u * n) + (a % fine + 0.5) / fine) / n,
                                   (std::floor(uv.v * n) + (a / fine + 0.5) / fine) / n};
            light += std::exp(-sigma * distance(p, direction_from_oct(point))) / (fine * fine);
        }
        // 1/4π over the texel's 4π/n² sr.
        expected += sigma * std::exp(-sigma * t) * light * radiance.x / (n * n) * (behind + ahead) / steps;
    }
    SessionInput input = test::homogeneous(size, world_from_voxel, sigma, {1.0, 1.0, 1.0});
    input.environment = test::one_texel_light(n, w_light, radiance);
    input.image = {64, 64, false};
    input.camera = test::needle(forward * -20.0, {0.0, 0.0, 0.0});
    const auto session = test::rendered(input, test::effort(200));
    test::expect_close(test::overall_alpha(session->film()), 1.0 - std::exp(-sigma * (behind + ahead)), 3e-3,
                       "coverage");
    test::expect_close(test::overall(session->film()), expected, (test::full_effort ? 2e-3 : 8e-3) * expected, "light");
}

} // namespace
} // namespace lumisweep
