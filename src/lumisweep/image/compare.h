// How far an image is from a reference.
#pragma once

#include "lumisweep/image/image.h"

namespace lumisweep {

/// Means over all pixels and the channels R, G, B.
struct Comparison {
    double mse = 0.0;    ///< mean (a − b)²
    double relmse = 0.0; ///< mean (a − b)² / (b² + 0.01), b of the reference
    double rmse = 0.0;   ///< √mse
    double psnr = 0.0;   ///< 10 log10(peak² / mse) in dB with the reference's largest value; infinite if mse = 0
    double mean_image = 0.0;
    double mean_reference = 0.0;
};

/// Throws Error if the sizes differ, either is empty or lacks R, G or B, or a value is not finite (the message counts
/// them).
Comparison compare_images(const Image& image, const Image& reference);

} // namespace lumisweep
