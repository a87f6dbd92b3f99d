// The sampler for looking in: the same numbers as the kernels', per steradian.
#include "lumisweep/sampling/direction_sampler.h"

#include <gtest/gtest.h>

#include "direction_cases.h"
#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

using namespace test;

constexpr double sphere = 4.0 * pi;

VisibilityGrid random_visibility(int directions)
{
    VisibilityGrid grid(volume_size, voxels_per_cell, directions);
    std::mt19937 random(3);
    for (int d = 0; d < grid.direction_count(); ++d)
        for (std::size_t c = 0; c < grid.cell_count(); ++c)
            grid.direction(d)[c] = static_cast<std::uint8_t>(random() % 256);
    return grid;
}

TEST(DirectionSampler, EqualsTheKernels)
{
    const VisibilityGrid grid = random_visibility(8);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(0.0F, 1.0F);
    for (const NamedEnvironment& named : environments()) {
        const auto light = std::make_shared<const Environment>(named.environment.refined(32));
        for (const Strategy strategy : strategies) {
            const DirectionSampler sampler(strategy, light, &grid, volume_size, epsilon);
            EXPECT_EQ(sampler.strategy(), strategy);
            const JointGrid joint(grid, volume_size, *light,
                                  strategy == Strategy::visibility ? JointFactor::visibility_only
                                                                   : JointFactor::visibility_times_light,
                                  epsilon);
            const DirectionSamplingView view{strategy, light->view(), joint.view()};
            for (int i = 0; i < 50; ++i) {
                const Vec3f p{13.0F * uniform(random), 10.0F * uniform(random), 21.0F * uniform(random)};
                const Random3<float> u{uniform(random), uniform(random), uniform(random)};
                const DirectionSample<float> expected = sample_direction<float>(view, p, u);
                const DirectionSampler::Sample drawn = sampler.sample(to_double(p), {u.a, u.b, u.c});
                EXPECT_EQ(drawn.pdf_omega, static_cast<double>(expected.pdf_uv) / sphere);
                EXPECT_NEAR(length(drawn.w_world), 1.0, 1e-6);
                EXPECT_NEAR(sampler.pdf_omega(to_double(p), drawn.w_world), drawn.pdf_omega, 1e-5 * drawn.pdf_omega)
                    << named.name << ", " << name_of(strategy);
            }
        }
    }
}

TEST(DirectionSampler, AutomaticIsTwoStepAndBlackIsUniform)
{
    const VisibilityGrid grid = random_visibility(8);
    const auto light = std::make_shared<const Environment>(environments()[2].environment.refined(32));
    EXPECT_EQ(DirectionSampler(Strategy::automatic, light, &grid, volume_size, epsilon).strategy(), Strategy::two_step);
    const auto black = std::make_shared<const Environment>(Environment::constant({0.0, 0.0, 0.0}));
    const DirectionSampler sampler(Strategy::two_step, black, nullptr, volume_size, epsilon);
    EXPECT_EQ(sampler.strategy(), Strategy::uniform);
    EXPECT_NEAR(sampler.pdf_omega({1.0, 2.0, 3.0}, {0.0, 0.6, 0.8}), 1.0 / sphere, 1e-9);
}

TEST(DirectionSampler, RefinesALightThatIsCoarserThanTheGrid)
{
    const VisibilityGrid grid = random_visibility(16);
    const auto light = std::make_shared<const Environment>(Environment::constant({1.0, 1.0, 1.0}));
    EXPECT_EQ(DirectionSampler(Strategy::two_step, light, &grid, volume_size, epsilon).resolution(), 16);
}

TEST(DirectionSampler, RefusesWhatItCannotSample)
{
    const auto light = std::make_shared<const Environment>(Environment::constant({1.0, 1.0, 1.0}));
    const VisibilityGrid grid = random_visibility(8);
    EXPECT_THROW(DirectionSampler(Strategy::combined, light, nullptr, volume_size, epsilon), Error);
    EXPECT_THROW(DirectionSampler(Strategy::combined, light, &grid, volume_size, 0.0), Error);
    EXPECT_THROW(DirectionSampler(Strategy::combined, light, &grid, {2, 2, 2}, epsilon), Error);
    EXPECT_NO_THROW(DirectionSampler(Strategy::environment, light, nullptr, volume_size, epsilon));
}

} // namespace
} // namespace lumisweep
