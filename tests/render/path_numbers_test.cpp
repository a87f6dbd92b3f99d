// Where collisions fall along a camera ray, and which numbers the samples of a pixel draw.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "lumisweep/render/pass.h"
#include "lumisweep/render/settings.h"
#include "lumisweep/render/tracking_stages.h"
#include "support/effort.h"

namespace lumisweep {
namespace {

int collisions(float transmittance, float rest, int k) { return stage::collisions_before(transmittance, rest, k); }

/// By definition: n with (n + u) / k < 1 - T, that is k T < rest + (k - 1 - n), of which double loses nothing.
struct Counted {
    int collisions = 0;
    bool tie = false; ///< single precision may see it on the other side
};
Counted counted(float transmittance, float rest, int k)
{
    Counted result;
    const double kt = double(k) * transmittance;
    for (int n = 0; n < k; ++n) {
        const double bound = double(rest) + (k - 1 - n);
        result.collisions += kt < bound ? 1 : 0;
        // One rounding of k T and one of the difference; none of either where k is a power of two and T is small.
        const bool exact = (k & (k - 1)) == 0 && n == k - 1;
        result.tie = result.tie || (!exact && std::fabs(kt - bound) <= 0x1p-23 * kt);
    }
    return result;
}

TEST(CollisionsBefore, AreThoseOfTheDefinition)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    int ties = 0, tests = 0;
    for (int i = 0; i < test::effort(200000); ++i) {
        // Transmittances of all magnitudes, also close to 1, and multiples of 2^-24 as they come from random numbers.
        const float spread = std::ldexp(unit(random), -static_cast<int>(random() % 40));
        const float t = i % 3 == 0 ? 1.0F - spread : i % 3 == 1 ? spread : unit(random);
        const auto steps = static_cast<float>(i % 2 == 0 ? 1U + random() % 32U : 1U + (random() >> 8));
        const float rest = steps * 0x1p-24F;
        for (const int k : {1, 2, 3, 4, 7, 16, 63, 64}) {
            const Counted expected = counted(t, rest, k);
            ++tests;
            if (expected.tie)
                ++ties;
            else
                ASSERT_EQ(collisions(t, rest, k), expected.collisions) << t << " " << rest << " " << k;
        }
    }
    EXPECT_LT(ties, tests / 1000);
}

TEST(CollisionsBefore, NoneInTheClearAndAllBehindTheOpaque)
{
    for (const int k : {1, 2, 3, 4, 7, 64})
        for (const float rest : {0x1p-24F, 0x1p-23F, 0.1F, 0.5F, 1.0F - 0x1p-24F, 1.0F}) {
            EXPECT_EQ(collisions(1.0F, rest, k), 0) << rest << " " << k;
            EXPECT_EQ(collisions(0.0F, rest, k), k) << rest << " " << k;
            EXPECT_EQ(collisions(1e-30F, rest, k), k) << rest << " " << k;
            EXPECT_EQ(collisions(1e-44F, rest, k), k) << rest << " " << k; // denormal
        }
    // The last collision of a small rest lies deep: at T = rest / k, to the bit.
    for (const int k : {1, 2, 4, 64}) {
        const float rest = 0x1p-24F, at = rest / static_cast<float>(k);
        EXPECT_EQ(collisions(at, rest, k), k - 1);
        EXPECT_EQ(collisions(std::nextafter(at, 0.0F), rest, k), k);
    }
}

TEST(CollisionsBefore, OneIsDeltaTrackings)
{
    std::mt19937 random(2);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    for (int i = 0; i < 100000; ++i) {
        const float rest = 1.0F - unit(random);
        const float t = i % 4 == 0 ? std::nextafter(rest, i % 8 == 0 ? 0.0F : 2.0F) : i % 4 == 1 ? rest : unit(random);
        ASSERT_EQ(collisions(t, rest, 1), t < rest ? 1 : 0) << t << " " << rest;
    }
}

TEST(CollisionsBefore, NeverFallAsTransmittanceFalls)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.0F, 1.0F);
    for (int ray = 0; ray < 2000; ++ray) {
        const float rest = 1.0F - unit(random);
        for (const int k : {1, 3, 4, 64}) {
            int before = 0;
            float t = 1.0F;
            for (int step = 0; step < 60; ++step) {
                const int now = collisions(t, rest, k);
                ASSERT_GE(now, before);
                ASSERT_LE(now, k);
                before = now;
                t *= step % 5 == 0 ? std::nextafter(1.0F, 0.0F) : unit(random);
            }
        }
    }
}

TEST(PassNumbersTest, SamplesOfABlockShareItsKeyAndCountOn)
{
    std::set<std::pair<std::int32_t, std::int32_t>> keys;
    for (std::int64_t sample = 0; sample < 64 * samples_a_block; ++sample) {
        const PassNumbers numbers = pass_numbers(7, sample), first = pass_numbers(7, sample - sample % samples_a_block);
        EXPECT_EQ(numbers.index, sample % samples_a_block);
        EXPECT_EQ(numbers.block.k0, first.block.k0);
        EXPECT_EQ(numbers.block.k1, first.block.k1);
        EXPECT_TRUE(keys.insert({numbers.sample.k0, numbers.sample.k1}).second) << sample;
        if (numbers.index == 0) {
            EXPECT_TRUE(keys.insert({numbers.block.k0, numbers.block.k1}).second) << sample;
        }
    }
}

TEST(RenderSettingsTest, AutomaticIsResolvedByTheStrategy)
{
    RenderSettings settings;
    EXPECT_EQ(settings.strategy, Strategy::automatic);
    EXPECT_EQ(settings.resolved().random_numbers, RandomNumbers::stratified);
    EXPECT_EQ(settings.resolved().shadow_rays, automatic_shadow_rays);
    for (const Strategy strategy :
         {Strategy::uniform, Strategy::environment, Strategy::visibility, Strategy::combined, Strategy::two_step}) {
        settings = {};
        settings.strategy = strategy;
        EXPECT_EQ(settings.resolved().strategy, strategy);
        EXPECT_EQ(settings.resolved().random_numbers, RandomNumbers::independent);
        EXPECT_EQ(settings.resolved().shadow_rays, 1);
        settings.random_numbers = RandomNumbers::stratified;
        settings.shadow_rays = 7;
        EXPECT_EQ(settings.resolved().random_numbers, RandomNumbers::stratified);
        EXPECT_EQ(settings.resolved().shadow_rays, 7);
    }
    settings = {};
    settings.random_numbers = RandomNumbers::independent;
    settings.shadow_rays = 1;
    EXPECT_EQ(settings.resolved().random_numbers, RandomNumbers::independent);
    EXPECT_EQ(settings.resolved().shadow_rays, 1);
    for (const int rays : {-1, 65, 1000}) {
        settings.shadow_rays = rays;
        EXPECT_ANY_THROW(settings.validate()) << rays;
    }
    for (const int rays : {0, 1, 64}) {
        settings.shadow_rays = rays;
        EXPECT_NO_THROW(settings.validate()) << rays;
    }
}

} // namespace
} // namespace lumisweep
