// Three-component vectors and affine maps, templates over the lane type.
#pragma once

#include <array>
#include <cmath>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

/// F is float, double, int or a lane type of math/lanes.h.
template <class F>
struct Vec3 {
    F x, y, z;

    LUMISWEEP_HD friend Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    LUMISWEEP_HD friend Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    LUMISWEEP_HD friend Vec3 operator*(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
    LUMISWEEP_HD friend Vec3 operator*(const Vec3& a, const F& s) { return {a.x * s, a.y * s, a.z * s}; }
    LUMISWEEP_HD friend Vec3 operator*(const F& s, const Vec3& a) { return a * s; }
    LUMISWEEP_HD friend bool operator==(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;
using Vec3i = Vec3<int>;

template <class F>
LUMISWEEP_HD F dot(const Vec3<F>& a, const Vec3<F>& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

template <class F>
LUMISWEEP_HD Vec3<F> cross(const Vec3<F>& a, const Vec3<F>& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline double length(const Vec3d& v) { return std::sqrt(dot(v, v)); }
inline Vec3d normalized(const Vec3d& v) { return v * (1.0 / length(v)); }
inline Vec3f to_float(const Vec3d& v)
{
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline Vec3d to_double(const Vec3f& v) { return {v.x, v.y, v.z}; }
template <class F>
LUMISWEEP_HD F& component(Vec3<F>& v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
template <class F>
LUMISWEEP_HD const F& component(const Vec3<F>& v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// p ↦ columns · p + offset.
template <class F>
struct Affine3 {
    std::array<Vec3<F>, 3> column{{{F(1), F(0), F(0)}, {F(0), F(1), F(0)}, {F(0), F(0), F(1)}}};
    Vec3<F> offset{F(0), F(0), F(0)};

    Vec3<F> vector(const Vec3<F>& v) const { return column[0] * v.x + column[1] * v.y + column[2] * v.z; }
    Vec3<F> point(const Vec3<F>& p) const { return vector(p) + offset; }
};

using Affine3d = Affine3<double>;

inline double determinant(const Affine3d& a) { return dot(a.column[0], cross(a.column[1], a.column[2])); }

/// The inverse map; the determinant must not be zero.
inline Affine3d inverse(const Affine3d& a)
{
    const double d = 1.0 / determinant(a);
    const Vec3d r0 = cross(a.column[1], a.column[2]) * d;
    const Vec3d r1 = cross(a.column[2], a.column[0]) * d;
    const Vec3d r2 = cross(a.column[0], a.column[1]) * d;
    Affine3d inv;
    inv.column = {{{r0.x, r1.x, r2.x}, {r0.y, r1.y, r2.y}, {r0.z, r1.z, r2.z}}};
    inv.offset = inv.vector(a.offset) * -1.0;
    return inv;
}

} // namespace lumisweep
