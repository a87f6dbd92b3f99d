// From optical depths at rays to V at cells.
#include "lumisweep/visibility/sweep_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "kernel_tables.h"

namespace lumisweep {
namespace {

using namespace test;

/// Cells on two rows of rays.
struct LookupCase {
    std::vector<std::int32_t> low, high, index, next;
    std::vector<float> fraction;
    LookupRow row{};

    LookupCase(std::mt19937& random, int count, int step)
    {
        const int half = 4 * count + 8;
        low = random_values<std::int32_t>(random, 2 * half, 0, 400000000);
        high = random_values<std::int32_t>(random, 2 * half, 0, 400000000);
        fraction = random_floats(random, count, 0.0F, 1.0F);
        const int first = uniform(random, 0, 5);
        for (int c = 0; c < count; ++c) {
            const int ray = step == neighbouring_rays ? first + c
                            : step != 0               ? first + 2 * step * c
                                                      : uniform(random, 0, 2 * half - 2);
            const auto stored = [&](int k) { return (k >> 1) + (k & 1) * half; };
            index.push_back(stored(ray));
            next.push_back(stored(ray + 1));
            if (step != 0)
                fraction[static_cast<std::size_t>(c)] = fraction[0];
        }
        row = {low.data(), high.data(), index.data(), next.data(), fraction.data(), 0.3F, step, count};
        row.fraction_rows = random_floats(random, 1, 0.0F, 1.0F)[0];
    }
};

TEST(SweepKernels, LookupsAreBilinear)
{
    std::mt19937 random(3);
    for (const int step : {neighbouring_rays, 0, 1, 2, 3, 4})
        for (const int count : awkward_counts()) {
            const LookupCase lookup(random, count, step);
            std::vector<float> expected(static_cast<std::size_t>(count));
            for (std::size_t c = 0; c < expected.size(); ++c) {
                const auto ray = [&](const std::vector<std::int32_t>& rays, const std::vector<std::int32_t>& at) {
                    return static_cast<float>(rays[static_cast<std::size_t>(at[c])]);
                };
                const float f = lookup.fraction[c], g = lookup.row.fraction_rows;
                const float below = ray(lookup.low, lookup.index) * (1.0F - f) + ray(lookup.low, lookup.next) * f;
                const float above = ray(lookup.high, lookup.index) * (1.0F - f) + ray(lookup.high, lookup.next) * f;
                expected[c] = below * (1.0F - g) + above * g;
            }
            for (const SweepKernels* kernels : runnable_kernels()) {
                std::vector<float> tau(static_cast<std::size_t>(count), -1.0F);
                kernels->look_up(tau.data(), lookup.row);
                ASSERT_EQ(tau, expected) << kernels->name << ", step " << step << ", " << count << " cells";
            }
        }
}

/// What the box's sides do, in random order.
struct SideCase {
    static constexpr int slices = 50;
    std::vector<float> begin_low, begin_high, end_low, end_high, enter, leave, fraction;
    SideRow row{};

