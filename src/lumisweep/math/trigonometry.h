// sin, cos and atan for every lane type, as polynomials where the domain is small enough.
#pragma once

#include "lumisweep/math/lanes.h"

namespace lumisweep {

inline constexpr double pi = 3.14159265358979323846;

template <class F>
struct SinCos {
    F sin, cos;
};

/// sin and cos of x in [−π/4, π/4]; float error below 1e−7 (Taylor series to x^9 and x^8).
template <class F>
LUMISWEEP_HD SinCos<F> sincos_eighth(const F& x)
{
    const F x2 = x * x;
    const F s = fma(fma(fma(fma(F(2.7557319e-6F), x2, F(-1.9841270e-4F)), x2, F(8.3333333e-3F)), x2, F(-1.6666667e-1F)),
                    x2 * x, x);
    const F c =
        fma(fma(fma(fma(F(2.4801587e-5F), x2, F(-1.3888889e-3F)), x2, F(4.1666667e-2F)), x2, F(-0.5F)), x2, F(1.0F));
    return {s, c};
}
inline SinCos<double> sincos_eighth(double x) { return {std::sin(x), std::cos(x)}; }

/// atan of x in [0, 1]; float error below 4e−7. Halves the angle first: atan x = 2 atan(x / (1 + √(1 + x²))), then the
/// series to y^13 for y ≤ tan(π/8).
template <class F>
LUMISWEEP_HD F atan_unit(const F& x)
{
    const F y = x / (F(1.0F) + sqrt(fma(x, x, F(1.0F))));
    const F y2 = y * y;
    F s = fma(F(1.0F / 13.0F), y2, F(-1.0F / 11.0F));
    s = fma(s, y2, F(1.0F / 9.0F));
    s = fma(s, y2, F(-1.0F / 7.0F));
    s = fma(s, y2, F(1.0F / 5.0F));
    s = fma(s, y2, F(-1.0F / 3.0F));
    return F(2.0F) * fma(s * y2, y, y);
}
inline double atan_unit(double x) { return std::atan(x); }

} // namespace lumisweep
