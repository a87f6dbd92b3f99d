// Codes of extinction, their table and what follows from them for a block: arithmetic that host and device share.
#pragma once

#include <bit>
#include <cstdint>

#include "lumisweep/base/host_device.h"
#include "lumisweep/math/lanes.h"
#include "lumisweep/volume/cell_bounds.h"
#include "lumisweep/volume/majorant_view.h"
#include "lumisweep/volume/transfer_points.h"

namespace lumisweep {

/// How many bits a number takes; 0 of 0.
LUMISWEEP_HD int bits_of(std::uint32_t n)
{
#if defined(__CUDA_ARCH__)
    return 32 - __clz(static_cast<int>(n));
#else
    return std::bit_width(n);
#endif
}

/// The table of codes over the bounds from `lowest` on. Entry 2 k is extinction at bound lowest + k exactly, entry
/// 2 k + 1 its maximum from there to the next; level l holds the maxima of 2^l neighbours (a sparse table: Bender and
/// Farach-Colton 2000). Memory: maxima [level][entries]; of a level only what does not reach beyond the last entry.
struct ExtinctionCodesView {
    const std::uint8_t* maxima = nullptr;
    std::uint32_t lowest = 0, entries = 0;

    /// A code whose majorant bounds the extinction of all values within `bounds`; 0 where that is 0.
    LUMISWEEP_HD std::uint8_t largest_code(const CellBounds& bounds) const
    {
        if (bounds.empty())
            return 0;
        const std::uint32_t first = 2U * (bounds.low - lowest), span = 2U * (bounds.high - bounds.low) + 1U;
        const int level = bits_of(span >> 1U);
        const std::uint8_t* of_level = maxima + static_cast<std::uint32_t>(level) * entries;
        const std::uint8_t a = of_level[first], b = of_level[first + span - (1U << level)];
        return a < b ? b : a;
    }
};

/// Entries and levels of the table for a volume's range; of an empty one there are none.
LUMISWEEP_HD std::uint32_t code_entries(const CellBounds& range)
{
    return range.empty() ? 0U : 2U * static_cast<std::uint32_t>(range.high - range.low) + 1U;
}

/// What entry i of the table bounds, 1/world unit: extinction as lookups in single precision find it.
LUMISWEEP_HD double extinction_of_entry(const WholeBounds& bounds, const TransferPointsView& transfer_function,
                                        std::uint32_t i)
{
    constexpr double inflation = 1.0 + 1e-5; // lookups in single precision round
    const double low = static_cast<double>(bounds.range.low) + static_cast<double>(i / 2);
    const ValueRange values = values_between(bounds.scale, low, low + static_cast<double>(i % 2));
    const double extinction = max_extinction(transfer_function, values.low, values.high) * inflation;
    return extinction > 0.0 ? extinction + lookup_error(transfer_function, values.low) : extinction;
}

/// The highest code's majorant, next above the largest entry in single precision, and no smaller than what keeps
/// reciprocals of majorants finite; far below what any ray can notice.
LUMISWEEP_HD float largest_majorant(float largest_entry)
{
    constexpr float smallest_largest = 1e-30F;
    return as_float(as_int(max(largest_entry, smallest_largest)) + 1);
}

/// The lowest code whose majorant is not below `extinction`, at most `largest`.
LUMISWEEP_HD std::uint8_t code_of_extinction(double extinction, float largest)
{
    if (extinction <= 0.0)
        return 0;
    // One below the code that has the first bits of the quotient: too low by more than anything rounds.
    const auto quotient = static_cast<float>(extinction / static_cast<double>(largest));
    int code = max(last_majorant_code - 1 + ((as_int(quotient) - 0x3f800000) >> 19), first_majorant_code);
    while (static_cast<double>(majorant_of_code<float>(code, largest)) < extinction)
        ++code;
    return static_cast<std::uint8_t>(code);
}

/// The majorant of a code in units of 2⁻¹⁸ of the largest one, exactly: sums of them know no order.
LUMISWEEP_HD std::uint32_t majorant_steps(int code)
{
    const int next = code + 1;
    return code < first_majorant_code ? 0U : (16U + static_cast<std::uint32_t>(next & 15)) << (next / 16 - 2);
}
inline constexpr double majorant_step = 1.0 / (1 << 18);

/// Of a block that is not empty, its own code: that of its largest cell, or 0 where that costs too much. `sum` is of
/// its cells' majorant_steps().
LUMISWEEP_HD std::uint8_t code_of_block(std::uint8_t largest_code, std::uint32_t sum, float largest, double block_side)
{
    // A block is crossed at once where that costs no more than this many tentative collisions more than cell by cell:
    // about what the steps from cell to cell take.
    constexpr double spare_collisions = 1.0;
    const double excess = static_cast<double>(majorant_steps(largest_code) * majorant_block_cells - sum) *
                          (majorant_step * static_cast<double>(largest));
    return excess * block_side <= spare_collisions * majorant_block_cells ? largest_code : std::uint8_t{0};
}

/// MajorantView::smallest of a block.
LUMISWEEP_HD std::uint8_t smallest_of_block(const CellBounds& block, const BoundsScale& scale,
                                            const TransferPointsView& transfer_function, float largest)
{
    if (block.empty())
        return 0;
    const double codes_per_extinction = 256.0 / static_cast<double>(largest) * (1.0 - 1e-5); // lookups round
    const ValueRange values = values_between(scale, block.low, block.high);
    const double smallest = min_extinction(transfer_function, values.low, values.high) -
                            lookup_error(transfer_function, values.low) -
                            1e-6 * static_cast<double>(largest); // flanks from within the values
    return static_cast<std::uint8_t>(min(max(smallest * codes_per_extinction, 0.0), 255.0));
}

} // namespace lumisweep
