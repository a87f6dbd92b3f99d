// Counter-based random numbers keyed by (seed, sample, pixel) and counted by dimension: the same path has the same
// numbers on every backend, instruction set and thread count.
//
// The hashes are pcg3d and pcg4d of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering" (JCGT 9(3)): three or
// four 32-bit words in, as many well-mixed words out.
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"

namespace lumisweep {

/// What makes a path's numbers its own.
template <class F>
struct RandomKey {
    int_of<F> k0, k1;
};

/// Three uniform numbers in [0, 1), multiples of 2^−24.
template <class F>
struct Random3 {
    F a, b, c;
};

template <class F>
LUMISWEEP_HD F uniform_from_bits(const int_of<F>& bits)
{
    return to_float(shift_right<8>(bits)) * F(0x1p-24F);
}

namespace detail {

template <class I>
LUMISWEEP_HD I lcg(const I& x)
{
    return wrapping_add(wrapping_mul(x, I(1664525)), I(1013904223));
}
template <class I>
LUMISWEEP_HD I multiply_add(const I& c, const I& a, const I& b)
{
    return wrapping_add(c, wrapping_mul(a, b));
}

} // namespace detail

template <class I>
struct RandomBits3 {
    I x, y, z;
};

/// Three words of event `dimension`.
template <class F>
LUMISWEEP_HD RandomBits3<int_of<F>> random_bits3(const RandomKey<F>& key, const int_of<F>& dimension)
{
    using I = int_of<F>;
    I x = detail::lcg(key.k0), y = detail::lcg(key.k1), z = detail::lcg(dimension);
    x = detail::multiply_add(x, y, z);
    y = detail::multiply_add(y, z, x);
    z = detail::multiply_add(z, x, y);
    x = x ^ shift_right<16>(x);
    y = y ^ shift_right<16>(y);
    z = z ^ shift_right<16>(z);
    x = detail::multiply_add(x, y, z);
    y = detail::multiply_add(y, z, x);
    z = detail::multiply_add(z, x, y);
    return {x, y, z};
}

/// The numbers of event `dimension` of a path.
template <class F>
LUMISWEEP_HD Random3<F> random3(const RandomKey<F>& key, const int_of<F>& dimension)
{
    const RandomBits3<int_of<F>> bits = random_bits3(key, dimension);
    return {uniform_from_bits<F>(bits.x), uniform_from_bits<F>(bits.y), uniform_from_bits<F>(bits.z)};
}

/// The key of a pixel's path in a pass; pass0 and pass1 come from pass_key().
template <class F>
LUMISWEEP_HD RandomKey<F> path_key(const int_of<F>& pixel, std::int32_t pass0, std::int32_t pass1)
{
    using I = int_of<F>;
    I x = detail::lcg(pixel), y = detail::lcg(I(pass0)), z = detail::lcg(I(pass1)), w = I(0x2545f491);
    for (int round = 0; round < 2; ++round) {
        x = detail::multiply_add(x, y, w);
        y = detail::multiply_add(y, z, x);
        z = detail::multiply_add(z, x, y);
        w = detail::multiply_add(w, y, z);
        x = x ^ shift_right<16>(x);
        y = y ^ shift_right<16>(y);
        z = z ^ shift_right<16>(z);
        w = w ^ shift_right<16>(w);
    }
    return {x, w};
}

struct PassKey {
    std::int32_t k0, k1;
};

/// Mixes the seed and the sample's number to the key of a pass: a bijection of 64 bits for a given seed, so no two
/// passes share one (the finaliser of SplitMix64, Steele et al. 2014).
inline PassKey pass_key(std::uint64_t seed, std::uint64_t sample)
{
    const auto mix = [](std::uint64_t x) {
        x += 0x9e3779b97f4a7c15ULL;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
        return x ^ (x >> 31);
    };
    const std::uint64_t k = mix(mix(seed) ^ sample);
    return {static_cast<std::int32_t>(static_cast<std::uint32_t>(k)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(k >> 32))};
}

} // namespace lumisweep
