#include "lumisweep/visibility/sweep_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "kernel_tables.h"

namespace lumisweep {
namespace {

using namespace test;

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