    SideCase(std::mt19937& random, int count)
    {
        const auto whole_slices = [&](int low, int high) {
            std::vector<float> list = random_values<float>(random, count, low, high);
            for (float& weight : list)
                weight *= 127.0F;
            return list;
        };
        begin_low = whole_slices(0, 20);
        begin_high = whole_slices(0, 20);
        end_low = whole_slices(5, slices);
        end_high = whole_slices(5, slices);
        enter = random_floats(random, count, -1.0F, 20.0F);
        leave = random_floats(random, count, 10.0F, 60.0F);
        fraction = random_floats(random, count, 0.0F, 1.0F);
        row.begin_low = begin_low.data();
        row.begin_high = begin_high.data();
        row.end_low = end_low.data();
        row.end_high = end_high.data();
        row.enter = enter.data();
        row.leave = leave.data();
        row.fraction = fraction.data();
        for (int k = 0; k < 2; ++k) {
            row.row.begin[k] = static_cast<float>(127 * uniform(random, 0, 20));
            row.row.end[k] = static_cast<float>(127 * uniform(random, 10, slices));
        }
        row.row.enter = random_floats(random, 1, 0.0F, 10.0F)[0];
        row.row.leave = random_floats(random, 1, 10.0F, 50.0F)[0];
        row.row.fraction = random_floats(random, 1, 0.0F, 1.0F)[0];
        row.depth = random_floats(random, 1, 0.0F, 50.0F)[0];
        row.weight = std::floor(row.depth * 127.0F);
        row.scale = random_floats(random, 1, 0.01F, 2.0F)[0];
        row.count = count;
    }
};

TEST(SweepKernels, SideFactorsAreTheSameForEveryInstructionSet)
{
    std::mt19937 random(4);
    for (int repeat = 0; repeat < 20; ++repeat)
        for (const int count : awkward_counts()) {
            const SideCase sides(random, count);
            const auto factors = [&](const SweepKernels& kernels) {
                std::vector<float> both(static_cast<std::size_t>(2 * count), -1.0F);
                kernels.side_factors(both.data(), both.data() + count, sides.row);
                return both;
            };
            const std::vector<float> expected = factors(sweep_kernels_baseline);
            for (const SweepKernels* kernels : runnable_kernels())
                ASSERT_EQ(factors(*kernels), expected) << kernels->name << ", " << count << " cells";
        }
}

TEST(SweepKernels, SideFactorsAreLengthPerWeight)
{
    std::mt19937 random(5);
    for (int repeat = 0; repeat < 40; ++repeat) {
        const int count = 30;
        const SideCase sides(random, count);
        std::vector<float> forwards(count), backwards(count);
        sweep_kernels_baseline.side_factors(forwards.data(), backwards.data(), sides.row);
        for (std::size_t c = 0; c < forwards.size(); ++c) {
            // The weight that each of the four rays has counted, interpolated as their sums are.
            double until = 0.0, from = 0.0;
            for (int k = 0; k < 4; ++k) {
                const double f = k % 2 == 0 ? 1.0 - sides.fraction[c] : sides.fraction[c];
                const double g = k < 2 ? 1.0 - sides.row.row.fraction : sides.row.row.fraction;
                const double begin =
                    std::max(k % 2 == 0 ? sides.begin_low[c] : sides.begin_high[c], sides.row.row.begin[k / 2]);
                const double end =
                    std::min(k % 2 == 0 ? sides.end_low[c] : sides.end_high[c], sides.row.row.end[k / 2]);
                const double at = sides.row.weight;
                until += f * g * std::max(0.0, std::min(end, at) - begin);
                from += f * g * std::max(0.0, end - std::max(begin, at));
            }
            const double scale = sides.row.scale;
            const double enter = std::max(sides.enter[c], sides.row.row.enter);
            const double leave = std::min(sides.leave[c], sides.row.row.leave);
            const double before = std::max(0.0, sides.row.depth - enter);
            const double behind = std::max(0.0, leave - sides.row.depth);
            EXPECT_NEAR(forwards[c], until > 0.0 ? scale * before / until : 0.0, 1e-5 * forwards[c] + 1e-9);
            EXPECT_NEAR(backwards[c], from > 0.0 ? scale * behind / from : 0.0, 1e-5 * backwards[c] + 1e-9);
        }
    }
}

TEST(SweepKernels, VisibilityIsTheExponential)
{
    // Optical depths from 0 to beyond where single precision ends, by steps that meet every fraction of a power of two;
    // rounding leaves less than nothing now and then.
    std::vector<float> tau{-3.0F, -1e-6F, 0.0F, 1e-9F, 500.0F, 1e30F};
    for (int i = 0; i < 20000; ++i)
        tau.push_back(static_cast<float>(i) * 0.00517F);
    const int count = static_cast<int>(tau.size());
    const std::vector<float> factor(tau.size(), std::numbers::log2e_v<float>);
    std::vector<float> total(tau.size());
    std::transform(tau.begin(), tau.end(), total.begin(), [](float x) { return 2.0F * x; });
    for (const SweepKernels* kernels : runnable_kernels()) {
        std::vector<std::uint16_t> visibility(tau.size()), rest(tau.size());
        kernels->to_visibility(visibility.data(), tau.data(), factor.data(), count);
        kernels->to_visibility_of_rest(rest.data(), total.data(), tau.data(), factor.data(), count);
        for (std::size_t i = 0; i < tau.size(); ++i) {
            const double exact = std::exp(-std::max(0.0, static_cast<double>(tau[i])));
            // Half a step, and the relative error of sweep_kernel_impl.h's cubic.
            ASSERT_NEAR(visibility[i], whole_visibility * exact, 0.5 + 1.2e-4 * whole_visibility * exact)
                << kernels->name << ", optical depth " << tau[i];
        }
        ASSERT_EQ(rest, visibility) << kernels->name;
    }
}

TEST(SweepKernels, VisibilityIsTheSameForEveryInstructionSet)
{
    std::mt19937 random(6);
    for (const int count : awkward_counts()) {
        const std::vector<float> tau = random_floats(random, count, 0.0F, 2e6F);
        const std::vector<float> total = random_floats(random, count, 1e6F, 4e6F);
        const std::vector<float> factor = random_floats(random, count, 0.0F, 6e-6F);
        const auto run = [&](const SweepKernels& kernels) {
            std::vector<std::uint16_t> out(static_cast<std::size_t>(2 * count));
            kernels.to_visibility(out.data(), tau.data(), factor.data(), count);
            kernels.to_visibility_of_rest(out.data() + count, total.data(), tau.data(), factor.data(), count);
            return out;
        };
        const std::vector<std::uint16_t> expected = run(sweep_kernels_baseline);
        for (const SweepKernels* kernels : runnable_kernels())
            ASSERT_EQ(run(*kernels), expected) << kernels->name << ", " << count << " cells";
    }
}

} // namespace
} // namespace lumisweep
