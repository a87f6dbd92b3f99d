#include "lumisweep/volume/extinction_codes.h"

#include <cmath>
#include <limits>

#include "lumisweep/base/parallel.h"

namespace lumisweep {

namespace {

constexpr double inflation = 1.0 + 1e-5; // lookups in single precision round
/// Keeps reciprocals of majorants finite; far below what any ray can notice.
constexpr float smallest_largest = 1e-30F;

} // namespace

ExtinctionCodes::ExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    const BoundsGrid::Bounds range = bounds.range();
    if (range.empty())
        return;
    lowest_ = range.low;
    entries_ = 2 * static_cast<std::size_t>(range.high - range.low) + 1;
    const int levels = std::bit_width(entries_);
    maxima_.resize(static_cast<std::size_t>(levels) * entries_);

    std::vector<double> extinction(entries_);
    parallel_for(
        std::size_t{0}, entries_,
        [&](std::size_t i) {
            const double low = static_cast<double>(lowest_) + static_cast<double>(i / 2);
            const BoundsGrid::Values values = bounds.values(low, low + static_cast<double>(i % 2));
            extinction[i] = transfer_function.max_extinction(values.low, values.high) * inflation;
            if (extinction[i] > 0.0)
                extinction[i] += transfer_function.lookup_error(values.low);
        },
        1024);
    const auto highest = static_cast<float>(*std::max_element(extinction.begin(), extinction.end()));
    largest_ = std::nextafter(std::max(highest, smallest_largest), std::numeric_limits<float>::infinity());
    parallel_for(
        std::size_t{0}, entries_, [&](std::size_t i) { maxima_[i] = code_of(extinction[i]); }, 1024);
    for (std::size_t level = 1; level < static_cast<std::size_t>(levels); ++level) {
        const std::size_t half = std::size_t{1} << (level - 1);
        const std::uint8_t* from = maxima_.data() + (level - 1) * entries_;
        std::uint8_t* to = maxima_.data() + level * entries_;
        for (std::size_t i = 0; i + 2 * half <= entries_; ++i)
            to[i] = std::max(from[i], from[i + half]);
    }
}

/// The lowest code that is not below `extinction`.
std::uint8_t ExtinctionCodes::code_of(double extinction) const
{
    if (extinction <= 0.0)
        return 0;
    const double octaves = std::log2(extinction / static_cast<double>(largest_));
    // Within an octave codes are spaced evenly, not by powers: start below its lower end.
    int code = std::max(last_majorant_code - 1 + static_cast<int>(std::floor(octaves)) * 16, first_majorant_code);
    while (static_cast<double>(majorant_of_code<float>(code, largest_)) < extinction)
        ++code;
    return static_cast<std::uint8_t>(code);
}

} // namespace lumisweep
