#include "lumisweep/scene/value_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace lumisweep {

namespace {

struct FiniteRange {
    double min = std::numeric_limits<double>::infinity(), max = -std::numeric_limits<double>::infinity();
    std::uint64_t count = 0;
};

template <class Voxel>
bool is_finite(Voxel v)
{
    if constexpr (std::is_floating_point_v<Voxel>)
        return std::isfinite(v);
    else
        return true;
}

using Blocks = tbb::blocked_range<std::size_t>;
constexpr std::size_t grain = std::size_t{1} << 18;

template <class Voxel>
FiniteRange raw_range(const Voxel* voxels, std::size_t count)
{
    return tbb::parallel_reduce(
        Blocks(0, count, grain), FiniteRange{},
        [voxels](const Blocks& block, FiniteRange range) {
            for (std::size_t i = block.begin(); i != block.end(); ++i) {
                if (!is_finite(voxels[i]))
                    continue;
                const double v = static_cast<double>(voxels[i]);
                range.min = std::min(range.min, v);
                range.max = std::max(range.max, v);
                ++range.count;
            }
            return range;
        },
        [](const FiniteRange& a, const FiniteRange& b) {
            return FiniteRange{std::min(a.min, b.min), std::max(a.max, b.max), a.count + b.count};
        });
}

using Counts = std::vector<std::uint64_t>;

template <class Voxel>
Counts raw_histogram(const Voxel* voxels, std::size_t count, double low, double bins_per_raw, std::size_t bins)
{
    return tbb::parallel_reduce(
        Blocks(0, count, grain), Counts(bins),
        [=](const Blocks& block, Counts counts) {
            for (std::size_t i = block.begin(); i != block.end(); ++i)
                if (is_finite(voxels[i])) {
                    const auto bin = static_cast<std::size_t>((static_cast<double>(voxels[i]) - low) * bins_per_raw);
                    ++counts[std::min(bin, bins - 1)];
                }
            return counts;
        },
        [](Counts a, const Counts& b) {
            for (std::size_t i = 0; i < a.size(); ++i)
                a[i] += b[i];
            return a;
        });
}

} // namespace

ValueStatistics value_statistics(const ScalarGrid& volume, int bins)
{
    ValueStatistics statistics;
    statistics.integers = volume.type() != VoxelType::f32;
    statistics.bits = static_cast<int>(8 * size_of(volume.type()));
    const FiniteRange range =
        visit_voxels(volume, [&](const auto* voxels) { return raw_range(voxels, volume.voxel_count()); });
    statistics.count = range.count;
    statistics.non_finite = volume.voxel_count() - range.count;
    if (range.count == 0)
        return statistics;

    const double extent = range.max - range.min;
    std::size_t bin_count = static_cast<std::size_t>(std::max(bins, 1));
    double raw_per_bin = extent / static_cast<double>(bin_count);
    if (statistics.integers) { // whole numbers of raw values a bin, so that no bin is favoured
        raw_per_bin = std::ceil((extent + 1.0) / static_cast<double>(bin_count));
        bin_count = static_cast<std::size_t>(std::floor(extent / raw_per_bin)) + 1;
    } else if (!(raw_per_bin > 0.0)) {
        raw_per_bin = 1.0;
        bin_count = 1;
    }
    statistics.histogram = visit_voxels(volume, [&](const auto* voxels) {
        return raw_histogram(voxels, volume.voxel_count(), range.min, 1.0 / raw_per_bin, bin_count);
    });
    const double a = volume.slope() * range.min + volume.intercept(),
                 b = volume.slope() * range.max + volume.intercept();
    if (volume.slope() < 0.0)
        std::reverse(statistics.histogram.begin(), statistics.histogram.end());
    statistics.min = std::min(a, b);
    statistics.max = std::max(a, b);
    statistics.bin_width = raw_per_bin * std::abs(volume.slope());
    return statistics;
}

double ValueStatistics::percentile(double fraction) const { return percentile_above(min, fraction); }

double ValueStatistics::percentile_above(double floor, double fraction) const
{
    const double first_bin = std::max(0.0, std::floor((floor - min) / bin_width));
    const auto first = static_cast<std::size_t>(std::min(first_bin, static_cast<double>(histogram.size())));
    std::uint64_t total = 0;
    for (std::size_t b = first; b < histogram.size(); ++b)
        total += histogram[b];
    if (total == 0)
        return max;
    const double wanted = fraction * static_cast<double>(total);
    std::uint64_t below = 0;
    for (std::size_t b = first; b < histogram.size(); ++b) {
        below += histogram[b];
        if (static_cast<double>(below) >= wanted)
            return std::min(min + static_cast<double>(b) * bin_width, max);
    }
    return max;
}

double ValueStatistics::lowest_share() const
{
    return count == 0 ? 0.0 : static_cast<double>(histogram[0]) / static_cast<double>(count);
}

double ValueStatistics::background_threshold() const
{
    double total = 0.0, moment = 0.0;
    for (std::size_t b = 1; b < histogram.size(); ++b) {
        total += static_cast<double>(histogram[b]);
        moment += static_cast<double>(b) * static_cast<double>(histogram[b]);
    }
    double best = -1.0, threshold = min, below = 0.0, below_moment = 0.0;
    for (std::size_t b = 1; b < histogram.size(); ++b) {
        below += static_cast<double>(histogram[b]);
        below_moment += static_cast<double>(b) * static_cast<double>(histogram[b]);
        if (below <= 0.0 || below >= total)
            continue;
        const double difference = below_moment / below - (moment - below_moment) / (total - below);
        const double between = below * (total - below) * difference * difference;
        if (between > best) {
            best = between;
            threshold = min + static_cast<double>(b + 1) * bin_width;
        }
    }
    return threshold;
}

} // namespace lumisweep
