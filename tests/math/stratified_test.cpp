// Stratified random numbers: every run is stratified in every elementary interval, and over the keys each point is
// uniform and independent of all that it may not depend on.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "lumisweep/math/stratified.h"
#include "support/effort.h"
#include "support/statistics.h"

namespace lumisweep {
namespace {

using Point = std::array<double, 3>;

RandomKey<float> key_of(int pixel, std::uint64_t block = 0)
{
    const PassKey pass = pass_key(11, block);
    return path_key<float>(pixel, pass.k0, pass.k1);
}

Point point(const RandomKey<float>& key, int index, int set)
{
    const Random3<float> r = stratified3(key, index, set);
    return {r.a, r.b, r.c};
}

/// Collects p-values, to judge them together.
class Judge {
public:
    void add(double p, const std::string& what)
    {
        ++tests_;
        if (p < smallest_) {
            smallest_ = p;
            what_ = what;
        }
    }
    void add(const std::vector<std::uint64_t>& observed, double n, const std::string& what)
    {
        add(test::chi_square(observed, std::vector<double>(observed.size(), n / static_cast<double>(observed.size())))
                .p,
            what);
    }
    ~Judge() { EXPECT_GT(smallest_, test::sidak(0.001, tests_)) << what_ << ", of " << tests_ << " tests"; }

private:
    double tests_ = 0.0, smallest_ = 1.0;
    std::string what_;
};

std::size_t bin(double x, int bins, double zoom = 1.0)
{
    const double scaled = x * zoom;
    return static_cast<std::size_t>((scaled - std::floor(scaled)) * bins);
}

TEST(Stratified, OnePointInEveryElementaryIntervalOfEveryAlignedRun)
{
    constexpr int longest = 10, length = 1 << longest;
    std::vector<Point> points(length);
    std::vector<int> hits(length);
    for (int pixel = 0; pixel < test::effort(80); ++pixel) {
        const RandomKey<float> key = key_of(pixel * 977, static_cast<std::uint64_t>(pixel % 7));
        for (const int set : {0, 1, 2, 500}) {
            const int first = (pixel % 4) * (pixel % 3 == 0 ? 1 << 18 : 1) * length;
            for (int i = 0; i < length; ++i)
                points[static_cast<std::size_t>(i)] = point(key, first + i, set);
            for (int m = 0; m <= longest; ++m) {
                const int n = 1 << m;
                for (int run = 0; run < length; run += n) {
                    for (int split = -1; split <= m; ++split) { // -1: c alone
                        std::fill(hits.begin(), hits.begin() + n, 0);
                        for (int i = run; i < run + n; ++i) {
                            const Point& p = points[static_cast<std::size_t>(i)];
                            const std::size_t at = split < 0 ? bin(p[2], n)
                                                             : bin(p[0], 1 << split) * (std::size_t{1} << (m - split)) +
                                                                   bin(p[1], 1 << (m - split));
                            ++hits[at];
                        }
                        for (int i = 0; i < n; ++i)
                            ASSERT_EQ(hits[static_cast<std::size_t>(i)], 1)
                                << "pixel " << pixel << ", set " << set << ", run of 2^" << m << " from " << run
                                << ", columns 2^" << split;
                    }
                }
            }
        }
    }
}

TEST(Stratified, EveryPointIsUniformAndItsNumbersIndependentOverTheKeys)
{
    const int n = test::effort(65536);
    Judge judge;
    std::vector<Point> points(static_cast<std::size_t>(n)), others(points.size());
    for (const bool over_blocks : {false, true}) {
        for (const int index : {0, 1, 2, 5, 15, 16, 63, 1000}) {
            for (const int set : {0, 1, 2}) {
                for (int i = 0; i < n; ++i) {
                    const RandomKey<float> key = over_blocks ? key_of(77, static_cast<std::uint64_t>(i)) : key_of(i);
                    points[static_cast<std::size_t>(i)] = point(key, index, set);
                    others[static_cast<std::size_t>(i)] = point(key, index, (set + 1) % 3);
                }
                const std::string what = (over_blocks ? "blocks, index " : "pixels, index ") + std::to_string(index) +
                                         ", set " + std::to_string(set);
                for (const double zoom : {1.0, 64.0, 4096.0}) {
                    for (std::size_t c = 0; c < 3; ++c) {
                        std::vector<std::uint64_t> single(256), pair(32 * 32), next(32 * 32);
                        const std::size_t d = (c + 1) % 3;
                        for (const Point& p : points) {
                            ++single[bin(p[c], 256, zoom)];
                            ++pair[bin(p[c], 32, zoom) * 32 + bin(p[d], 32, zoom)];
                        }
                        // Neighbouring keys.
                        for (std::size_t i = 0; i + 1 < points.size(); i += 2)
                            ++next[bin(points[i][c], 32, zoom) * 32 + bin(points[i + 1][c], 32, zoom)];
                        judge.add(single, n, what + ", alone");
                        judge.add(pair, n, what + ", pair " + std::to_string(c));
                        judge.add(next, n / 2, what + ", next key");
                        for (std::size_t o = 0; o < 3; ++o) {
                            std::vector<std::uint64_t> sets(32 * 32);
                            for (std::size_t i = 0; i < points.size(); ++i)
                                ++sets[bin(points[i][c], 32, zoom) * 32 + bin(others[i][o], 32, zoom)];
                            judge.add(sets, n, what + ", next set");
                        }
                    }
                }
            }
        }
    }
}

/// Which of the 16 ways in which a run of four may lie in the four quarters: both pairs of indices have one point in
/// each half. The places of the first two and the half of the third say which.
std::size_t way_of(const std::array<int, 4>& quarter)
{
    EXPECT_NE(quarter[0] / 2, quarter[1] / 2);
    EXPECT_NE(quarter[2] / 2, quarter[3] / 2);
    EXPECT_EQ((1 << quarter[0]) | (1 << quarter[1]) | (1 << quarter[2]) | (1 << quarter[3]), 15);
    return static_cast<std::size_t>(quarter[0] * 4 + quarter[1] % 2 * 2 + quarter[2] / 2);
}

// Four shadow rays a camera ray take indices 4 i … 4 i + 3, the nearest collision first: none may have a quarter of its
// own, nor go with a quarter of the depth.
TEST(Stratified, RunsOfFourLieInTheQuartersInEveryWayAlike)
{
    const int n = test::effort(65536);
    Judge judge;
    for (const int first : {0, 4, 12, 60}) {
        for (const bool over_blocks : {false, true}) {
            std::vector<std::uint64_t> ways[3], a_and_c(256), b_and_c(256), sets(256), stratum(4 * 4);
            for (auto& w : ways)
                w.resize(16);
            for (int i = 0; i < n; ++i) {
                const RandomKey<float> key = over_blocks ? key_of(5, static_cast<std::uint64_t>(i)) : key_of(i);
                std::array<int, 4> quarter[3], other{};
                for (int j = 0; j < 4; ++j) {
                    const Point p = point(key, first + j, 2), q = point(key, first + j, 0);
                    for (std::size_t c = 0; c < 3; ++c)
                        quarter[c][static_cast<std::size_t>(j)] = static_cast<int>(p[c] * 4.0);
                    other[static_cast<std::size_t>(j)] = static_cast<int>(q[2] * 4.0);
                }
                const std::size_t way[3] = {way_of(quarter[0]), way_of(quarter[1]), way_of(quarter[2])};
                for (std::size_t c = 0; c < 3; ++c)
                    ++ways[c][way[c]];
                ++a_and_c[way[0] * 16 + way[2]];
                ++b_and_c[way[1] * 16 + way[2]];
                ++sets[way[0] * 16 + way_of(other)];
                ++stratum[static_cast<std::size_t>((i & 3) * 4 + quarter[0][static_cast<std::size_t>(i & 3)])];
            }
            const std::string what = "from " + std::to_string(first);
            for (const auto& w : ways)
                judge.add(w, n, what);
            judge.add(a_and_c, n, what + ", a and c");
            judge.add(b_and_c, n, what + ", b and c");
            judge.add(sets, n, what + ", another set");
            judge.add(stratum, n, what + ", index against quarter");
        }
    }
}

// Points of one run that lie in different halves by construction are independent below that.
TEST(Stratified, WithinTheirStrataPointsAreIndependent)
{
    const int n = test::effort(65536);
    Judge judge;
    for (const int set : {0, 1, 2}) {
        for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}, {4, 7}, {0, 15}}) {
            // What both points' strata leave free are the digits below 1/16.
            std::vector<std::uint64_t> pairs[3];
            for (auto& p : pairs)
                p.resize(32 * 32);
            for (int k = 0; k < n; ++k) {
                const Point p = point(key_of(k), i, set), q = point(key_of(k), j, set);
                for (std::size_t c = 0; c < 3; ++c)
                    ++pairs[c][bin(p[c], 32, 16.0) * 32 + bin(q[c], 32, 16.0)];
            }
            for (const auto& p : pairs)
                judge.add(p, n, "set " + std::to_string(set) + ", " + std::to_string(i) + " and " + std::to_string(j));
        }
    }
}

