// What tests ask of an environment.
#pragma once

#include "lumisweep/light/environment.h"
#include "lumisweep/math/trigonometry.h"

namespace lumisweep::test {

/// Radiance of texel i in Morton order.
inline Vec3d texel(const Environment& environment, int i)
{
    const float* rgb = environment.view().radiance + 3 * static_cast<std::size_t>(i);
    return {rgb[0], rgb[1], rgb[2]};
}

/// ∫ L dω.
inline Vec3d flux(const Environment& environment)
{
    const int n = environment.resolution();
    Vec3d sum{0, 0, 0};
    for (int i = 0; i < n * n; ++i)
        sum = sum + texel(environment, i);
    return sum * (4.0 * pi / n / n);
}

} // namespace lumisweep::test
