// An analytic sky: a vertical gradient, ground, and a sun of given size and power. Light without any file.
#pragma once

#include "lumisweep/light/environment.h"

namespace lumisweep {

/// Radiance is RGB, linear, in the renderer's radiance unit. The defaults are a clear late morning with the sun at 45°
/// in front and to the left of a viewer who looks along +Y.
struct SkySettings {
    Vec3d zenith{0.30, 0.48, 0.85};           ///< radiance from straight above
    Vec3d horizon{1.00, 0.95, 0.86};          ///< radiance at the horizon; falls to the zenith's with (1 − z)³
    Vec3d ground{0.24, 0.21, 0.18};           ///< radiance from everywhere below
    Vec3d sun_direction{-0.5, -0.5, 0.70711}; ///< towards the sun; any length but zero
    double sun_angular_diameter_deg = 1.0;    ///< in [0.001, 180]; the real one has 0.53
    Vec3d sun_irradiance{5.0, 4.4, 3.6};      ///< on a surface that faces it, so the power does not depend on the size

    /// Throws Error that names the first setting that makes no sense.
    void validate() const;
};

/// The sky at n × n texels, n a power of two in [8, 16384]. Every texel is the mean of the gradient over it. The sun is
/// a disc of uniform radiance, anti-aliased such that ∫ L_sun dω is its radiance times its solid angle to float
/// rounding, whether it covers a hundred thousand texels or a part of one.
Environment environment_from_sky(const SkySettings& settings, int n = 512);

} // namespace lumisweep
