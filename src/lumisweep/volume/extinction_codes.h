// The largest and the smallest extinction between two bounds as codes of the majorant grid, in two lookups.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep {

/// The best code between two bounds. Entry 2 k is the code at bound k exactly, entry 2 k + 1 the best from bound k to
/// the next; over them lie tables of the best of 2, 4, 8, … neighbours (a sparse table: Bender and Farach-Colton 2000).
class RangeTable {
public:
    using Better = std::uint8_t (*)(std::uint8_t, std::uint8_t);

    RangeTable() = default;
    /// `codes` for 2 (range.high − range.low) + 1 entries.
    RangeTable(const BoundsGrid::Bounds& range, const std::vector<std::uint8_t>& codes, Better better);

    template <class BetterOfTwo>
    std::uint8_t best(const BoundsGrid::Bounds& bounds, BetterOfTwo better) const
    {
        const unsigned first = 2U * (bounds.low - lowest_), span = 2U * (bounds.high - bounds.low) + 1U;
        const int level = std::bit_width(span) - 1;
        const std::uint8_t* codes = codes_.data() + static_cast<std::size_t>(level) * entries_;
        return better(codes[first], codes[first + span - (1U << level)]);
    }

private:
    unsigned lowest_ = 0;
    std::size_t entries_ = 0;
    std::vector<std::uint8_t> codes_; // [level][entry]
};

/// Built once a transfer function.
class ExtinctionCodes {
public:
    ExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function);

    /// A bound of all extinctions, 1/world unit; the highest code's.
    float largest() const { return largest_; }

    /// A code whose majorant bounds the extinction of all values within `bounds`; 0 where that is 0.
    std::uint8_t largest_code(const BoundsGrid::Bounds& bounds) const
    {
        if (bounds.low > bounds.high)
            return 0;
        return maxima_.best(bounds, [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); });
    }

private:
    std::uint8_t code_of(double extinction) const;

    float largest_ = 0.0F;
    RangeTable maxima_;
};

/// The same for the smallest extinction: code · largest / 256 lies at or below it, and below every majorant above 0.
class SmallestExtinctionCodes {
public:
    SmallestExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function, float largest);

    std::uint8_t smallest_code(const BoundsGrid::Bounds& bounds) const
    {
        if (bounds.low > bounds.high)
            return 0;
        return minima_.best(bounds, [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); });
    }

private:
    RangeTable minima_;
};

} // namespace lumisweep
