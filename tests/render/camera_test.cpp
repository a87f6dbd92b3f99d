// The camera against geometry: which pixel sees what, and the thin lens.
#include <gtest/gtest.h>

#include "lumisweep/render/camera.h"
#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;

/// A cube of one opaque voxel whose box has the given side, centred at p.
SessionInput opaque_cube(const Vec3d& p, double side)
{
    SessionInput input =
        test::homogeneous({1, 1, 1}, test::centered({1, 1, 1}, {side, side, side}, p), 5e5 / side, {1.0, 1.0, 1.0});
    input.render.strategy = Strategy::uniform;
    return input;
}

TEST(CameraTest, PixelsSeeWhatGeometrySays)
{
    Camera camera;
    camera.position = {3.0, -5.0, 2.0};
    camera.target = {-1.0, 4.0, 0.5};
    camera.up = {0.1, 0.2, 1.0};
    camera.vertical_fov_deg = 40.0;
    const int width = 31, height = 17;
    const Vec3d forward = normalized(camera.target - camera.position);
    const Vec3d right = normalized(cross(forward, camera.up)), up = cross(right, forward);
    const double pixel = 2.0 * std::tan(20.0 * pi / 180.0) / height; // at distance 1
    for (const auto& [px, py] : {std::pair{0, 0}, {30, 0}, {0, 16}, {30, 16}, {15, 8}, {22, 3}}) {
        // Right is right and up is up: column 0 is on the left, row 0 at the top.
        const Vec3d w = forward + right * ((px + 0.5 - 0.5 * width) * pixel) + up * ((0.5 * height - py - 0.5) * pixel);
        SessionInput input = opaque_cube(camera.position + w * 7.0, 0.2 * 7.0 * pixel);
        input.camera = camera;
        input.image = {width, height, false};
        const auto session = test::rendered(input, 300);
        const Image image = session->film().to_image();
        const std::vector<float>& alpha = test::channel(image, "A");
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                EXPECT_EQ(alpha[static_cast<std::size_t>(y * width + x)] > 0.0F, x == px && y == py) << x << " " << y;
    }
}

TEST(CameraTest, DirectionsOfTheCorners)
{
    Camera camera;
    camera.position = {1.0, 2.0, 3.0};
    camera.target = {1.0, 5.0, 3.0};
    camera.vertical_fov_deg = 90.0;
    const auto volume = test::constant_grid({2, 2, 2}, Affine3d{});
    const CameraView view = camera_view(camera, {200, 100, true}, *volume);
    const Ray<float> top_left = camera_ray(view, 0.0F, 0.0F, 0.3F, 0.4F);
    const Vec3d expected = normalized({-2.0, 1.0, 1.0});
    EXPECT_NEAR(top_left.direction.x, expected.x, 1e-6);
    EXPECT_NEAR(top_left.direction.y, expected.y, 1e-6);
    EXPECT_NEAR(top_left.direction.z, expected.z, 1e-6);
    EXPECT_EQ(top_left.origin.x, 0.0F); // relative to the box's centre (1, 1, 1)
    EXPECT_EQ(top_left.origin.y, 1.0F);
    EXPECT_EQ(top_left.origin.z, 2.0F);
    const std::array<double, 16> m = camera.camera_from_world();
    const double q[3] = {1.5, 6.0, 3.25}; // to the right, in front, above
    double r[3];
    for (int i = 0; i < 3; ++i)
        r[i] = m[static_cast<std::size_t>(4 * i)] * q[0] + m[static_cast<std::size_t>(4 * i + 1)] * q[1] +
               m[static_cast<std::size_t>(4 * i + 2)] * q[2] + m[static_cast<std::size_t>(4 * i + 3)];
    EXPECT_NEAR(r[0], 0.5, 1e-12);
    EXPECT_NEAR(r[1], 0.25, 1e-12);
    EXPECT_NEAR(r[2], 4.0, 1e-12);
}