// A bijection of every aligned run to one: a bit of the result hangs on its own bit, which it follows or flips, and on
// the bits above.
TEST(Stratified, ShufflingKeepsAlignedRuns)
{
    for (int pixel = 0; pixel < 4000; ++pixel) {
        const RandomBits3<std::int32_t> bits = random_bits3(key_of(pixel), 3);
        const auto shuffled = [&](std::uint32_t index) {
            return static_cast<std::uint32_t>(detail::shuffle_index(static_cast<std::int32_t>(index), bits.x));
        };
        const auto index = static_cast<std::uint32_t>(bits.y), low = static_cast<std::uint32_t>(bits.z);
        for (unsigned m = 0; m < 32; ++m) {
            const std::uint32_t mask = (1U << m) - 1U;
            ASSERT_EQ(shuffled((index & ~mask) | (low & mask)) >> m, shuffled(index) >> m) << "2^" << m;
            ASSERT_EQ(shuffled(index ^ (1U << m)) >> m, shuffled(index) >> m ^ 1U) << "2^" << m;
        }
    }
}

TEST(Stratified, BitsAreReversedAndTheSecondDimensionIsPascals)
{
    for (int pixel = 0; pixel < 1000; ++pixel) {
        const auto x = static_cast<std::uint32_t>(random_bits3(key_of(pixel), 9).x);
        std::uint32_t reversed = 0, pascal = 0;
        for (unsigned r = 0; r < 32; ++r) {
            reversed |= (x >> r & 1U) << (31 - r);
            unsigned digit = 0;
            for (unsigned c = 0; c < 32; ++c)
                digit ^= (c & r) == r ? x >> c & 1U : 0U;
            pascal |= digit << r;
        }
        EXPECT_EQ(static_cast<std::uint32_t>(detail::reverse_bits(static_cast<std::int32_t>(x))), reversed);
        EXPECT_EQ(static_cast<std::uint32_t>(detail::sobol_1_from_bit_0(static_cast<std::int32_t>(x))), pascal);
    }
}

