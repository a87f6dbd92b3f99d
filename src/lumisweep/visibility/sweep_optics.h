// From what rays hold to V of one cell: interpolation, the box's sides, exponential; for the CPU and the GPU, which
// agree to the bit because nothing is contracted or reassociated.
//
// Included by files of every instruction set: all of it is inlined.
#pragma once

#include <cstdint>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

/// V during filtering: fixed point, this is 1 (sixteen times 255).
inline constexpr int whole_visibility = 4080;

LUMISWEEP_HD float lesser(float a, float b) { return a < b ? a : b; }
LUMISWEEP_HD float greater(float a, float b) { return a > b ? a : b; }

/// Bilinear between four rays, of two rows.
LUMISWEEP_HD float between_rays(std::int32_t low, std::int32_t low_next, std::int32_t high, std::int32_t high_next,
                                float fraction, float fraction_rows)
{
    const float rest = 1.0F - fraction, rest_rows = 1.0F - fraction_rows;
    const float below = static_cast<float>(low) * rest + static_cast<float>(low_next) * fraction;
    const float above = static_cast<float>(high) * rest + static_cast<float>(high_next) * fraction;
    return below * rest_rows + above * fraction_rows;
}

/// Natural optical depth × log2 e of one stored step over one slice. Bounded, so that no extinction stays none even
/// where the scale is infinite.
LUMISWEEP_HD float optical_scale(double extinction_of_one, double slice_world)
{
    constexpr double log2_e = 1.442695040888963407;
    const double scale = extinction_of_one * slice_world * log2_e;
    return static_cast<float>(1e30 < scale ? 1e30 : scale);
}

/// The sides of v as a row of cells sees them, likewise for its two rows of rays; those of u are CellSides.
struct RowSides {
    float begin[2], end[2], enter, leave;
    float fraction; ///< between the two rows
};

/// Factors that turn summed τ into the optical depth of a cell times log2 e: forwards, from the start face to the cell,
/// and backwards, from the cell to the other end.
struct SideFactors {
    float forwards, backwards;
};

/// part / weight, 0 where nothing was counted.
LUMISWEEP_HD float per_weight(float part, float weight)
{
    const float quotient = greater(part, 0.0F) / greater(weight, 1e-3F); // weights are whole numbers in [0, 1] parts
    return weight > 0.0F ? quotient : 0.0F;
}

/// The column as in CellSides; `depth` of the cell in slices, `weight` that a ray from the start face has there.
LUMISWEEP_HD SideFactors side_factors_of(float begin_low, float begin_high, float end_low, float end_high, float enter,
                                         float leave, float fraction, const RowSides& row, float depth, float weight,
                                         float scale)
{
    const float rest = 1.0F - fraction, f_rows = row.fraction, rest_rows = 1.0F - f_rows;
    const float begin0 = greater(begin_low, row.begin[0]), begin1 = greater(begin_high, row.begin[0]);
    const float begin2 = greater(begin_low, row.begin[1]), begin3 = greater(begin_high, row.begin[1]);
    const float end0 = lesser(end_low, row.end[0]), end1 = lesser(end_high, row.end[0]);
    const float end2 = lesser(end_low, row.end[1]), end3 = lesser(end_high, row.end[1]);
    const float until0 = greater(lesser(end0, weight) - begin0, 0.0F);
    const float until1 = greater(lesser(end1, weight) - begin1, 0.0F);
    const float until2 = greater(lesser(end2, weight) - begin2, 0.0F);
    const float until3 = greater(lesser(end3, weight) - begin3, 0.0F);
    const float from0 = greater(end0 - greater(begin0, weight), 0.0F);
    const float from1 = greater(end1 - greater(begin1, weight), 0.0F);
    const float from2 = greater(end2 - greater(begin2, weight), 0.0F);
    const float from3 = greater(end3 - greater(begin3, weight), 0.0F);
    const float until = (until0 * rest + until1 * fraction) * rest_rows + (until2 * rest + until3 * fraction) * f_rows;
    const float from = (from0 * rest + from1 * fraction) * rest_rows + (from2 * rest + from3 * fraction) * f_rows;
    return {per_weight(depth - greater(enter, row.enter), until) * scale,
            per_weight(lesser(leave, row.leave) - depth, from) * scale};
}

/// Larger optical depths leave nothing.
inline constexpr float most_depth = 30.0F;

/// 2^−y in whole_visibility, at most 1; 0 from y = most = most_depth on. Relative error below 8e−5.
LUMISWEEP_HD std::uint16_t fixed_visibility(float y, float most)
{
    const float bounded = lesser(y, most);
    const int whole = static_cast<int>(bounded + 0.5F);  // below 0 by no more than rounding
    const float f = static_cast<float>(whole) - bounded; // −1/2 … 1/2
    // 2^f by the cubic of least relative error.
    float p = 0.05517167F * whole_visibility;
    p = p * f + 0.24261112F * whole_visibility;
    p = p * f + 0.69326099F * whole_visibility;
    p = p * f + 0.99992807F * whole_visibility;
    const int v = static_cast<int>(__builtin_bit_cast(float, __builtin_bit_cast(int, p) - (whole << 23)) + 0.5F);
    return static_cast<std::uint16_t>(v < whole_visibility ? v : whole_visibility);
}

/// In 8 bits, rounded.
LUMISWEEP_HD std::uint8_t stored_visibility(std::uint16_t fixed) { return static_cast<std::uint8_t>((fixed + 8) >> 4); }

} // namespace lumisweep
