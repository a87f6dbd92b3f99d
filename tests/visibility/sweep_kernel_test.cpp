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

int uniform(std::mt19937& random, int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); }

template <class T>
std::vector<T> random_values(std::mt19937& random, int count, int low, int high)
{
    std::vector<T> list(static_cast<std::size_t>(count));
    std::generate(list.begin(), list.end(), [&] { return static_cast<T>(uniform(random, low, high)); });
    return list;
}

std::vector<float> random_floats(std::mt19937& random, int count, float low, float high)
{
    std::uniform_real_distribution<float> value(low, high);
    std::vector<float> list(static_cast<std::size_t>(count));
    std::generate(list.begin(), list.end(), [&] { return value(random); });
    return list;
}

/// Lengths about the widths of vectors, and others.
std::vector<int> awkward_counts() { return {1, 2, 3, 7, 8, 15, 16, 17, 31, 32, 33, 47, 63, 64, 65, 127, 129, 200}; }

TEST(SweepKernels, TheWidestRunnableIsChosen) { EXPECT_EQ(&sweep_kernels(), runnable_kernels().back()); }

TEST(SweepKernels, PairsOfRows)
{
    std::mt19937 random(1);
    for (const SweepKernels* kernels : runnable_kernels())
        for (const int count : awkward_counts()) {
            const auto low = random_values<std::uint8_t>(random, count, 0, 255);
            const auto high = random_values<std::uint8_t>(random, count, 0, 255);
            const int before = pair_row_margin + 2 * edge_voxels;
            std::vector<std::uint8_t> bytes(static_cast<std::size_t>(2 * before + 2 * count), 99);
            kernels->make_pairs(bytes.data() + before, low.data(), high.data(), count);
            for (int u = -edge_voxels; u < count + edge_voxels; ++u) {
                const std::size_t voxel = static_cast<std::size_t>(std::clamp(u, 0, count - 1));
                const std::size_t at = static_cast<std::size_t>(before + 2 * u);
                ASSERT_EQ(bytes[at], low[voxel]) << kernels->name << ", " << count << " voxels, at " << u;
                ASSERT_EQ(bytes[at + 1], high[voxel]) << kernels->name << ", " << count << " voxels, at " << u;
            }
        }
}

/// Rays and the pieces of slices that they count, as the march makes them.
struct MarchCase {
    int rays;
    std::vector<std::int32_t> even, odd;
    std::vector<std::vector<std::uint8_t>> pairs;
    struct Window {
        int first, last; ///< the rays that count the slice
    };
    std::vector<MarchRow> rows;
    std::vector<Window> windows; ///< [row]
    std::vector<int> edge;
    std::vector<std::vector<std::uint32_t>> counted;
    MarchBlocks blocks{};

    MarchCase(std::mt19937& random, int ray_count, int row_count) : rays(ray_count)
    {
        const int padded = (rays + ray_block - 1) / ray_block * (ray_block / 2);
        even = random_values<std::int32_t>(random, padded, -1000000, 100000000);
        odd = random_values<std::int32_t>(random, padded, -1000000, 100000000);
        for (int r = 0; r < row_count; ++r) {
            MarchRow row{};
            Window window{};
            // Whole rows, one ray, none, part of one block, any.
            switch (uniform(random, 0, 5)) {
            case 0: window.first = 0, window.last = rays; break;
            case 1: window.first = uniform(random, 0, rays - 1), window.last = window.first + 1; break;
            case 2: window.first = rays, window.last = 0; break;
            case 3: window.first = rays / ray_block * ray_block, window.last = rays; break;
            default: window.first = uniform(random, 0, rays); window.last = uniform(random, window.first, rays);
            }
            // Readable from a margin before the first counted ray's voxels to one behind the last's.
            const int first = std::min(window.first, rays - 1), last = std::max(window.last, first + 1);
            // (A block without any ray of the slice is not read by the sweep; here the whole row of rays may be.)
            pairs.push_back(
                random_values<std::uint8_t>(random, 2 * (last - first + 1) + 2 * pair_row_margin + 4 * rays, 0, 255));
            if (uniform(random, 0, 3) == 0)
                std::fill(pairs.back().begin(), pairs.back().end(), std::uint8_t{255});
            row.pairs = pairs.back().data() + (pair_row_margin + 2 * rays - 2 * first);
            int rest = uniform(random, 0, 3) == 0 ? 127 : uniform(random, 0, 127);
            for (int k = 0; k < 4; ++k) {
                const int weight = k == 3 || uniform(random, 0, 4) == 0 ? rest : uniform(random, 0, rest);
                row.weight[k] = static_cast<std::int8_t>(weight);
                rest -= weight;
            }
            rows.push_back(row);
            windows.push_back(window);
        }
        place_blocks();
    }

    /// Blocks that all windows fill from the first to the last; all others are edges.
    void place_blocks()
    {
        const auto filled = [&](int block) {
            return std::all_of(windows.begin(), windows.end(), [&](const Window& w) {
                return w.first <= block * ray_block && w.last >= (block + 1) * ray_block;
            });
        };
        const int count = (rays + ray_block - 1) / ray_block;
        while (blocks.first < count && !filled(blocks.first))
            ++blocks.first;
        for (blocks.last = blocks.first; blocks.last < count && filled(blocks.last);)
            ++blocks.last;
        for (int block = 0; block < count; ++block)
            if (block < blocks.first || block >= blocks.last)
                edge.push_back(block);
        for (const Window& w : windows) {
            counted.emplace_back();
            for (const int block : edge) {
                std::uint32_t bits = 0;
                for (int ray = std::max(w.first, block * ray_block); ray < std::min(w.last, (block + 1) * ray_block);
                     ++ray)
                    bits |= 1U << (ray / 2 % 16 + ray % 2 * 16);
                counted.back().push_back(bits);
            }
        }
        for (std::size_t r = 0; r < rows.size(); ++r)
            rows[r].counted = counted[r].data();
        blocks.edge = edge.data();
        blocks.edge_count = static_cast<int>(edge.size());
    }

