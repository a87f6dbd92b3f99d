// Single scattering in a homogeneous box by quadrature: double precision, no random numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include "lumisweep/math/octahedral.h"
#include "lumisweep/math/vec.h"
#include "support/quadrature.h"

namespace lumisweep::test {

/// Distance from p, inside of the box [-half, half], along the unit vector w to the box's surface.
inline double distance_to_box(const Vec3d& half, const Vec3d& p, const Vec3d& w)
{
    double t = 1e300;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = component(w, axis);
        if (d != 0.0)
            t = std::min(t, (std::copysign(component(half, axis), d) - component(p, axis)) / d);
    }
    return t;
}

/// (1/4π) ∫ exp(−σ s(p, ω)) L(ω) dω with s the distance to the box's surface. The sphere is integrated cone by cone
/// over each half of each face, mapped to polar coordinates around the face's foot, so that the integrand is smooth.
inline double mean_light_in_box(const Vec3d& half, double sigma, const Vec3d& p, const GaussLegendre& rule)
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {-1.0, 1.0}) {
            const int b = (axis + 1) % 3, c = (axis + 2) % 3;
            const double h = component(half, axis) - sign * component(p, axis); // distance to the face
            const double corner_b[5] = {-component(half, b) - component(p, b), component(half, b) - component(p, b),
                                        component(half, b) - component(p, b), -component(half, b) - component(p, b),
                                        -component(half, b) - component(p, b)};
            const double corner_c[5] = {-component(half, c) - component(p, c), -component(half, c) - component(p, c),
                                        component(half, c) - component(p, c), component(half, c) - component(p, c),
                                        -component(half, c) - component(p, c)};
            for (int e = 0; e < 4; ++e) { // the triangle of the foot and each edge
                const double phi0 = std::atan2(corner_c[e], corner_b[e]);
                double phi1 = std::atan2(corner_c[e + 1], corner_b[e + 1]);
                if (phi1 < phi0)
                    phi1 += 2.0 * 3.14159265358979323846;
                // The edge at distance `edge` from the foot; its normal points at angle `normal`.
                const double eb = corner_b[e + 1] - corner_b[e], ec = corner_c[e + 1] - corner_c[e];
                const double edge = (corner_b[e] * ec - corner_c[e] * eb) / std::hypot(eb, ec);
                const double normal = std::atan2(-eb, ec);
                sum += rule(phi0, phi1, [&](double phi) {
                    const double radius = edge / std::cos(phi - normal);
                    // dω = d(cos θ) dφ; the distance to the face is h / cos θ.
                    const double lowest = h / std::hypot(h, radius);
                    return rule(lowest, 1.0, [&](double cosine) { return std::exp(-sigma * h / cosine); });
                });
            }
        }
    }
    return sum / (4.0 * 3.14159265358979323846);
}

/// The share of the sphere's mean light that comes through one texel of an n × n octahedral map: by quadrature over the
/// texel.
inline double texel_light_in_box(const Vec3d& half, double sigma, const Vec3d& p, int n, int x, int y,
                                 const GaussLegendre& rule)
{
    const double step = 1.0 / n;
    return rule(x * step, (x + 1) * step, [&](double u) {
        return rule(y * step, (y + 1) * step, [&](double v) {
            return std::exp(-sigma * distance_to_box(half, p, direction_from_oct(UV<double>{u, v})));
        });
    });
}

} // namespace lumisweep::test
