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
#include <vector>

#include "lumisweep/visibility/settings.h"

namespace lumisweep {

/// β of equation (10) in radians. The texel's half opening angle at 8 × 8 directions is π/16; half of it measured best
/// against V averaged over cell and texel. Scales with 8 / directions; 0 without filter.
double filter_angle(SweepFilter filter, int directions);

/// Box filter over a slice of `width` × `height` cells in place, widths ≥ 1 in cells (1 leaves things as they are). The
/// box has fractional ends; where it leaves the slice it averages what is inside. Runs in exact integer sums.
class SliceFilter {
public:
    SliceFilter(int width, int height);
    void apply(std::int32_t* slice, double box_u, double box_v);

private:
    void along_u(std::int32_t* slice, double box);
    void along_v(std::int32_t* slice, double box);

    int width_, height_;
    std::vector<std::int32_t> row_, sums_, out_;
    std::vector<float> inverse_;
};

} // namespace lumisweep
