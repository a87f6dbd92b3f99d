// The film: variances that are variances, and the layers of a scene whose geometry is known.
#include <gtest/gtest.h>

#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;

TEST(FilmTest, VarianceIsThatOfTheMean)
{
    const Vec3i size{20, 20, 20};
    SessionInput input;
    input.volume = test::smoke_like(size, test::centered(size, {1.0, 1.0, 1.0}));
    input.transfer_function = test::smoke_transfer_function();
    input.environment = test::sky_with_sun(32, 20.0);
    input.image = {12, 12, true};
    input.camera.position = {0.0, -70.0, 10.0};
    input.camera.vertical_fov_deg = 18.0;
    Session session(input, make_cpu_backend());
    const int repeats = effort(400), passes = 16;
    std::vector<test::Moments> means(12 * 12), variances(12 * 12);
    double noise2 = 0.0, mean = 0.0;
    for (int r = 0; r < repeats; ++r) {
        session.set_render({Strategy::two_step, static_cast<std::uint64_t>(r)});
        EXPECT_EQ(session.film().noise(), std::numeric_limits<double>::infinity());
        for (int p = 0; p < passes; ++p)
            session.render_pass();
        const Image image = session.film().to_image();
        for (std::size_t i = 0; i < means.size(); ++i) {
            means[i].add(test::channel(image, "G")[i]);
            variances[i].add(test::channel(image, "Variance.G")[i]);
        }
        const double n = session.film().noise();
        noise2 += n * n / repeats;
    }
    double claimed = 0.0, seen = 0.0;
    for (std::size_t i = 0; i < means.size(); ++i) {
        claimed += variances[i].mean();
        seen += means[i].variance();
        mean += means[i].mean();
    }
    // The variance of a variance from `repeats` normal numbers, summed over the pixels: under 2 % here.
    EXPECT_NEAR(claimed / seen, 1.0, test::full_effort ? 0.06 : 0.2);
    // Green is most of the luminance, so the noise estimate is close to green's.
    const double relative =
        std::sqrt(seen / static_cast<double>(means.size())) / (mean / static_cast<double>(means.size()));
    EXPECT_NEAR(std::sqrt(noise2) / relative, 1.0, 0.15);
}

TEST(FilmTest, VarianceOfKnownSamples)
{
    Film film(2, 1);
    for (const float x : {1.0F, 2.0F, 6.0F}) {
        float color[6] = {x, 2.0F * x, 0.0F, 0.0F, 0.0F, 0.0F};
        float features[16] = {0.5F, 0.25F, 1.0F, 0.0F, 0.0F, 1.0F, x, 1.0F};
        film.add({color, features});
        EXPECT_EQ(color[0], 0.0F);
        EXPECT_EQ(features[7], 0.0F);
    }
    const Image image = film.to_image();
    EXPECT_FLOAT_EQ(test::channel(image, "R")[0], 3.0F);
    EXPECT_FLOAT_EQ(test::channel(image, "Variance.R")[0], 7.0F / 3.0F); // sample variance 7, mean of 3
    EXPECT_FLOAT_EQ(test::channel(image, "Variance.G")[0], 28.0F / 3.0F);
    EXPECT_FLOAT_EQ(test::channel(image, "depth.Z")[0], 3.0F);
    EXPECT_FLOAT_EQ(test::channel(image, "A")[0], 1.0F);
    EXPECT_EQ(test::channel(image, "A")[1], 0.0F);
    EXPECT_EQ(test::channel(image, "depth.Z")[1], 0.0F);
    EXPECT_EQ(Film(2, 2).noise(), std::numeric_limits<double>::infinity());
}

// An opaque sphere in a rotated, anisotropic grid: normals point outwards, depth is the distance to its surface.
TEST(FilmTest, LayersOfASphere)
{
    const Vec3i size{45, 57, 49};
    const Vec3d a = normalized({1.0, 2.0, -0.5}), b = normalized(cross(a, {0.3, 0.1, 1.0})), c = cross(a, b);
    Affine3d world_from_voxel;
    world_from_voxel.column = {{a * 0.05, b * 0.04, c * 0.048}};
    world_from_voxel.offset = world_from_voxel.vector({0.5 * size.x, 0.5 * size.y, 0.5 * size.z}) * -1.0;
    // Falling and rising values: the normal points against extinction, not against the value.
    for (const double sign : {1.0, -1.0}) {
        SessionInput input;
        input.volume = test::make_grid<float>(VoxelType::f32, size, world_from_voxel, [&](int i, int j, int k) {
            return sign * (1.0 - length(world_from_voxel.point({i + 0.5, j + 0.5, k + 0.5})));
        });
        const Vec3d albedo{0.7, 0.5, 0.3};
        input.transfer_function = sign > 0.0 ? TransferFunction({{0.0, 0.0, albedo}, {0.05, 600.0, albedo}})
                                             : TransferFunction({{-0.05, 600.0, albedo}, {0.0, 0.0, albedo}});
        input.environment = test::constant_light();
        input.image = {64, 64, false};
        input.camera.position = {0.5, -6.0, 1.0};
        input.camera.vertical_fov_deg = 22.0;
        const Vec3d forward = normalized(input.camera.position * -1.0),
                    right = normalized(cross(forward, input.camera.up));
        const Vec3d up = cross(right, forward);
        const auto session = test::rendered(input, effort(24));
        const Image image = session->film().to_image();
        int inside = 0;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
                const auto p = static_cast<std::size_t>(y * 64 + x);
                const double half = std::tan(11.0 * pi / 180.0);
                const Vec3d w = normalized(forward + right * ((x + 0.5 - 32.0) / 32.0 * half) +
                                           up * ((32.0 - y - 0.5) / 32.0 * half));
                const double along = -dot(input.camera.position, w);
                const double miss2 = dot(input.camera.position, input.camera.position) - along * along;
                if (miss2 > 1.15) {
                    EXPECT_EQ(test::channel(image, "A")[p], 0.0F);
                } else if (miss2 < 0.7) {
                    ++inside;
                    const double depth = along - std::sqrt(1.0 - miss2);
                    const Vec3d normal = input.camera.position + w * depth;
                    EXPECT_EQ(test::channel(image, "A")[p], 1.0F);
                    // σ rises by 12000 a unit behind the surface: the first collision is √(π / (2 · 12000 cos)) along
                    // the ray.
                    const double behind = std::sqrt(pi / (2.0 * 600.0 / 0.05 * -dot(normal, w)));
                    EXPECT_NEAR(test::channel(image, "depth.Z")[p], depth + behind, 0.012);
                    EXPECT_NEAR(test::channel(image, "normal.X")[p], normal.x, 0.05);
                    EXPECT_NEAR(test::channel(image, "normal.Y")[p], normal.y, 0.05);
                    EXPECT_NEAR(test::channel(image, "normal.Z")[p], normal.z, 0.05);
                    EXPECT_NEAR(test::channel(image, "albedo.R")[p], 0.7, 1e-6);
                    EXPECT_NEAR(test::channel(image, "albedo.B")[p], 0.3, 1e-6);
                }
            }
        }
        EXPECT_GT(inside, 500);
    }
}

} // namespace
} // namespace lumisweep
