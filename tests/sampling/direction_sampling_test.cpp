// Every strategy draws what its density says, and the density is the papers'.
#include <gtest/gtest.h>

#include "sampling/direction_cases.h"
#include "sampling/lane_samples.h"
#include "support/effort.h"
#include "support/instruction_sets.h"
#include "support/statistics.h"

namespace lumisweep {
namespace {

using test::Prepared;

/// Calls f(strategy, environment, visibility, position, description) for all combinations that differ.
template <class Function>
void for_all_cases(Function&& f)
{
    for (const test::NamedEnvironment& light : test::environments())
        for (const int directions : {1, 2, 4, 8, 16, 32})
            for (const test::Visible visible : test::visibilities) {
                const VisibilityGrid visibility = test::make_visibility(visible, directions);
                for (const Strategy strategy : test::strategies) {
                    const bool by_grid = strategy != Strategy::uniform && strategy != Strategy::environment;
                    if (!by_grid && (directions > 1 || visible != test::Visible::nothing))
                        continue;
                    const Prepared prepared(strategy, light.environment, visibility);
                    for (const Vec3f& p : test::positions)
                        f(strategy, light.environment, visibility, prepared.view, p,
                          std::string(name_of(strategy)) + ", " + light.name + ", " + name_of(visible) + ", " +
                              std::to_string(directions) + "², at " + std::to_string(p.x));
                }
            }
}

TEST(DirectionSampling, DensityIsThePapers)
{
    for_all_cases([](Strategy strategy, const Environment& environment, const VisibilityGrid& visibility,
                     const DirectionSamplingView& view, const Vec3f& p, const std::string& what) {
        const std::vector<double> expected = test::oracle_pdf(strategy, environment, visibility, p);
        const int n = environment.resolution();
        double integral = 0.0, worst = 0.0;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                const double e = expected[static_cast<std::size_t>(y * n + x)];
                // Near the texel's corner and its opposite: the density is constant in between.
                const float low = direction_pdf_uv(view, p, UV<float>{(x + 0.001F) / n, (y + 0.001F) / n});
                const float high = direction_pdf_uv(view, p, UV<float>{(x + 0.999F) / n, (y + 0.999F) / n});
                worst =
                    std::max({worst, std::fabs(low - e) / std::max(e, 1e-9), std::fabs(high - e) / std::max(e, 1e-9)});
                integral += low / (double(n) * n);
            }
        EXPECT_LT(worst, 1e-5) << what;
        EXPECT_NEAR(integral, 1.0, 1e-5) << what;
    });
}

TEST(DirectionSampling, ChiSquareOfEveryStrategy)
{
    constexpr std::uint32_t seed = 20240611;
    std::mt19937 random(seed);
    const int draws = test::effort(40000);
    int tests = 0;
    for_all_cases([&](Strategy, const Environment&, const VisibilityGrid&, const DirectionSamplingView&, const Vec3f&,
                      const std::string&) { ++tests; });
    const double limit = test::sidak(0.001, tests);
    double smallest = 1.0;
    for_all_cases([&](Strategy, const Environment& environment, const VisibilityGrid&,
                      const DirectionSamplingView& view, const Vec3f& p, const std::string& what) {
        const int n = environment.resolution();
        std::vector<std::uint64_t> observed(static_cast<std::size_t>(n * n));
        std::vector<double> expected(observed.size());
        const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24F; };
        for (int i = 0; i < draws; ++i) {
            const float a = uniform(), b = uniform(), c = uniform();
            const DirectionSample<float> s = sample_direction(view, p, Random3<float>{a, b, c});
            ASSERT_TRUE(s.uv_oct.u >= 0.0F && s.uv_oct.u <= 1.0F && s.uv_oct.v >= 0.0F && s.uv_oct.v <= 1.0F) << what;
            ASSERT_GT(s.pdf_uv, 0.0F) << what;
            ASSERT_EQ(detail::node_of(s.uv_oct, view.environment.levels), s.texel) << what;
            ++observed[static_cast<std::size_t>(s.texel)];
        }
        for (std::size_t m = 0; m < observed.size(); ++m) {
            const auto xy = morton_decode(static_cast<std::int32_t>(m));
            expected[m] =
                direction_pdf_uv(view, p, UV<float>{(xy.x + 0.5F) / n, (xy.y + 0.5F) / n}) * draws / (double(n) * n);
        }
        const test::ChiSquare result = test::chi_square(observed, expected);
        EXPECT_FALSE(result.impossible) << what;
        EXPECT_GT(result.p, limit) << what << ": χ² " << result.statistic << " with " << result.degrees_of_freedom
                                   << " degrees of freedom, seed " << seed;
        smallest = std::min(smallest, result.p);
    });
    RecordProperty("smallest_p", std::to_string(smallest));
    EXPECT_GT(tests, 1000);
}

