// The vocabulary of lane-generic code: what a stage may do with a lane type F.
//
// Stages are templates over F. F = float is the scalar reference and each CUDA thread; lanes_avx2.h and lanes_avx512.h
// add Lanes<float> types of 8 and 16 lanes with the same functions. Associated types: mask_of<F>, int_of<F> (32-bit,
// wraps on overflow). Above this header code reads like scalar code. F = double has what the oracles need of it.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

template <class F>
struct LaneTraits;

template <>
struct LaneTraits<float> {
    using Int = std::int32_t;
    using Mask = bool;
    static constexpr int width = 1;
};
template <>
struct LaneTraits<double> {
    using Int = std::int32_t;
    using Mask = bool;
    static constexpr int width = 1;
};

template <class F>
using int_of = typename LaneTraits<F>::Int;
template <class F>
using mask_of = typename LaneTraits<F>::Mask;
template <class F>
inline constexpr int lane_width = LaneTraits<F>::width;

// ---- selection and masks --------------------------------------------------------------------------------------------
LUMISWEEP_HD float select(bool m, float a, float b) { return m ? a : b; }
LUMISWEEP_HD double select(bool m, double a, double b) { return m ? a : b; }
LUMISWEEP_HD std::int32_t select(bool m, std::int32_t a, std::int32_t b) { return m ? a : b; }
LUMISWEEP_HD bool any(bool m) { return m; }
LUMISWEEP_HD bool all(bool m) { return m; }
LUMISWEEP_HD int count(bool m) { return m ? 1 : 0; }
/// Bit i set: lane i is on.
LUMISWEEP_HD std::uint32_t bits(bool m) { return m ? 1U : 0U; }
/// The mask of the first n lanes.
template <class F>
LUMISWEEP_HD mask_of<F> first_lanes(int n);
template <>
LUMISWEEP_HD bool first_lanes<float>(int n)
{
    return n > 0;
}

// ---- arithmetic -----------------------------------------------------------------------------------------------------
LUMISWEEP_HD float min(float a, float b) { return b < a ? b : a; }
LUMISWEEP_HD float max(float a, float b) { return a < b ? b : a; }
LUMISWEEP_HD double min(double a, double b) { return b < a ? b : a; }
LUMISWEEP_HD double max(double a, double b) { return a < b ? b : a; }
LUMISWEEP_HD std::int32_t min(std::int32_t a, std::int32_t b) { return b < a ? b : a; }
LUMISWEEP_HD std::int32_t max(std::int32_t a, std::int32_t b) { return a < b ? b : a; }
LUMISWEEP_HD float abs(float a) { return std::fabs(a); }
LUMISWEEP_HD double abs(double a) { return std::fabs(a); }
/// 1 / a of a normal number whose reciprocal is normal, within 2 ulp.
LUMISWEEP_HD float reciprocal(float a)
{
#if defined(__CUDA_ARCH__)
    return __fdividef(1.0F, a);
#else
    return 1.0F / a;
#endif
}
LUMISWEEP_HD float sqrt(float a) { return std::sqrt(a); }
LUMISWEEP_HD double sqrt(double a) { return std::sqrt(a); }
LUMISWEEP_HD float floor(float a) { return std::floor(a); }
LUMISWEEP_HD double floor(double a) { return std::floor(a); }
LUMISWEEP_HD float copysign(float magnitude, float sign) { return std::copysign(magnitude, sign); }
LUMISWEEP_HD double copysign(double magnitude, double sign) { return std::copysign(magnitude, sign); }
/// a · b + c; fused where the lane type's machine fuses (so results differ between lane types by rounding only).
LUMISWEEP_HD float fma(float a, float b, float c)
{
#if defined(__CUDA_ARCH__)
    return __fmaf_rn(a, b, c);
#else
    return a * b + c;
#endif
}
LUMISWEEP_HD double fma(double a, double b, double c) { return a * b + c; }
/// Natural logarithm of a normal, positive number.
LUMISWEEP_HD float log(float a) { return std::log(a); }
/// e^a for a ≤ 88; below −87 whatever is less than 2e-38.
LUMISWEEP_HD float exp(float a) { return std::exp(a); }

// ---- integers and conversions ---------------------------------------------------------------------------------------
LUMISWEEP_HD std::int32_t to_int(float a) { return static_cast<std::int32_t>(a); } ///< truncates; must fit
LUMISWEEP_HD std::int32_t to_int(double a) { return static_cast<std::int32_t>(a); }
LUMISWEEP_HD float to_float(std::int32_t a) { return static_cast<float>(a); }
LUMISWEEP_HD std::int32_t wrapping_mul(std::int32_t a, std::int32_t b)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(b));
}
LUMISWEEP_HD std::int32_t wrapping_add(std::int32_t a, std::int32_t b)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}
template <int Shift>
LUMISWEEP_HD std::int32_t shift_left(std::int32_t a)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) << Shift);
}
/// Logical (zeros enter at the top).
template <int Shift>
LUMISWEEP_HD std::int32_t shift_right(std::int32_t a)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) >> Shift);
}
/// By the same number of bits in all lanes, 0 to 31.
LUMISWEEP_HD std::int32_t shift_left(std::int32_t a, int by)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) << by);
}
LUMISWEEP_HD std::int32_t shift_right(std::int32_t a, int by)
{
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) >> by);
}

