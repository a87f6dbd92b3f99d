// One medium under one direction strategy: its shadow rays, and what each estimator does with them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "lumisweep/render/session.h"
#include "transmittance.h"

namespace lumisweep::bench {

/// What the roulette's threshold is relative to.
enum class Roulette {
    transmittance, ///< T alone
    against_image, ///< weight · T, relative to the image's mean contribution of a shadow ray
    against_pixel, ///< the same, relative to the pixel's
};

struct EstimatorCase {
    std::string name;
    Transmittance method;
    float threshold;
    Roulette roulette = Roulette::transmittance;
    Control control = Control::smallest;
};

/// All that are compared; the first is the one that the others are held against.
const std::vector<EstimatorCase>& estimator_cases();

struct EstimatorResult {
    double ray_s = 0.0;                ///< CPU seconds per shadow ray
    double cells = 0.0, lookups = 0.0; ///< per ray
    double mean = 0.0;                 ///< of weight · T
    double variance = 0.0;             ///< of T along a ray, mean over rays
    double weighted_variance = 0.0;    ///< of weight · T along a ray
    double image_variance[3] = {};     ///< of a pixel's sample with 1, 2 and 4 shadow rays per collision
    double image_s[3] = {};            ///< CPU seconds per camera ray with all that follows
};

struct StudyResult {
    double camera_s = 0.0;      ///< CPU seconds per camera ray to its first collision
    double direction_s = 0.0;   ///< CPU seconds per shadow ray to choose its direction
    double rays_per_path = 0.0; ///< shadow rays per camera ray, one direction a collision
    double mean_transmittance = 0.0;
    double background_variance = 0.0; ///< of a pixel's sample that no estimator changes: collisions and directions
    std::vector<EstimatorResult> estimators;
};

struct StudySize {
    int image = 160, passes = 8, repetitions = 6;
};

/// Measures all estimators interleaved on this thread. The image's size is the study's.
StudyResult study_transmittance(SessionInput input, const StudySize& size);

} // namespace lumisweep::bench
