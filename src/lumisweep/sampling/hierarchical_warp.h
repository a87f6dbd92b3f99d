// Hierarchical warping of a uniform point down a quadtree: Clarberg et al. 2005 (the papers' [5]), one quad of siblings
// a step.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {

/// Where a descent stands: a node (Morton index within its level) and the point, uniform within the node, in [0, 1)².
template <class F>
struct Descent {
    int_of<F> node;
    UV<F> uv;
};

/// Weights of the children 4m … 4m+3: bit 0 of the child is x, bit 1 is y.
template <class F>
struct Quad {
    F w00, w10, w01, w11; ///< w<x><y>
};

namespace detail {

/// One axis: takes the lower half with probability low / (low + high), and stretches u over the half taken.
template <class F>
LUMISWEEP_HD mask_of<F> warp_axis(const F& low, const F& high, F& u)
{
    constexpr float below_one = 0x1.fffffep-1F;
    // In units of the weights, which leaves one division. u (low + high) rounds to less than low + high, so a half
    // without weight is never taken.
    const F at = u * (low + high);
    const mask_of<F> upper = !(at < low);
    u = (at - select(upper, low, F(0.0F))) / select(upper, high, low);
    u = min(max(u, F(0.0F)), F(below_one));
    return upper;
}

} // namespace detail

/// Chooses a child with probability proportional to its weight and moves there; the point stays uniform. At least one
/// weight must be positive, and a child of weight zero is never chosen.
template <class F>
LUMISWEEP_HD Descent<F> warp_to_child(const Quad<F>& quad, const Descent<F>& at)
{
    using I = int_of<F>;
    UV<F> uv = at.uv;
    const mask_of<F> y = detail::warp_axis(quad.w00 + quad.w10, quad.w01 + quad.w11, uv.v);
    const mask_of<F> x = detail::warp_axis(select(y, quad.w01, quad.w00), select(y, quad.w11, quad.w10), uv.u);
    const I child = select(x, I(1), I(0)) | select(y, I(2), I(0));
    return {shift_left<2>(at.node) | child, uv};
}

/// The weights of the children of a node; `level` is the array of the children's level.
template <class F>
LUMISWEEP_HD Quad<F> gather_quad(const float* level, const int_of<F>& node)
{
    using I = int_of<F>;
    const I first = shift_left<2>(node);
    return {gather(level, first), gather(level + 1, first), gather(level + 2, first), gather(level + 3, first)};
}

} // namespace lumisweep
