// From linear radiance to something to look at. For display only: nothing is measured on the result.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lumisweep/image/image.h"

namespace lumisweep {

/// 8-bit sRGB pixels, row 0 at the top; alpha is straight (not premultiplied).
struct DisplayImage {
    int width = 0, height = 0;
    int channels = 3;                 ///< 3: RGB, 4: RGBA
    std::vector<std::uint8_t> pixels; ///< [height][width][channels]
};

enum class Background {
    opaque,      ///< radiance includes the environment behind: ignore A
    transparent, ///< nothing behind: R, G, B are premultiplied by A, and the result has alpha unless A = 1 everywhere
};

struct ToneMapSettings {
    std::optional<double> exposure; ///< multiplies radiance; chosen from the image when absent
    Background background = Background::opaque;
};

/// The exposure that tone_map chooses: it brings the log-average luminance, weighted by coverage, to 0.25; black pixels
/// do not count. 1 for an image without light. Throws like tone_map.
double automatic_exposure(const Image& image, Background background);

/// What suits a render. A volume is much darker than the light behind it (single scattering gives back at most a
/// quarter of it): where the background is shown, the exposure is halfway, on a logarithmic scale, between what suits
/// the volume and what suits the whole image. Throws like tone_map.
ToneMapSettings display_settings(const Image& image, Background background);

/// Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images", equation 4: luminance L (after exposure)
/// becomes L (1 + L / w²) / (1 + L), with white w at the 99.9th percentile and at least 1. Colours keep their hue:
/// those that leave the gamut move towards white of the same luminance. Then the sRGB curve. Non-finite values count as
/// 0. Throws Error if R, G or B is missing or of the wrong size, or if the given exposure is not positive.
DisplayImage tone_map(const Image& image, const ToneMapSettings& settings);

} // namespace lumisweep
