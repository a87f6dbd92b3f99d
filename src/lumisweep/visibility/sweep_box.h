// The sweep-space filter's box (sweep_filter.h) along one axis, and the mean of one cell, for the CPU and the GPU.
#pragma once

#include <cmath>
#include <cstdint>

#include "lumisweep/base/host_device.h"
#include "lumisweep/visibility/sweep_optics.h"

namespace lumisweep {

/// The box's side in cells where rays have come `distance` slices (journal paper, equation 10).
LUMISWEEP_HD double box_side(double distance, double slice_world, double tan_beta, double cell_world)
{
    return 1.0 + distance * slice_world * tan_beta / cell_world;
}

LUMISWEEP_HD std::uint16_t high_product(std::uint16_t a, std::uint16_t b)
{
    return static_cast<std::uint16_t>((static_cast<std::uint32_t>(a) * b) >> 16);
}

/// Weights, in 1/65536, of the cells wholly inside of a box and of the two at its ends.
struct alignas(4) BoxScales {
    std::uint16_t whole, ends;

    /// From the sum of the cells wholly inside and of the two at the ends; each product is rounded down.
    LUMISWEEP_HD std::uint16_t mean(std::uint16_t sum, std::uint16_t sum_of_ends) const
    {
        return static_cast<std::uint16_t>(high_product(sum, whole) + high_product(sum_of_ends, ends));
    }
};

/// A box of `box` cells about a cell's centre: the `reach` cells on either side wholly, one more by `fraction`.
struct Box {
    int reach;
    double fraction;
    int shift; ///< by which V is shifted down, so that the sum of the box fits 16 bits

    LUMISWEEP_HD Box(double box, int count)
    {
        const double half = 0.5 * (box - 1.0);
        const double side = half < 0.0 ? 0.0 : half > count ? static_cast<double>(count) : half;
        reach = static_cast<int>(side);
        fraction = side - reach;
        const int most = width() < count ? width() : count;
        for (shift = 0; ((whole_visibility + ((1 << shift) >> 1)) >> shift) * most > 65535;)
            ++shift;
    }
    LUMISWEEP_HD int width() const { return 2 * reach + 1; }
    /// Whether it leaves a line of `count` cells as it is.
    LUMISWEEP_HD bool is_identity(int count) const { return count == 1 || (reach == 0 && fraction < 1e-4); }

    /// For cell i of a line of `count`.
    LUMISWEEP_HD BoxScales scales(int i, int count) const
    {
        const int first = i - reach > 0 ? i - reach : 0, last = i + reach < count - 1 ? i + reach : count - 1;
        const int ends = (i - reach - 1 >= 0 ? 1 : 0) + (i + reach + 1 < count ? 1 : 0);
        return scales_of(last - first + 1 + fraction * ends);
    }
    /// Those of a cell whose box does not leave the line.
    LUMISWEEP_HD BoxScales inside() const { return scales_of(width() + 2.0 * fraction); }

private:
    LUMISWEEP_HD BoxScales scales_of(double covered) const
    {
        const double one = 65536.0 * (1 << shift) / covered;
        return {rounded_up(one), rounded_up(one * fraction)};
    }
    LUMISWEEP_HD static std::uint16_t rounded_up(double x)
    {
        const double up = std::ceil(x);
        return static_cast<std::uint16_t>(up < 65535.0 ? up : 65535.0);
    }
};

/// V shifted down as Box::shift says, rounded to nearest; half = 2^shift / 2 rounded down.
LUMISWEEP_HD std::uint16_t shifted_visibility(std::uint16_t v, int shift, int half)
{
    return static_cast<std::uint16_t>((v + half) >> shift);
}

/// Sums of fewer than 8 bits a cell round 1 up to 4096/4080, which would be 0 in 8 bits.
inline constexpr int most_exact_shift = 4;
LUMISWEEP_HD std::uint16_t bounded_visibility(std::uint16_t v)
{
    return v < whole_visibility ? v : static_cast<std::uint16_t>(whole_visibility);
}

} // namespace lumisweep
