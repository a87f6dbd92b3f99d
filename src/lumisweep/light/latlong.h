// From a latitude-longitude image to the equal-area octahedral map, without losing or moving light.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lumisweep/image/image.h"
#include "lumisweep/light/environment.h"

namespace lumisweep {

/// What the conversion met.
struct LatLongReport {
    int resolution = 0;                  ///< n of the n × n octahedral map
    std::uint64_t negative_texels = 0;   ///< pixels with a negative channel, which became 0
    std::uint64_t non_finite_texels = 0; ///< pixels with an infinite or NaN channel, which became 0
};

/// What a user should know of it, one line each; `name` is what they call the image.
std::vector<std::string> warnings_of(const LatLongReport& report, const std::string& name);

/// The n of the map for a width × height image: the least power of two with n² ≥ width · height, within [256, 16384].
int octahedral_resolution(int width, int height);

/// Converts an image with channels R, G and B (linear radiance) and multiplies it by `scale`.
///
/// The image covers the sphere: row 0 is +Z, u = 0.5 − φ/2π with φ = atan2(y, x), so that the centre column looks along
/// +X and columns run towards decreasing φ. `rotation_deg` turns the light about +Z, counter-clockwise seen from above:
/// light at azimuth φ of the image arrives from φ + rotation_deg.
///
/// Each texel is the exact mean of the image over it, the image taken as constant over each pixel: solid-angle
/// integrals are kept to float rounding, for a one-pixel sun too. `report` may be nullptr. Throws Error for an empty
/// image, missing channels, a scale that is negative or not finite or makes radiance overflow, a rotation that is not
/// finite, or too little memory.
Environment environment_from_latlong(const Image& latlong_rgb, double scale, double rotation_deg,
                                     LatLongReport* report = nullptr);

} // namespace lumisweep