LUMISWEEP_HD std::int32_t as_int(float a) { return __builtin_bit_cast(std::int32_t, a); }
LUMISWEEP_HD float as_float(std::int32_t a) { return __builtin_bit_cast(float, a); }

/// log for lane types without one: a = 2^e · m with m in [√½, √2), then the polynomial of Cephes' logf (S. Moshier) in
/// m − 1; error below 2 ulp for normal, positive numbers.
template <class F>
LUMISWEEP_HD F log_polynomial(const F& a)
{
    using I = int_of<F>;
    // Adding the offset moves the cut between exponents to √½.
    const I shifted = as_int(a) + I(0x3f800000 - 0x3f3504f3);
    const F e = to_float(shift_right<23>(shifted) - I(127));
    const F m = as_float((shifted & I(0x007fffff)) + I(0x3f3504f3)) - F(1.0F);
    F y = F(7.0376836292e-2F);
    y = fma(y, m, F(-1.1514610310e-1F));
    y = fma(y, m, F(1.1676998740e-1F));
    y = fma(y, m, F(-1.2420140846e-1F));
    y = fma(y, m, F(1.4249322787e-1F));
    y = fma(y, m, F(-1.6668057665e-1F));
    y = fma(y, m, F(2.0000714765e-1F));
    y = fma(y, m, F(-2.4999993993e-1F));
    y = fma(y, m, F(3.3333331174e-1F));
    const F m2 = m * m;
    y = y * m * m2;
    y = fma(e, F(-2.12194440e-4F), y);
    y = fma(m2, F(-0.5F), y);
    return fma(e, F(0.693359375F), m + y);
}

/// exp for lane types without one: a = n · ln 2 + r with |r| ≤ ½ ln 2, then the polynomial of Cephes' expf (S. Moshier)
/// in r; error below 2 ulp.
template <class F>
LUMISWEEP_HD F exp_polynomial(const F& a)
{
    using I = int_of<F>;
    const F x = max(a, F(-87.0F));
    const F n = floor(fma(x, F(1.44269504F), F(0.5F)));
    const F r = fma(n, F(2.12194440e-4F), fma(n, F(-0.693359375F), x));
    F y = F(1.9875691500e-4F);
    y = fma(y, r, F(1.3981999507e-3F));
    y = fma(y, r, F(8.3334519073e-3F));
    y = fma(y, r, F(4.1665795894e-2F));
    y = fma(y, r, F(1.6666665459e-1F));
    y = fma(y, r, F(5.0000001201e-1F));
    return fma(y * r, r, r + F(1.0F)) * as_float(shift_left<23>(to_int(n) + I(127)));
}

// ---- memory ---------------------------------------------------------------------------------------------------------
template <class F>
LUMISWEEP_HD F load(const float* p);
template <>
LUMISWEEP_HD float load<float>(const float* p)
{
    return *p;
}
template <class F>
LUMISWEEP_HD int_of<F> load(const std::int32_t* p);
template <>
LUMISWEEP_HD std::int32_t load<float>(const std::int32_t* p)
{
    return *p;
}
LUMISWEEP_HD void store(float* p, float a) { *p = a; }
LUMISWEEP_HD void store(std::int32_t* p, std::int32_t a) { *p = a; }
/// Stores the lanes that are on, packed; may write garbage over the rest of a full vector behind them.
LUMISWEEP_HD void compress_store(float* p, bool m, float a)
{
    if (m)
        *p = a;
}
LUMISWEEP_HD void compress_store(std::int32_t* p, bool m, std::int32_t a)
{
    if (m)
        *p = a;
}
LUMISWEEP_HD float gather(const float* base, std::int32_t index) { return base[index]; }
LUMISWEEP_HD std::int32_t gather(const std::int32_t* base, std::int32_t index) { return base[index]; }
/// Reads up to 3 bytes past base[index].
LUMISWEEP_HD std::int32_t gather(const std::uint8_t* base, std::int32_t index) { return base[index]; }

/// Entries of a table that gather_small() can hold in registers.
inline constexpr int small_table = 16;
/// base[index] of a table of small_table entries.
LUMISWEEP_HD float gather_small(const float* base, std::int32_t index) { return base[index]; }

/// Two neighbours along x, base[index] and base[index + 1], as floats. Reads at most 4 bytes past base[index + 1].
template <class F>
struct Pair {
    F first, second;
};
template <class Voxel>
LUMISWEEP_HD Pair<float> gather_pair(const Voxel* base, std::int32_t index)
{
    return {static_cast<float>(base[index]), static_cast<float>(base[index + 1])};
}

} // namespace lumisweep
