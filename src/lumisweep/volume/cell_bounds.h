// Bounds of raw values in 16 bits and what they stand for: arithmetic that host and device share.
#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "lumisweep/base/host_device.h"
#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/volume/majorant_view.h"

namespace lumisweep {

/// The smallest and the largest finite value somewhere, in steps of a BoundsScale.
struct CellBounds {
    std::uint16_t low = 1, high = 0; ///< low > high where nothing is finite

    LUMISWEEP_HD bool empty() const { return low > high; }
};

/// What the steps of bounds are: voxels of 8 and 16 bits as they are, counted from the type's smallest; of single
/// precision 65536 steps of the volume's range without fill values.
struct BoundsScale {
    double first = 0.0, step = 1.0, first_bound = 0.0; // raw = first + step · (bound − first bound), but for
    double low_end = 0.0, high_end = 0.0;              // bounds 0 and 65535, the smallest and the largest value
    double near_size = 0.0, far_size = 0.0; ///< of numbers by which lookups round: within the steps, and at the ends
    double slope = 1.0, intercept = 0.0;    ///< value = slope · raw + intercept
};

/// Of a volume's bounds all but those of its cells and blocks.
struct WholeBounds {
    Vec3i volume_size{0, 0, 0};
    BoundsScale scale;
    CellBounds range;        ///< of the whole volume
    double block_side = 1.0; ///< world units, the geometric mean of the three
    double diagonal = 0.0;   ///< of the volume, world units
    bool has_gaps = false;   ///< some lookups find no finite value, so extinction may be 0 within any bounds
};

/// Bounds the relative error of lookups in single precision: three interpolations of some 1.2e-7 each, then the value's
/// slope, intercept and comparison with a knot, 6e-8 each.
inline constexpr double lookup_rounding = 1e-6;

LUMISWEEP_HD double raw_of_bound(const BoundsScale& scale, double bound)
{
    return bound <= 0.0       ? scale.low_end
           : bound >= 65535.0 ? scale.high_end
                              : scale.first + scale.step * (bound - scale.first_bound);
}

struct ValueRange {
    double low, high; ///< data units
};

/// All that lookups in single precision can find between two bounds; of a bound and itself, among equal voxels.
LUMISWEEP_HD ValueRange values_between(const BoundsScale& scale, double low, double high)
{
    const auto slack = [&](double bound) {
        const bool is_end = bound <= 0.0 || bound >= 65535.0;
        // Interpolation between equal voxels is exact: space of value 0 stays empty next to a flank.
        const double size = low == high ? 2.0 * std::fabs(raw_of_bound(scale, bound))
                            : is_end    ? scale.far_size
                                        : scale.near_size;
        return lookup_rounding * (std::fabs(scale.slope) * size + std::fabs(scale.intercept));
    };
    const double a = scale.slope * raw_of_bound(scale, low) + scale.intercept;
    const double b = scale.slope * raw_of_bound(scale, high) + scale.intercept;
    return scale.slope > 0.0 ? ValueRange{a - slack(low), b + slack(high)}
                             : ValueRange{b - slack(high), a + slack(low)};
}

/// Around voxels from `low` to `high`, rounded outwards; low > high where there are none.
template <class Voxel>
LUMISWEEP_HD CellBounds bounds_of(const BoundsScale& scale, Voxel low, Voxel high)
{
    if constexpr (std::is_integral_v<Voxel>) {
        constexpr int first = std::is_signed_v<Voxel> ? -(1 << (8 * sizeof(Voxel) - 1)) : 0;
        return {static_cast<std::uint16_t>(low - first), static_cast<std::uint16_t>(high - first)};
    } else {
        if (!(low <= high))
            return {};
        // Infinite voxels never give a finite value: they count as the ends of the range.
        const auto clamped = [](double bound) { return min(max(bound, 0.0), 65535.0); };
        const auto bound = [&](double v, double toward) {
            const double exact = scale.step > 0.0 ? clamped((v - scale.first) / scale.step + 1.0) : 1.0;
            double b = toward < 0.0 ? std::floor(exact) : std::ceil(exact);
            if ((raw_of_bound(scale, b) - v) * toward < 0.0)
                b += toward; // rounding, or beyond the steps
            return static_cast<std::uint16_t>(clamped(b));
        };
        const double l = static_cast<double>(low), h = static_cast<double>(high);
        // Between data and a value far away interpolation rounds as the far one does.
        const bool is_far = l < h && (l < scale.first || h > raw_of_bound(scale, 65534.0));
        const double beyond = is_far ? lookup_rounding * (std::fabs(l) + std::fabs(h)) : 0.0;
        return {bound(l - beyond, -1.0), bound(h + beyond, 1.0)};
    }
}

/// The voxels that interpolation within a cell depends on, along an axis of `voxels` voxels. At the last one it is
/// between that and the one before still, which rounds.
struct CellVoxels {
    int begin, end;
};
LUMISWEEP_HD CellVoxels voxels_of_cell(int cell, int voxels)
{
    return {max(min(cell * majorant_cell - 1, voxels - 2), 0), min((cell + 1) * majorant_cell, voxels)};
}

} // namespace lumisweep