// Owen 1997: the variance of a smooth integrand falls almost with n^-3; independent numbers would have n^-1.
TEST(Stratified, VarianceOfSmoothIntegrandsFallsFast)
{
    double before[2] = {};
    for (const int n : {4, 16, 64, 256}) {
        test::Moments plane, line;
        for (int k = 0; k < test::effort(4000); ++k) {
            double sum[2] = {};
            for (int i = 0; i < n; ++i) {
                const Point p = point(key_of(k, 3), i, 1);
                sum[0] += std::exp(p[0] + 0.5 * p[1]);
                sum[1] += p[2] * p[2];
            }
            plane.add(sum[0] / n);
            line.add(sum[1] / n);
        }
        EXPECT_LT(std::fabs(plane.mean() - (std::exp(1.0) - 1.0) * 2.0 * (std::exp(0.5) - 1.0)),
                  4.0 * plane.standard_error());
        EXPECT_LT(std::fabs(line.mean() - 1.0 / 3.0), 4.0 * line.standard_error());
        if (n > 4) { // four times as many: 64 times less but for a logarithm, and not 4
            EXPECT_LT(plane.variance() / before[0], 1.0 / 24.0) << n;
            EXPECT_LT(line.variance() / before[1], 1.0 / 48.0) << n;
        }
        before[0] = plane.variance(), before[1] = line.variance();
    }
}

} // namespace
} // namespace lumisweep
