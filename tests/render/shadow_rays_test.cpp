// Any number of collisions and shadow rays a camera ray, with independent and stratified numbers: the same means of
// light, coverage and features, against closed forms and each other.
#include <gtest/gtest.h>

#include "support/box_oracle.h"
#include "support/effort.h"
#include "support/image_blocks.h"
#include "support/scenes.h"

namespace lumisweep {
namespace {

using namespace test;

struct Draw {
    int shadow_rays;
    RandomNumbers numbers;
};

std::string name_of(const Draw& draw)
{
    return std::to_string(draw.shadow_rays) +
           (draw.numbers == RandomNumbers::stratified ? " stratified" : " independent");
}

std::vector<Draw> all_draws()
{
    std::vector<Draw> draws;
    for (const int shadow_rays : {1, 3, 4, 64})
        for (const RandomNumbers numbers : {RandomNumbers::independent, RandomNumbers::stratified})
            draws.push_back({shadow_rays, numbers});
    return draws;
}

/// Pixels draw independently of each other and all see the same: their spread says how good the mean is.
template <class Value>
test::Estimate over_pixels(const Film& film, Value&& value)
{
    Moments moments;
    for (std::size_t p = 0; p < film.color_sum().size() / 3; ++p)
        moments.add(value(p) / static_cast<double>(film.samples()));
    return {moments.mean(), moments.standard_error()};
}

test::Estimate feature(const Film& film, std::size_t which)
{
    return over_pixels(film, [&](std::size_t p) { return film.features()[feature_count * p + which]; });
}

// A box, 6 deep, straight ahead, with its environment behind it.
TEST(ShadowRays, ClosedFormsOfHomogeneousBoxes)
{
    const test::GaussLegendre rule(48), fine(64);
    for (const double depth : {1e-3, 1.0, 50.0}) {
        const double sigma = depth / 6.0;
        // At 50 the box is a half space seen at right angles, (1/2) ∫₀^1 μ/(1+μ) dμ; quadrature would be 0.1 % off,
        // because light falls steeply behind the surface.
        const double scattered = depth > 10.0 ? 0.5 * (1.0 - std::log(2.0)) : fine(0.0, 6.0, [&](double t) {
            return std::exp(-sigma * t) * sigma *
                   test::mean_light_in_box({3.0, 3.0, 3.0}, sigma, {0.0, t - 3.0, 0.0}, rule);
        });
        // The lens is 17 from the box: its distance to the first collision, 0 where there is none.
        const double alpha = -std::expm1(-depth);
        const double distance = 17.0 * alpha + fine(0.0, std::min(6.0, 40.0 / sigma),
                                                    [&](double t) { return t * sigma * std::exp(-sigma * t); });
        for (const Draw& draw : all_draws()) {
            SessionInput input =
                test::homogeneous({6, 6, 6}, test::centered({6, 6, 6}, {1.0, 1.0, 1.0}), sigma, {1.0, 0.5, 0.25});
            input.camera = test::needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
            input.image = {64, 64, true};
            input.render.shadow_rays = draw.shadow_rays;
            input.render.random_numbers = draw.numbers;
            const int passes = effort(draw.shadow_rays == 64 ? 16 : 64);
            const auto session = test::rendered(input, passes);
            const Film& film = session->film();
            const std::string what = name_of(draw) + ", optical depth " + std::to_string(depth);
            for (std::size_t c = 0; c < 3; ++c) {
                const double albedo = c == 0 ? 1.0 : c == 1 ? 0.5 : 0.25;
                const auto light = over_pixels(film, [&](std::size_t p) { return film.color_sum()[3 * p + c]; });
                test::expect_close(light, albedo * scattered + std::exp(-depth), test::full_effort ? 2e-3 : 8e-3, what);
                test::expect_close(feature(film, c), albedo * alpha, test::full_effort ? 2e-3 : 8e-3,
                                   what + ", albedo");
            }
            test::expect_close(feature(film, 6), distance, test::full_effort ? 0.05 : 0.15, what + ", depth");
            test::expect_close(feature(film, 7), alpha, test::full_effort ? 2e-3 : 8e-3, what + ", coverage");
            // Each stands for its part of the coverage, and the light is nowhere black.
            const PassCounts& counts = session->stats().counts;
            const auto paths = 64.0 * 64.0 * passes;
            EXPECT_EQ(counts.paths, static_cast<std::uint64_t>(paths));
            EXPECT_NEAR(static_cast<double>(counts.shadow_rays), feature(film, 7).mean * paths * draw.shadow_rays,
                        1e-4 * static_cast<double>(counts.shadow_rays))
                << what;
            EXPECT_GE(counts.camera_steps * static_cast<std::uint64_t>(draw.shadow_rays), counts.shadow_rays) << what;
        }
    }
}

/// Variance of a pixel's light, from the spread over pixels that all see the same.
double variance(double depth, const Draw& draw)
{
    SessionInput input =
        test::homogeneous({6, 6, 6}, test::centered({6, 6, 6}, {1.0, 1.0, 1.0}), depth / 6.0, {1.0, 1.0, 1.0});
    input.camera = test::needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
    input.image = {64, 64, true};
    input.render.shadow_rays = draw.shadow_rays;
    input.render.random_numbers = draw.numbers;
    const auto session = test::rendered(input, 16);
    const Film& film = session->film();
    const test::Estimate light = over_pixels(film, [&](std::size_t p) { return film.color_sum()[3 * p]; });
    return light.error * light.error;
}

// Means do not show whether numbers are stratified over a block's samples and their shadow rays. The bounds are
// somewhat less than twice what was measured.
TEST(ShadowRays, StratificationLeavesLessVariance)
{
    const auto ratio = [](double depth, int shadow_rays) {
        return variance(depth, {shadow_rays, RandomNumbers::stratified}) /
               variance(depth, {shadow_rays, RandomNumbers::independent});
    };
    EXPECT_LT(ratio(1.0, 1), 0.28); // depth along the ray decides
    EXPECT_LT(ratio(1.0, 4), 0.05);
    EXPECT_LT(ratio(50.0, 4), 0.5); // the direction decides
    EXPECT_LT(ratio(50.0, 64), 0.1);
}

// No ray comes through: every one brings all of its collisions.
TEST(ShadowRays, OpaqueBoxesHaveThemAll)
{
    for (const Draw& draw : all_draws()) {
        SessionInput input =
            test::homogeneous({6, 6, 6}, test::centered({6, 6, 6}, {1.0, 1.0, 1.0}), 1000.0, {1.0, 1.0, 1.0});
        input.camera = test::needle({0.0, -20.0, 0.0}, {0.0, 0.0, 0.0});
        input.image = {32, 32, true};
        input.render.shadow_rays = draw.shadow_rays;
        input.render.random_numbers = draw.numbers;
        for (const std::string& isa : available_isas()) {
            const auto session = test::rendered(input, 16, isa);
            EXPECT_EQ(session->stats().counts.shadow_rays,
                      session->stats().counts.paths * static_cast<std::uint64_t>(draw.shadow_rays))
                << name_of(draw) << ", " << isa;
            const test::Estimate alpha = feature(session->film(), 7);
            EXPECT_NEAR(alpha.mean, 1.0, 1e-6) << name_of(draw) << ", " << isa;
        }
    }
}

constexpr std::size_t values = 3 + feature_count;

/// Colours and features of every block of the image; each batch starts from a fresh film.
std::vector<Moments> means_of_blocks(SessionInput input, int passes, const std::string& isa = "auto")
{
    std::vector<Moments> result(image_blocks * values);
    Session session(input, make_cpu_backend(isa));
    const std::uint64_t seed = input.render.seed * 1000;
    for (int b = 0; b < batches; ++b) {
        input.render.seed = seed + static_cast<std::uint64_t>(b);
        session.set_render(input.render);
        for (int p = 0; p < passes; ++p)
            session.render_pass();
        std::vector<double> sums(result.size());
        for (std::size_t p = 0; p < image_side * image_side; ++p) {
            const int x = static_cast<int>(p % image_side), y = static_cast<int>(p / image_side);
            double* sum = sums.data() + static_cast<std::size_t>(block_of_pixel(x, y)) * values;
            for (std::size_t c = 0; c < 3; ++c)
                sum[c] += session.film().color_sum()[3 * p + c];
            for (std::size_t f = 0; f < feature_count; ++f)
                sum[3 + f] += session.film().features()[feature_count * p + f];
        }
        for (std::size_t i = 0; i < sums.size(); ++i)
            result[i].add(sums[i] / (pixels_of_block * passes));
    }
    return result;
}

TEST(ShadowRays, SameMeansInHeterogeneousVolumes)
{
    const Vec3i size{27, 30, 25};
    const Affine3d place = test::centered(size, {1.0, 1.1, 0.9});
    std::uint64_t seed = 5000;
    // Batches are few: the tails of Student's t with 46 degrees of freedom are heavier, hence the small significance.
    const double limit = test::sidak(0.0005, 2.0 * 7.0 * double(image_blocks) * double(values));
    for (const bool ct : {true, false}) {
        SessionInput input;
        input.volume = ct ? test::ct_like(size, place) : test::smoke_like(size, place);
        input.transfer_function = ct ? test::ct_transfer_function() : test::smoke_transfer_function();
        input.environment = test::sky_with_sun(64, 12.0);
        input.image = {image_side, image_side, true};
        input.camera.position = {25.0, -70.0, 20.0};
        input.camera.vertical_fov_deg = 22.0;
        input.camera.lens_radius = 0.5;
        input.camera.focus_distance = 70.0;
        input.render = {Strategy::two_step, ++seed};
        const std::vector<Moments> reference = means_of_blocks(input, effort(80));
        double worst = 0.0;
        for (const Draw& draw : all_draws()) {
            input.render.strategy = Strategy::automatic;
            input.render.shadow_rays = draw.shadow_rays;
            input.render.random_numbers = draw.numbers;
            input.render.seed = ++seed;
            const std::vector<Moments> here = means_of_blocks(input, effort(draw.shadow_rays == 64 ? 4 : 16));
            for (std::size_t i = 0; i < here.size(); ++i) {
                EXPECT_GT(test::p_of_means(here[i], reference[i]), limit)
                    << (ct ? "CT, " : "smoke, ") << name_of(draw) << ", block " << i / values << ", value "
                    << i % values << ": " << here[i].mean() << " and " << reference[i].mean();
                if (i % values < 3 || i % values == 10)
                    worst = std::max(worst, std::hypot(here[i].standard_error(), reference[i].standard_error()) /
                                                reference[i].mean());
            }
        }
        EXPECT_LT(worst, test::full_effort ? 0.02 : 0.06); // what says that a bias would be found
    }
}

// Of a thin volume that is empty but for some specks, no estimate of T is above 1: what a sample brings under light of
// 1 everywhere, whatever shares of a block are empty.
TEST(ShadowRays, TransmittanceIsAtMostOneInSparseMedia)
{
    const Vec3i size{96, 96, 96};
    SessionInput input;
    input.volume = test::make_grid<std::uint8_t>(
        VoxelType::u8, size, test::centered(size, {1.0, 1.0, 1.0}),
        [](int i, int j, int k) { return (i * 7 + j * 13 + k * 29) % 31 == 0 ? 255 : 0; });
    input.transfer_function = TransferFunction({{0.0, 0.0, {1.0, 1.0, 1.0}}, {255.0, 0.15, {1.0, 1.0, 1.0}}});
    input.environment = test::constant_light();
    input.camera.position = {0.0, -300.0, 40.0};
    input.image = {64, 64, false};
    input.render.strategy = Strategy::uniform;
    Session session(input, make_cpu_backend());
    double largest = 0.0;
    for (int seed = 0; seed < 4; ++seed) {
        input.render.seed = static_cast<std::uint64_t>(seed);
        session.set_render(input.render);
        session.render_pass();
        for (const double sample : session.film().color_sum())
            largest = std::max(largest, sample);
    }
    EXPECT_GT(largest, 0.5);
    EXPECT_LE(largest, 1.0 + 1e-5);
}

} // namespace
} // namespace lumisweep
