// The yardstick estimates what the renderer estimates, and is no better than it says.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/light/sky.h"
#include "references.h"
#include "scalar_tracker.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

constexpr int side = 24, blocks_per_side = 2, block_count = blocks_per_side * blocks_per_side;

/// Mean luminance of each quarter of the image.
std::vector<double> block_means(std::span<const double> sums, double samples)
{
    std::vector<double> means(block_count);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double* c = sums.data() + 3 * (y * side + x);
            const int block = y / (side / blocks_per_side) * blocks_per_side + x / (side / blocks_per_side);
            means[static_cast<std::size_t>(block)] +=
                luminance(c[0], c[1], c[2]) * block_count / (samples * side * side);
        }
    return means;
}

SessionInput input_of(Specimen specimen)
{
    SessionInput input;
    SkySettings sky;
    sky.sun_angular_diameter_deg = 10.0;
    input.environment = std::make_shared<const Environment>(environment_from_sky(sky, 64));
    input.transfer_function = specimen.transfer_function;
    input.volume = std::make_shared<const ScalarGrid>(std::move(specimen.volume));
    input.camera.position = {120.0, -420.0, 160.0};
    input.camera.vertical_fov_deg = 30.0;
    input.image = {side, side, false};
    input.render.strategy = Strategy::environment;
    return input;
}

class ScalarTrackerTest : public testing::TestWithParam<int> {};

TEST_P(ScalarTrackerTest, HasTheRenderersMean)
{
    const SessionInput input = input_of(GetParam() == 0   ? ct_like({40, 36, 33})
                                        : GetParam() == 1 ? smoke_like({24, 30, 26})
                                                          : fractal_shells({40, 40, 40}, 30.0));
    constexpr int batches = 40, passes = 25;
    const ScalarTracker tracker(input);
    Session session(input, make_cpu_backend());
    std::vector<std::vector<double>> of_tracker(block_count), of_session(block_count);
    std::vector<float> color(3 * side * side);
    for (int b = 0; b < batches; ++b) {
        std::vector<double> sums(color.size());
        for (int p = 0; p < passes; ++p) {
            tracker.render_pass(static_cast<std::uint64_t>(1000 * GetParam() + passes * b + p), color);
            for (std::size_t i = 0; i < color.size(); ++i)
                sums[i] += static_cast<double>(color[i]);
        }
        RenderSettings render = input.render;
        render.seed = static_cast<std::uint64_t>(5000 + b);
        session.set_render(render);
        for (int p = 0; p < passes; ++p)
            session.render_pass();
        const std::vector<double> mine = block_means(sums, passes),
                                  theirs = block_means(session.film().color_sum().span(), passes);
        for (std::size_t i = 0; i < block_count; ++i) {
            of_tracker[i].push_back(mine[i]);
            of_session[i].push_back(theirs[i]);
        }
    }
    for (std::size_t i = 0; i < block_count; ++i) {
        const MeanAndError a = mean_and_error(of_tracker[i]), b = mean_and_error(of_session[i]);
        const double error = std::hypot(a.error, b.error);
        EXPECT_LT(error, 0.02 * b.mean) << "block " << i << " says too little";
        EXPECT_LT(std::fabs(a.mean - b.mean), 4.0 * error) << "block " << i << ": " << a.mean << " and " << b.mean;
        // The same estimator but for the schedule: the same spread, to what 40 batches tell.
        EXPECT_NEAR(std::log(a.error / b.error), 0.0, 0.5) << "block " << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Volumes, ScalarTrackerTest, testing::Range(0, 3));

TEST(ScalarTrackerRandom, RepeatsPerSeed)
{
    const ScalarTracker tracker(input_of(smoke_like({20, 20, 20})));
    std::vector<float> a(3 * side * side), b(a.size()), other(a.size());
    tracker.render_pass(7, a);
    tracker.render_pass(7, b);
    tracker.render_pass(8, other);
    EXPECT_EQ(a, b);
    EXPECT_NE(a, other);
}

} // namespace
} // namespace lumisweep::bench
