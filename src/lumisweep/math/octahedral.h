// The equal-area octahedral map: Clarberg 2008, "Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD".
// (The papers cite Praun and Hoppe's map, which does not preserve area.)
//
// uv_oct in [0, 1]² ↔ unit direction in world space; the centre is +Z, the corners are −Z, u grows along +X and v along
// +Y. Equal areas: a region of area A in the square covers 4π A sr, so a density per solid angle is the density per
// unit square divided by 4π. Lines of constant z are the squares |u'| + |v'| = const and lines of constant azimuth are
// straight lines through the centre (u' = 2u − 1), mirrored at the diagonals |u'| + |v'| = 1 for z < 0.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/trigonometry.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

template <class F>
struct UV {
    F u, v;
};

template <class F>
LUMISWEEP_HD Vec3<F> direction_from_oct(const UV<F>& uv_oct)
{
    const F u = uv_oct.u * F(2.0F) - F(1.0F);
    const F v = uv_oct.v * F(2.0F) - F(1.0F);
    const F au = abs(u), av = abs(v);
    const F signed_distance = F(1.0F) - (au + av);
    const F r = F(1.0F) - abs(signed_distance);
    // φ − π/4 within the quadrant; at the poles (r = 0) any azimuth will do.
    const F phi = select(r > F(0.0F), (av - au) / max(r, F(1e-30F)), F(0.0F)) * F(pi / 4);
    const SinCos<F> sc = sincos_eighth(phi);
    const F z = copysign(F(1.0F) - r * r, signed_distance);
    const F rho = r * sqrt(F(2.0F) - r * r) * F(0.70710678118654752440);
    // cos(φ' + π/4) = (cos φ' − sin φ')/√2, and the sine likewise.
    return {copysign((sc.cos - sc.sin) * rho, u), copysign((sc.cos + sc.sin) * rho, v), z};
}

template <class F>
LUMISWEEP_HD UV<F> oct_from_direction(const Vec3<F>& w)
{
    const F ax = abs(w.x), ay = abs(w.y), az = abs(w.z);
    // r = √(1 − |z|), from the horizontal part where that cancels.
    const F rho2 = w.x * w.x + w.y * w.y;
    const F r = sqrt(rho2 / (F(1.0F) + az));
    const F large = max(ax, ay), small = min(ax, ay);
    const F a = atan_unit(select(large > F(0.0F), small / max(large, F(1e-30F)), F(0.0F))) * F(2.0 / pi);
    const F quarter = select(ay > ax, F(1.0F) - a, a); // φ / (π/2) in [0, 1]
    F v = quarter * r;
    F u = r - v;
    const F folded_u = F(1.0F) - v;
    const F folded_v = F(1.0F) - u;
    u = select(w.z < F(0.0F), folded_u, u);
    v = select(w.z < F(0.0F), folded_v, v);
    return {(copysign(u, w.x) + F(1.0F)) * F(0.5F), (copysign(v, w.y) + F(1.0F)) * F(0.5F)};
}

/// Brings a point up to one unit outside of the square back to where it lies on the sphere: each edge is glued to
/// itself, mirrored at its middle.
template <class F>
LUMISWEEP_HD UV<F> wrap_oct(const UV<F>& uv_oct)
{
    const auto fold = [](F& across, F& along) {
        const auto outside = (across < F(0.0F)) | (across > F(1.0F));
        across = select(across < F(0.0F), F(0.0F) - across, select(across > F(1.0F), F(2.0F) - across, across));
        along = select(outside, F(1.0F) - along, along);
    };
    F u = uv_oct.u, v = uv_oct.v;
    fold(u, v);
    fold(v, u);
    return {u, v};
}

} // namespace lumisweep