    void march_plainly()
    {
        for (std::size_t r = 0; r < rows.size(); ++r)
            for (int ray = windows[r].first; ray < windows[r].last; ++ray)
                for (int k = 0; k < 4; ++k)
                    (ray % 2 == 0 ? even : odd)[static_cast<std::size_t>(ray / 2)] +=
                        rows[r].pairs[2 * ray + k] * rows[r].weight[k];
    }
};

TEST(SweepKernels, MarchAddsWhatTheWindowsCount)
{
    std::mt19937 random(2);
    for (int repeat = 0; repeat < 1500; ++repeat) {
        const int rays = repeat % 3 == 0 ? uniform(random, 1, 40) : uniform(random, 1, 300);
        const MarchCase start(random, rays, uniform(random, 0, march_slices));
        MarchCase expected = start;
        expected.march_plainly();
        for (const SweepKernels* kernels : runnable_kernels()) {
            MarchCase marched = start;
            kernels->march(marched.even.data(), marched.odd.data(), start.rows.data(),
                           static_cast<int>(start.rows.size()), start.blocks);
            ASSERT_EQ(marched.even, expected.even) << kernels->name << ", case " << repeat;
            ASSERT_EQ(marched.odd, expected.odd) << kernels->name << ", case " << repeat;
        }
    }
}

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
            const int ray = step != 0 ? first + 2 * step * c : uniform(random, 0, 2 * half - 2);
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
    for (const int step : {0, 1, 2, 3, 4})
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
            row.row_begin[k] = static_cast<float>(127 * uniform(random, 0, 20));
            row.row_end[k] = static_cast<float>(127 * uniform(random, 10, slices));
        }
        row.row_enter = random_floats(random, 1, 0.0F, 10.0F)[0];
        row.row_leave = random_floats(random, 1, 10.0F, 50.0F)[0];
        row.fraction_rows = random_floats(random, 1, 0.0F, 1.0F)[0];
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
                const double g = k < 2 ? 1.0 - sides.row.fraction_rows : sides.row.fraction_rows;
                const double begin =
                    std::max(k % 2 == 0 ? sides.begin_low[c] : sides.begin_high[c], sides.row.row_begin[k / 2]);
                const double end =
                    std::min(k % 2 == 0 ? sides.end_low[c] : sides.end_high[c], sides.row.row_end[k / 2]);
                const double at = sides.row.weight;
                until += f * g * std::max(0.0, std::min(end, at) - begin);
                from += f * g * std::max(0.0, end - std::max(begin, at));
            }
            const double scale = sides.row.scale;
            const double enter = std::max(sides.enter[c], sides.row.row_enter);
            const double leave = std::min(sides.leave[c], sides.row.row_leave);
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

TEST(SweepKernels, FilterPieces)
{
    std::mt19937 random(7);
    for (const int count : awkward_counts())
        for (const int shift : {0, 1, 4, 7}) {
            const int half = (1 << shift) >> 1;
            const auto a = random_values<std::uint16_t>(random, count, 0, 65535);
            const auto b = random_values<std::uint16_t>(random, count, 0, whole_visibility);
            const auto c = random_values<std::uint16_t>(random, count, 0, whole_visibility);
            const auto scale_a = random_values<std::uint16_t>(random, count, 0, 65535);
            const auto scale_b = random_values<std::uint16_t>(random, count, 0, 65535);
            const std::size_t n = a.size();
            std::vector<std::uint16_t> sum(n), slid(n), mean(n), row_mean(n);
            std::vector<std::uint8_t> bytes(n);
            for (std::size_t i = 0; i < n; ++i) {
                const std::uint32_t ends =
                    static_cast<std::uint32_t>(((b[i] + half) >> shift) + ((c[i] + half) >> shift));
                const auto product = [](std::uint32_t x, std::uint32_t scale) { return (x * scale) >> 16; };
                sum[i] = static_cast<std::uint16_t>(a[i] + b[i]);
                slid[i] = static_cast<std::uint16_t>(a[i] + ((b[i] + half) >> shift) - ((c[i] + half) >> shift));
                mean[i] = static_cast<std::uint16_t>(product(a[i], scale_a[i]) +
                                                     product(static_cast<std::uint32_t>(b[i] + c[i]), scale_b[i]));
                row_mean[i] = static_cast<std::uint16_t>(product(a[i], scale_a[0]) + product(ends, scale_b[0]));
                bytes[i] = static_cast<std::uint8_t>(std::lround(b[i] / 16.0));
            }
            for (const SweepKernels* kernels : runnable_kernels()) {
                std::vector<std::uint16_t> out(n), sums = a;
                std::vector<std::uint8_t> stored(n);
                kernels->add(out.data(), a.data(), b.data(), count);
                ASSERT_EQ(out, sum) << kernels->name;
                kernels->slide(sums.data(), b.data(), c.data(), shift, count);
                ASSERT_EQ(sums, slid) << kernels->name;
                kernels->box_mean(out.data(), a.data(), b.data(), c.data(), scale_a.data(), scale_b.data(), count);
                ASSERT_EQ(out, mean) << kernels->name;
                kernels->box_mean_row(out.data(), a.data(), b.data(), c.data(), shift, scale_a[0], scale_b[0], count);
                ASSERT_EQ(out, row_mean) << kernels->name;
                kernels->store(stored.data(), b.data(), count);
                ASSERT_EQ(stored, bytes) << kernels->name;
            }
        }
}

} // namespace
} // namespace lumisweep
