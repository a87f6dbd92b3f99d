// Sweep-space filtering (journal paper, section 8): a box over each slice of cells, separable along the sweep plane's
// axes.
//
// The paper's box is the cell's bounding rectangle, projected along the direction onto the plane, widened by t · tan β
// (equation 10) with t the distance that the rays have come. Here it runs over the cells after the lookup, where it is
// cheapest, on V (not on optical depth), and starts from one cell, without the shear of the projection: that was
// measured worse against V averaged over cell and texel, at every size tried. Bias: none in the image, V only steers
// sampling.
#pragma once

#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {

/// β of equation (10) in radians. The texel's half opening angle at 8 × 8 directions is π/16; half of it measured best
/// against V averaged over cell and texel. Scales with 8 / directions; 0 without filter.
double filter_angle(SweepFilter filter, int directions);

/// Box filter over a slice of `width` × `height` cells of V, of which whole_visibility is 1; sides ≥ 1 in cells (1
/// leaves things as they are). The box has fractional ends; where it leaves the slice it averages what is inside.
/// Within 2/4080 an axis for boxes of up to 15 cells; wider ones sum fewer bits: within 3 to 31 cells, 10 to 255 and
/// 66 to 2047, as what is cut off is rounded.
class SliceFilter {
public:
    SliceFilter(const SweepKernels& kernels, int width, int height);
    /// Uses `slice` as working memory; the result is there or in memory of the filter's own, until the next call.
    const std::uint16_t* apply(std::uint16_t* slice, double box_u, double box_v);

private:
    void along_u(std::uint16_t* slice, double box);
    const std::uint16_t* along_v(std::uint16_t* slice, double box);

    const SweepKernels& kernels_;
    int width_, height_;
    AlignedArray<std::uint16_t> out_, scale_whole_, scale_ends_;
    AlignedArray<std::uint16_t> row_, power_, next_power_, sums_, next_sums_, zeros_;
};

} // namespace lumisweep