// Within its texel, a sample is uniform: what the strategies that end above the texels' level rely on.
TEST(DirectionSampling, UniformWithinTheTexel)
{
    std::mt19937 random(5);
    const auto lights = test::environments();
    const VisibilityGrid visibility = test::make_visibility(test::Visible::random, 4);
    for (const Strategy strategy : test::strategies) {
        const Prepared prepared(strategy, lights[0].environment, visibility);
        std::vector<std::uint64_t> observed(64);
        const int draws = test::effort(200000);
        for (int i = 0; i < draws; ++i) {
            const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24F; };
            const float a = uniform(), b = uniform(), c = uniform();
            const DirectionSample<float> s =
                sample_direction(prepared.view, test::positions[0], Random3<float>{a, b, c});
            const float x = s.uv_oct.u * 32.0F, y = s.uv_oct.v * 32.0F;
            ++observed[static_cast<std::size_t>(std::min(static_cast<int>((x - std::floor(x)) * 8.0F), 7) * 8 +
                                                std::min(static_cast<int>((y - std::floor(y)) * 8.0F), 7))];
        }
        EXPECT_GT(test::chi_square(observed, std::vector<double>(64, draws / 64.0)).p, test::sidak(0.001, 5))
            << name_of(strategy);
    }
}

/// Draws the same inputs by a lane type and by the scalar code.
void compare_lanes(void (*lanes)(const DirectionSamplingView&, const test::LaneSamples&))
{
    constexpr int count = 4096;
    std::mt19937 random(9);
    const auto lights = test::environments();
    std::vector<float> in(6 * count), out(8 * count);
    std::vector<std::int32_t> texels(2 * count);
    for (int i = 0; i < 6 * count; ++i)
        in[static_cast<std::size_t>(i)] = static_cast<float>(random() >> 8) * 0x1p-24F *
                                          (i < count       ? 13.0F
                                           : i < 2 * count ? 10.0F
                                           : i < 3 * count ? 21.0F
                                                           : 1.0F);
    const auto samples = [&](int which) {
        const float* p = in.data();
        float* q = out.data() + which * 4 * count;
        return test::LaneSamples{
            count,         p, p + count, p + 2 * count, p + 3 * count, p + 4 * count,
            p + 5 * count, q, q + count, q + 2 * count, q + 3 * count, texels.data() + which * count};
    };
    for (const test::NamedEnvironment& light : lights)
        for (const int directions : {1, 8, 16}) {
            const VisibilityGrid visibility = test::make_visibility(test::Visible::random, directions);
            for (const Strategy strategy : test::strategies) {
                const Prepared prepared(strategy, light.environment, visibility);
                const test::LaneSamples scalar = samples(0), wide = samples(1);
                test::sample_lanes<float>(prepared.view, scalar);
                lanes(prepared.view, wide);
                int same = 0;
                for (int i = 0; i < count; ++i) {
                    // A density zero can only come back at the very edge of a texel.
                    ASSERT_GT(wide.pdf_uv[i], 0.0F);
                    if (scalar.texel[i] != wide.texel[i])
                        continue;
                    ++same;
                    EXPECT_NEAR(wide.pdf_uv[i] / scalar.pdf_uv[i], 1.0, 1e-5);
                    EXPECT_NEAR(wide.u[i], scalar.u[i], 1e-4);
                    EXPECT_NEAR(wide.v[i], scalar.v[i], 1e-4);
                }
                EXPECT_GE(same, count - 8) << name_of(strategy) << ", " << light.name;
                for (const test::LaneSamples& s : {scalar, wide}) {
                    int agree = 0;
                    for (int i = 0; i < count; ++i)
                        agree += std::fabs(s.pdf_again[i] / s.pdf_uv[i] - 1.0F) < 1e-5F &&
                                         detail::node_of(UV<float>{s.u[i], s.v[i]}, 5) == s.texel[i]
                                     ? 1
                                     : 0;
                    EXPECT_EQ(agree, count) << "sample → pdf, " << name_of(strategy) << ", " << light.name;
                }
            }
        }
}

TEST(DirectionSampling, Avx2AgreesWithScalar)
{
    if (!test::runs_avx2())
        GTEST_SKIP() << "this machine has no AVX2";
    compare_lanes(test::sample_lanes_avx2);
}

TEST(DirectionSampling, Avx512AgreesWithScalar)
{
    if (!test::runs_avx512())
        GTEST_SKIP() << "this machine has no AVX-512";
    compare_lanes(test::sample_lanes_avx512);
}

} // namespace
} // namespace lumisweep
