// V of two cells in the halves of a word, in fixed point; sums of a box stay below 2^16 in each half (Box::shift), so
// that nothing is carried from one to the other. Filtered V is at most 2 above whole_visibility, which the shifts
// allow.
#pragma once

#include <cstdint>

#include "lumisweep/visibility/sweep_box.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// shifted_visibility() of both.
LUMISWEEP_HD std::uint32_t shifted_pair(std::uint32_t pair, int shift)
{
    if (shift == 0)
        return pair;
    const std::uint32_t half = (1U << shift) >> 1, both = 0x10001U;
    return (pair + half * both) >> shift & (0xffffU >> shift) * both;
}

/// The mean of both boxes, from sums of shifted V.
LUMISWEEP_HD std::uint32_t mean_of_pair(std::uint32_t sums, std::uint32_t ends, const BoxScales& scales, int shift)
{
    const auto mean = [&](std::uint32_t sum, std::uint32_t sum_of_ends) {
        const std::uint16_t v = scales.mean(static_cast<std::uint16_t>(sum), static_cast<std::uint16_t>(sum_of_ends));
        return std::uint32_t{shift > most_exact_shift ? bounded_visibility(v) : v};
    };
    return mean(sums, ends) | mean(sums >> 16, ends >> 16) << 16;
}

} // namespace lumisweep::LUMISWEEP_CUDA
