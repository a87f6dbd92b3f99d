// The largest extinction between two bounds as a code of the majorant grid, in two lookups.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep {

/// Built once a transfer function. Entry 2 k is extinction at bound k exactly, entry 2 k + 1 its maximum from bound k
/// to the next; over them lie tables of the maxima of 2, 4, 8, … neighbours (a sparse table: Bender and Farach-Colton
/// 2000).
class ExtinctionCodes {
public:
    ExtinctionCodes(const BoundsGrid& bounds, const TransferFunction& transfer_function);

    /// A bound of all extinctions, 1/world unit; the highest code's.
    float largest() const { return largest_; }

    /// A code whose majorant bounds the extinction of all values within `bounds`; 0 where that is 0.
    std::uint8_t largest_code(const BoundsGrid::Bounds& bounds) const
    {
        if (bounds.empty())
            return 0;
        const unsigned first = 2U * (bounds.low - lowest_), span = 2U * (bounds.high - bounds.low) + 1U;
        const int level = std::bit_width(span >> 1U);
        const std::uint8_t* maxima = maxima_.data() + static_cast<std::size_t>(level) * entries_;
        return std::max(maxima[first], maxima[first + span - (1U << level)]);
    }

private:
    std::uint8_t code_of(double extinction) const;

    float largest_ = 0.0F;
    unsigned lowest_ = 0;
    std::size_t entries_ = 0;
    std::vector<std::uint8_t> maxima_; // [level][entry]
};

} // namespace lumisweep
