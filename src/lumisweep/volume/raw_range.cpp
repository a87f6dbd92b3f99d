#include "lumisweep/volume/raw_range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "lumisweep/base/parallel.h"

namespace lumisweep {
namespace {

/// Several independent minima and maxima, so that the compiler can use whole vectors. Comparisons are false for NaN,
/// which leaves it out.
template <class T>
RawRange range_of(const T* voxels, std::size_t count)
{
    constexpr std::size_t lanes = 64 / sizeof(T);
    T low[lanes], high[lanes];
    std::fill_n(low, lanes, std::numeric_limits<T>::max());
    std::fill_n(high, lanes, std::numeric_limits<T>::lowest());
    const auto take = [&](std::size_t lane, T v) {
        low[lane] = v < low[lane] ? v : low[lane];
        high[lane] = v > high[lane] ? v : high[lane];
    };
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes)
        for (std::size_t lane = 0; lane < lanes; ++lane)
            take(lane, voxels[i + lane]);
    for (; i < count; ++i)
        take(0, voxels[i]);
    return {static_cast<float>(*std::min_element(low, low + lanes)),
            static_cast<float>(*std::max_element(high, high + lanes))};
}

/// Infinities are rare: loaders make them NaN.
RawRange finite_range_of(const float* voxels, std::size_t count)
{
    RawRange range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
    for (std::size_t i = 0; i < count; ++i)
        if (std::isfinite(voxels[i]))
            range = {std::min(range.low, voxels[i]), std::max(range.high, voxels[i])};
    return range;
}

} // namespace

RawRange raw_range(const ScalarGrid& volume)
{
    const std::size_t slice = static_cast<std::size_t>(volume.size().x) * static_cast<std::size_t>(volume.size().y);
    std::vector<RawRange> ranges(static_cast<std::size_t>(volume.size().z));
    visit_voxels(volume, [&](const auto* voxels) {
        parallel_for(std::size_t{0}, ranges.size(), [&](std::size_t k) {
            ranges[k] = range_of(voxels + k * slice, slice);
            if constexpr (std::is_same_v<decltype(voxels), const float*>)
                if (std::isinf(ranges[k].low) || std::isinf(ranges[k].high))
                    ranges[k] = finite_range_of(voxels + k * slice, slice);
        });
    });
    RawRange all;
    for (const RawRange& range : ranges)
        if (!range.empty())
            all = all.empty() ? range : RawRange{std::min(all.low, range.low), std::max(all.high, range.high)};
    // Zeros of either sign become the one, whichever came first.
    return {all.low + 0.0F, all.high + 0.0F};
}

} // namespace lumisweep
