// Where the cells of a slice lie between a line's rays, and how much of a ray lies inside of the box: the arithmetic of
// one cell, for the CPU and the GPU. sweep_geometry.h says how rays run.
#pragma once

#include <cmath>
#include <cstdint>

#include "lumisweep/base/host_device.h"
#include "lumisweep/visibility/sweep_optics.h"

namespace lumisweep {

/// Sum of a whole slice's weights: four signed bytes whose products with voxels must not overflow 16 bits in pairs.
inline constexpr int slice_weight = 127;

/// The depths at which a ray passes the low and the high side of the box along u (or v).
struct SidePass {
    double enter, leave;
};

/// The rays along one axis of the plane.
struct RayAxis {
    int size;      ///< voxels of the level
    double slope;  ///< voxels per slice, −1 … 1
    int first_ray; ///< number of the first ray; even, because even and odd rays are stored apart

    /// For a ray at `x` voxels from the voxel centres' origin on the start face; need not be a whole number.
    LUMISWEEP_HD SidePass pass(double x) const
    {
        constexpr double never = 1e9;
        const double low = -0.5 - x, high = size - 0.5 - x; // of slope · depth
        if (std::fabs(slope) < 1e-12)
            return low <= 0.0 && high >= 0.0 ? SidePass{-never, never} : SidePass{never, -never};
        const auto bounded = [](double depth) { return depth < -never ? -never : depth > never ? never : depth; };
        const double a = bounded(low / slope), b = bounded(high / slope);
        return {b < a ? b : a, b < a ? a : b};
    }
};

/// Weight that a ray from the start face has counted down to `depth`: whole slices count 127.
LUMISWEEP_HD std::int32_t weight_at(double depth)
{
    const double whole = std::floor(depth);
    return static_cast<std::int32_t>(whole) * slice_weight +
           static_cast<std::int32_t>(std::lround((depth - whole) * slice_weight));
}

/// The depth of the k-th slice of cells.
LUMISWEEP_HD double lookup_depth(int k, double cell_side) { return (k + 0.5) * cell_side; }

struct alignas(8) CellPlace {
    std::int32_t ray; ///< beside the cell on its low side, less first_ray
    float fraction;   ///< towards the next ray
};

/// The cells of one slice along one axis of the plane.
class CellRow {
public:
    /// `cell_side` in level voxels.
    LUMISWEEP_HD CellRow(const RayAxis& axis, double cell_side, double depth)
        : side_(cell_side), middle_(0.5 * cell_side - 0.5 - axis.slope * depth), begin_(middle_ - axis.first_ray),
          first_(std::floor(begin_)), even_(is_even(cell_side))
    {
    }

    /// Whether one step from ray to ray and one fraction hold for all cells.
    LUMISWEEP_HD static bool is_even(double cell_side)
    {
        return cell_side == std::floor(cell_side) && cell_side <= 8.0;
    }
    LUMISWEEP_HD CellPlace place(int cell) const
    {
        const double x = (even_ ? first_ : begin_) + cell * side_;
        const double low = even_ ? x : std::floor(x);
        return {static_cast<std::int32_t>(low), static_cast<float>(even_ ? begin_ - first_ : x - low)};
    }
    /// Where a ray through the cell's middle starts, as RayAxis::pass() takes it.
    LUMISWEEP_HD double start(int cell) const { return middle_ + cell * side_; }

private:
    double side_, middle_, begin_, first_;
    bool even_;
};

/// The box's sides as a column of cells sees them: the weights (weight_at) at which the rays on its low and high side
/// begin and end to count, and the depths at which the column itself passes the sides.
struct alignas(8) CellSides {
    float begin_low, begin_high, end_low, end_high, enter, leave;
};

/// `begin` and `end` as in SweepAxis.
LUMISWEEP_HD CellSides sides_of(const RayAxis& axis, const std::int32_t* begin, const std::int32_t* end,
                                const CellRow& cells, int cell, std::int32_t ray)
{
    const SidePass pass = axis.pass(cells.start(cell));
    const auto weight = [](std::int32_t slices) { return static_cast<float>(slices * slice_weight); };
    return {weight(begin[ray]),   weight(begin[ray + 1]),         weight(end[ray]),
            weight(end[ray + 1]), static_cast<float>(pass.enter), static_cast<float>(pass.leave)};
}

/// Rows of rays that run from one end to the other, `whole` of weight and `slices` deep, see the sides of u only.
LUMISWEEP_HD RowSides no_row_sides(float whole, float slices)
{
    return {{0.0F, 0.0F}, {whole, whole}, 0.0F, slices, 0.0F};
}
/// Whether a row of cells, whose sides of v these are, is not such a row.
LUMISWEEP_HD bool sees_sides(const CellSides& row, float whole, float slices)
{
    return row.begin_low > 0.0F || row.begin_high > 0.0F || row.enter > 0.0F || row.end_low < whole ||
           row.end_high < whole || row.leave < slices;
}
LUMISWEEP_HD RowSides row_sides(const CellSides& row, float slices, float fraction)
{
    return {{row.begin_low, row.begin_high},
            {row.end_low, row.end_high},
            greater(row.enter, 0.0F),
            lesser(row.leave, slices),
            fraction};
}

} // namespace lumisweep
