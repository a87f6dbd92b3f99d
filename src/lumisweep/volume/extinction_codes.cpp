#include "lumisweep/volume/extinction_codes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/parallel.h"

namespace lumisweep {

namespace {

constexpr double inflation = 1.0 + 1e-5; // lookups in single precision round
/// Keeps reciprocals of majorants finite; far below what any ray can notice.
constexpr float smallest_largest = 1e-30F;

/// Codes of every bound and of the values between it and the next.
template <class Code>
std::vector<std::uint8_t> codes_of_bounds(const BoundsGrid& bounds, Code&& code)
{
    const BoundsGrid::Bounds range = bounds.range();
    std::vector<std::uint8_t> codes(2 * static_cast<std::size_t>(range.high - range.low) + 1);
    parallel_for(
        std::size_t{0}, codes.size(),
        [&](std::size_t i) {
            const double low = static_cast<double>(range.low) + static_cast<double>(i / 2);
            const double a = bounds.value(low), b = bounds.value(low + static_cast<double>(i % 2));
            const double slack = bounds.slack(a, b);
            codes[i] = code(std::min(a, b) - slack, std::max(a, b) + slack);
        },
        1024);
    return codes;
}

} // namespace

RangeTable::RangeTable(const BoundsGrid::Bounds& range, const std::vector<std::uint8_t>& codes, Better better)
    : lowest_(range.low), entries_(codes.size())
{
    const auto levels = static_cast<std::size_t>(std::bit_width(entries_));
    codes_.resize(levels * entries_);
    std::copy(codes.begin(), codes.end(), codes_.begin());
    for (std::size_t level = 1; level < levels; ++level) {
        const std::size_t half = std::size_t{1} << (level - 1);
        const std::uint8_t* from = codes_.data() + (level - 1) * entries_;
        std::uint8_t* to = codes_.data() + level * entries_;
        for (std::size_t i = 0; i + 2 * half <= entries_; ++i)
            to[i] = better(from[i], from[i + half]);
    }
}

ExtinctionCodes::ExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    const BoundsGrid::Bounds range = bounds.range();
    if (range.low > range.high)
        return;
    const double a = bounds.value(range.low), b = bounds.value(range.high), slack = bounds.slack(a, b);
    const auto highest = static_cast<float>(
        transfer_function.max_extinction(std::min(a, b) - slack, std::max(a, b) + slack) * inflation);
    largest_ = std::nextafter(std::max(highest, smallest_largest), std::numeric_limits<float>::infinity());
    maxima_ = RangeTable(range,
                         codes_of_bounds(bounds,
                                         [&](double low, double high) {
                                             return code_of(transfer_function.max_extinction(low, high) * inflation);
                                         }),
                         [](std::uint8_t x, std::uint8_t y) { return std::max(x, y); });
}

SmallestExtinctionCodes::SmallestExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function,
                                                 float largest)
{
    const BoundsGrid::Bounds range = bounds.range();
    if (range.low > range.high)
        return;
    const double codes_per_extinction = 256.0 / static_cast<double>(largest);
    minima_ = RangeTable(
        range,
        codes_of_bounds(bounds,
                        [&](double low, double high) {
                            const double smallest = transfer_function.min_extinction(low, high) / inflation;
                            return static_cast<std::uint8_t>(std::clamp(smallest * codes_per_extinction, 0.0, 255.0));
                        }),
        [](std::uint8_t x, std::uint8_t y) { return std::min(x, y); });
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
