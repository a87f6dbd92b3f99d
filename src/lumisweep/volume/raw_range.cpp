#include "lumisweep/volume/raw_range.h"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include "lumisweep/base/parallel.h"

namespace lumisweep {
namespace {

/// In the voxels' own type, so that the compiler can take a whole vector at once.
template <class T>
RawRange range_of(const T* voxels, std::size_t count)
{
    T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
    for (std::size_t i = 0; i < count; ++i) {
        const T v = voxels[i];
        if constexpr (std::is_same_v<T, float>) {
            // Comparisons are false for NaN.
            constexpr float largest = std::numeric_limits<float>::max();
            low = v < low && v >= -largest ? v : low;
            high = v > high && v <= largest ? v : high;
        } else {
            low = v < low ? v : low;
            high = v > high ? v : high;
        }
    }
    return {static_cast<float>(low), static_cast<float>(high)};
}

} // namespace

RawRange raw_range(const ScalarGrid& volume)
{
    const std::size_t slice = static_cast<std::size_t>(volume.size().x) * static_cast<std::size_t>(volume.size().y);
    std::vector<RawRange> ranges(static_cast<std::size_t>(volume.size().z));
    visit_voxels(volume, [&](const auto* voxels) {
        parallel_for(std::size_t{0}, ranges.size(),
                     [&](std::size_t k) { ranges[k] = range_of(voxels + k * slice, slice); });
    });
    RawRange all;
    for (const RawRange& range : ranges)
        if (!range.empty())
            all = all.empty() ? range : RawRange{std::min(all.low, range.low), std::max(all.high, range.high)};
    return all;
}

} // namespace lumisweep
