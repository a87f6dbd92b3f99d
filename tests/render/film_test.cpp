// The film: variances that are variances, and the layers of a scene whose geometry is known.
#include <gtest/gtest.h>

#include <random>

#include "support/effort.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using test::effort;

/// The mean over pixels of the variance that the film claims, against that of the pixels' means over many renderings.
struct VarianceCheck {
    double claimed = 0.0, seen = 0.0;
    double noise = 0.0; ///< the root of the mean square of noise(), relative to what the means say
};

VarianceCheck check_variance(const RenderSettings& render, int passes, int repeats)
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
    std::vector<test::Moments> means(12 * 12), variances(12 * 12);
    double noise2 = 0.0, mean = 0.0;
    for (int r = 0; r < repeats; ++r) {
        RenderSettings settings = render;
        settings.seed = static_cast<std::uint64_t>(r);
        session.set_render(settings);
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
    VarianceCheck result;
    for (std::size_t i = 0; i < means.size(); ++i) {
        result.claimed += variances[i].mean();
        result.seen += means[i].variance();
        mean += means[i].mean();
    }
    const double relative =
        std::sqrt(result.seen / static_cast<double>(means.size())) / (mean / static_cast<double>(means.size()));
    result.noise = std::sqrt(noise2) / relative;
    return result;
}

TEST(FilmTest, VarianceIsThatOfTheMean)
{
    const VarianceCheck check = check_variance({Strategy::two_step, 0}, 16, effort(400));
    // The variance of a variance from `repeats` normal numbers, summed over the pixels: under 2 % here.
    EXPECT_NEAR(check.claimed / check.seen, 1.0, test::full_effort ? 0.06 : 0.2);
    // Green is most of the luminance, so the noise estimate is close to green's.
    EXPECT_NEAR(check.noise, 1.0, 0.15);
}

// Samples of a block are not independent, but blocks are. Below eight blocks a pixel's variance is that of single
// samples, which is too much; the image's noise comes from two blocks on.
TEST(FilmTest, VarianceOfStratifiedSamplesIsThatOfTheMean)
{
    for (const int samples : {40, 64}) { // in the midst of a block and at its end
        const VarianceCheck few = check_variance({Strategy::automatic, 0}, samples, effort(400));
        EXPECT_GT(few.claimed / few.seen, test::full_effort ? 1.06 : 0.9) << samples;
        EXPECT_NEAR(few.noise, 1.0, 0.15) << samples;
    }
    const VarianceCheck many = check_variance({Strategy::automatic, 0}, 136, effort(400));
    EXPECT_NEAR(many.claimed / many.seen, 1.0, test::full_effort ? 0.06 : 0.2);
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

/// What a film of one pixel is given.
std::vector<float> drift(int n)
{
    std::mt19937 random(3);
    std::vector<float> samples;
    for (int i = 0; i < n; ++i) // correlated within blocks, as single samples would not show
        samples.push_back(static_cast<float>(i / 16 % 3) + static_cast<float>(random() % 1000) * 1e-3F);
    return samples;
}

void add(Film& film, float x)
{
    float color[3] = {x, 2.0F * x, 0.5F}, features[8] = {};
    film.add({color, features});
}

TEST(FilmTest, VarianceOfKnownBlocks)
{
    const std::vector<float> samples = drift(200);
    Film film(1, 1), independent(1, 1);
    film.set_draws(Draws::stratified);
    const auto variance = [](const std::vector<double>& parts) {
        double mean = 0.0, sum = 0.0;
        for (const double p : parts)
            mean += p / static_cast<double>(parts.size());
        for (const double p : parts)
            sum += (p - mean) * (p - mean);
        return sum / static_cast<double>(parts.size() - 1);
    };
    for (std::size_t n = 1; n <= samples.size(); ++n) {
        add(film, samples[n - 1]);
        add(independent, samples[n - 1]);
        if (n < 2)
            continue;
        std::vector<double> parts;
        if (n < 32)
            parts.assign(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(n));
        for (std::size_t block = 0; n >= 32 && block < n / 16; ++block) {
            double mean = 0.0;
            for (std::size_t i = 0; i < 16; ++i)
                mean += samples[16 * block + i] / 16.0;
            parts.push_back(mean);
        }
        // Of the mean of all n samples, the block under way with them.
        const double expected = variance(parts) * (n < 32 ? 1.0 : 16.0) / static_cast<double>(n);
        EXPECT_NEAR(film.unbiased_variance_of_mean(0), expected, 1e-11 * expected) << n;
        EXPECT_NEAR(film.unbiased_variance_of_mean(1), 4.0 * expected, 4e-11 * expected) << n;
        EXPECT_NEAR(film.unbiased_variance_of_mean(2), 0.0, 1e-15) << n;
        const std::vector<double> single(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(n));
        const double as_independent = variance(single) / static_cast<double>(n);
        EXPECT_NEAR(film.variance_of_mean(0), n < 128 ? as_independent : expected, 1e-11 * expected) << n;
        EXPECT_NEAR(independent.variance_of_mean(0), as_independent, 1e-11 * as_independent) << n;
        EXPECT_EQ(independent.unbiased_variance_of_mean(0), independent.variance_of_mean(0)) << n;
    }
    film.clear();
    for (std::size_t n = 0; n < 40; ++n)
        add(film, samples[160 + n]);
    Film fresh(1, 1);
    for (std::size_t n = 0; n < 40; ++n)
        add(fresh, samples[160 + n]);
    fresh.set_draws(Draws::stratified);
    EXPECT_EQ(film.unbiased_variance_of_mean(0), fresh.unbiased_variance_of_mean(0));
}

// Anywhere within a block, with what a checkpoint keeps.
TEST(FilmTest, GoesOnWithinABlock)
{
    const std::vector<float> samples = drift(100);
    for (const std::size_t stop : {1U, 15U, 16U, 17U, 31U, 32U, 33U, 50U, 64U}) {
        Film straight(1, 1), first(1, 1), resumed(1, 1);
        for (Film* film : {&straight, &resumed})
            film->set_draws(Draws::stratified);
        for (std::size_t n = 0; n < stop; ++n)
            add(first, samples[n]);
        std::copy(first.arrays().color_sum.begin(), first.arrays().color_sum.end(), resumed.arrays().color_sum.begin());
        std::copy(first.arrays().color_sum_squares.begin(), first.arrays().color_sum_squares.end(),
                  resumed.arrays().color_sum_squares.begin());
        std::copy(first.arrays().block_sum_squares.begin(), first.arrays().block_sum_squares.end(),
                  resumed.arrays().block_sum_squares.begin());
        std::copy(first.arrays().block_begin.begin(), first.arrays().block_begin.end(),
                  resumed.arrays().block_begin.begin());
        resumed.set_samples(first.samples());
        for (std::size_t n = 0; n < samples.size(); ++n) {
            add(straight, samples[n]);
            if (n < stop)
                continue;
            add(resumed, samples[n]);
            for (std::size_t c = 0; c < 3; ++c) {
                EXPECT_EQ(straight.arrays().color_sum[c], resumed.arrays().color_sum[c]);
                EXPECT_EQ(straight.arrays().color_sum_squares[c], resumed.arrays().color_sum_squares[c]);
                EXPECT_EQ(straight.arrays().block_sum_squares[c], resumed.arrays().block_sum_squares[c]);
                EXPECT_EQ(straight.arrays().block_begin[c], resumed.arrays().block_begin[c]);
            }
        }
    }
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
