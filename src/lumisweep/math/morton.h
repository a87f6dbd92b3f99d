// Morton (Z) order of octahedral texels: x in the even bits, y in the odd ones, so that the children of node m are 4m …
// 4m+3.
#pragma once

#include "lumisweep/math/lanes.h"

namespace lumisweep {

/// Spreads the low 16 bits of each lane to the even bits.
template <class I>
LUMISWEEP_HD I spread_bits(I x)
{
    x = (x | shift_left<8>(x)) & I(0x00ff00ff);
    x = (x | shift_left<4>(x)) & I(0x0f0f0f0f);
    x = (x | shift_left<2>(x)) & I(0x33333333);
    return (x | shift_left<1>(x)) & I(0x55555555);
}

/// Gathers the even bits of each lane into the low 16 bits.
template <class I>
LUMISWEEP_HD I gather_bits(I x)
{
    x = x & I(0x55555555);
    x = (x | shift_right<1>(x)) & I(0x33333333);
    x = (x | shift_right<2>(x)) & I(0x0f0f0f0f);
    x = (x | shift_right<4>(x)) & I(0x00ff00ff);
    return (x | shift_right<8>(x)) & I(0x0000ffff);
}

template <class I>
LUMISWEEP_HD I morton_encode(const I& x, const I& y)
{
    return spread_bits(x) | shift_left<1>(spread_bits(y));
}

template <class I>
struct TexelXY {
    I x, y;
};

template <class I>
LUMISWEEP_HD TexelXY<I> morton_decode(const I& m)
{
    return {gather_bits(m), gather_bits(shift_right<1>(m))};
}

} // namespace lumisweep
