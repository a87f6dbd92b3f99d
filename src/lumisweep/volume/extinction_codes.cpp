#include "lumisweep/volume/extinction_codes.h"

#include <algorithm>

#include "lumisweep/base/parallel.h"

namespace lumisweep {

ExtinctionCodes::ExtinctionCodes(const WholeBounds& bounds, const TransferFunction& transfer_function)
{
    const std::uint32_t entries = code_entries(bounds.range);
    if (entries == 0)
        return;
    const int levels = bits_of(entries);
    maxima_.resize(static_cast<std::size_t>(levels) * entries);
    view_ = {maxima_.data(), bounds.range.low, entries};

    const TransferPointsView points = transfer_function.points_view();
    std::vector<double> extinction(entries);
    parallel_for(
        std::uint32_t{0}, entries, [&](std::uint32_t i) { extinction[i] = extinction_of_entry(bounds, points, i); },
        1024);
    largest_ = largest_majorant(static_cast<float>(*std::max_element(extinction.begin(), extinction.end())));
    parallel_for(
        std::uint32_t{0}, entries, [&](std::uint32_t i) { maxima_[i] = code_of_extinction(extinction[i], largest_); },
        1024);
    for (std::size_t level = 1; level < static_cast<std::size_t>(levels); ++level) {
        const std::size_t half = std::size_t{1} << (level - 1);
        const std::uint8_t* from = maxima_.data() + (level - 1) * entries;
        std::uint8_t* to = maxima_.data() + level * entries;
        for (std::size_t i = 0; i + 2 * half <= entries; ++i)
            to[i] = std::max(from[i], from[i + half]);
    }
}

} // namespace lumisweep
