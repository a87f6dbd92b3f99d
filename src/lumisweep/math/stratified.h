// Stratified random numbers: Owen-scrambled (0,2)-sequences, a point per index. Every aligned run of 2^m indices puts
// one point into each elementary interval of area 2^−m of the unit square, and is uniform over all scrambles, so means
// stay what they are while the variance of smooth integrands falls faster than 1 / n (Owen 1997).
//
// The sequence is that of Sobol' in its first two dimensions; scrambling hashes digits by the digits before them (Laine
// and Karras 2011, with the constants of N. Vegdahl 2021), and indices are shuffled by the same means, so that several
// uses in one path, each with a `set` of its own, do not depend on each other (Burley 2020, "Practical Hash-based Owen
// Scrambling", JCGT 9(4)).
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/random.h"

namespace lumisweep {

namespace detail {

template <class I>
LUMISWEEP_HD I reverse_bits(I x)
{
    x = shift_right<16>(x) | shift_left<16>(x);
    x = (shift_right<8>(x) & I(0x00ff00ff)) | shift_left<8>(x & I(0x00ff00ff));
    x = (shift_right<4>(x) & I(0x0f0f0f0f)) | shift_left<4>(x & I(0x0f0f0f0f));
    x = (shift_right<2>(x) & I(0x33333333)) | shift_left<2>(x & I(0x33333333));
    return (shift_right<1>(x) & I(0x55555555)) | shift_left<1>(x & I(0x55555555));
}

/// Flips every bit by a hash of the bits below it: an Owen scramble of a number whose first digit is bit 0.
template <class I>
LUMISWEEP_HD I scramble_from_bit_0(I x, const I& seed)
{
    x = x ^ wrapping_mul(x, I(0x3d20adea));
    x = wrapping_add(x, seed);
    x = wrapping_mul(x, shift_right<16>(seed) | I(1));
    x = x ^ wrapping_mul(x, I(0x05526c56));
    return x ^ wrapping_mul(x, I(0x53a22864));
}

/// The second dimension of Sobol's sequence, first digit in bit 0: bit r is the sum of the index's bits c with C(c, r)
/// odd, that is with r's bits among c's (Lucas), which five steps add up.
template <class I>
LUMISWEEP_HD I sobol_1_from_bit_0(I index)
{
    index = index ^ (shift_right<1>(index) & I(0x55555555));
    index = index ^ (shift_right<2>(index) & I(0x33333333));
    index = index ^ (shift_right<4>(index) & I(0x0f0f0f0f));
    index = index ^ (shift_right<8>(index) & I(0x00ff00ff));
    return index ^ shift_right<16>(index);
}

/// Shuffles indices so that aligned runs of 2^m stay together.
template <class I>
LUMISWEEP_HD I shuffle_index(const I& index, const I& seed)
{
    return reverse_bits(scramble_from_bit_0(reverse_bits(index), seed));
}

} // namespace detail

/// Point `index` of the sequence that `key` and `set` choose: (a, b) of a scrambled (0,2)-sequence, and c of a
/// scrambled (0,1)-sequence that is independent of it. Each is uniform in [0, 1).
template <class F>
LUMISWEEP_HD Random3<F> stratified3(const RandomKey<F>& key, const int_of<F>& index, int set)
{
    using I = int_of<F>;
    const RandomBits3<I> scramble = random_bits3(key, I(2 * set)), shuffle = random_bits3(key, I(2 * set + 1));
    const I i = detail::shuffle_index(index, shuffle.x), j = detail::shuffle_index(index, shuffle.y);
    const auto number = [](const I& digits, const I& seed) __attribute__((always_inline))
    {
        return uniform_from_bits<F>(detail::reverse_bits(detail::scramble_from_bit_0(digits, seed)));
    };
    return {number(i, scramble.x), number(detail::sobol_1_from_bit_0(i), scramble.y), number(j, scramble.z)};
}

} // namespace lumisweep