TEST(CameraTest, DiscIsUniform)
{
    constexpr int n = 256;
    double second = 0.0, xy = 0.0, sum_x = 0.0, sum_y = 0.0, largest = 0.0;
    int sector[16] = {};
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const Vec3<float> p = uniform_disc((i + 0.5F) / n, (j + 0.5F) / n);
            const double r2 = double(p.x) * p.x + double(p.y) * p.y;
            EXPECT_NEAR(r2, (i + 0.5) / n, 1e-6);
            largest = std::max(largest, r2), second += r2, xy += double(p.x) * p.y, sum_x += p.x, sum_y += p.y;
            ++sector[static_cast<int>((std::atan2(p.y, p.x) / pi + 1.0) * 8.0) & 15];
        }
    EXPECT_NEAR(second / (n * n), 0.5, 1e-5);
    EXPECT_NEAR(xy / (n * n), 0.0, 1e-5);
    EXPECT_NEAR(sum_x / (n * n), 0.0, 1e-5);
    EXPECT_NEAR(sum_y / (n * n), 0.0, 1e-5);
    for (const int count : sector)
        EXPECT_NEAR(count, n * n / 16, 1) << "by angle";
}

// An opaque, thin half plane, x ≥ 0, at twice the focus distance: a pixel whose ray meets the focus plane at x_f sees
// through the lens point a the position 2 x_f − a there, so it is covered where a ≤ 2 x_f: a segment of the lens's
// disc.
TEST(CameraTest, DefocusedEdgeIsACircleSegment)
{
    const double radius = 0.5, focus = 10.0, distance = 20.0;
    SessionInput input = test::homogeneous({1, 1, 1}, test::centered({1, 1, 1}, {10.0, 1e-3, 20.0}, {5.0, 0.0, 0.0}),
                                           4e4, {1.0, 1.0, 1.0});
    input.render.strategy = Strategy::uniform;
    input.image = {64, 8, false};
    input.camera.position = {0.0, -distance, 0.0};
    input.camera.target = {0.0, 0.0, 0.0};
    input.camera.lens_radius = radius;
    input.camera.focus_distance = focus;
    input.camera.vertical_fov_deg = 2.0 * std::atan(0.04 / 2.0) * 180.0 / pi; // 0.4 at the focus plane, 3.2 wide
    const int passes = effort(8000);
    const auto session = test::rendered(input, passes);
    const Image image = session->film().to_image();
    const double pixel = 0.4 / 8.0;
    for (int x = 0; x < 64; ++x) {
        // Average over the pixel's width.
        double expected = 0.0;
        for (int i = 0; i < 64; ++i) {
            const double s = std::clamp(2.0 * (x + (i + 0.5) / 64.0 - 32.0) * pixel / radius, -1.0, 1.0);
            expected += (1.0 - (std::acos(s) - s * std::sqrt(1.0 - s * s)) / pi) / 64.0;
        }
        double sum = 0.0;
        for (int y = 0; y < 8; ++y)
            sum += test::channel(image, "A")[static_cast<std::size_t>(y * 64 + x)] / 8.0;
        const double error = std::sqrt(std::max(expected * (1.0 - expected), 1e-4) / (8.0 * passes));
        EXPECT_NEAR(sum, expected, 4.5 * error + 1e-4) << x;
    }
}

TEST(CameraTest, FocusPlaneIsSharp)
{
    SessionInput input = test::homogeneous({1, 1, 1}, test::centered({1, 1, 1}, {10.0, 1e-3, 20.0}, {5.0, 0.0, 0.0}),
                                           4e4, {1.0, 1.0, 1.0});
    input.render.strategy = Strategy::uniform;
    input.image = {64, 8, false};
    input.camera.position = {0.0, -20.0, 0.0};
    input.camera.lens_radius = 0.5;
    input.camera.focus_distance = 0.0; // the target's distance
    input.camera.vertical_fov_deg = 2.0;
    const auto session = test::rendered(input, 100);
    const Image image = session->film().to_image();
    for (std::size_t i = 0; i < 64 * 8; ++i)
        EXPECT_EQ(test::channel(image, "A")[i], i % 64 >= 32 ? 1.0F : 0.0F) << i;
}

} // namespace
} // namespace lumisweep
