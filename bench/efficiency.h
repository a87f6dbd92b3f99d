// Squared error by processor time, and how far single samples stray, of one way to estimate an image.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "estimators.h"

namespace lumisweep::bench {

/// An image that is close to the truth, and how close.
struct Reference {
    int width = 0, height = 0;
    std::vector<float> color;   ///< [pixels][3]
    double own_mse = 0.0;       ///< expected squared error of `color`, mean over pixels and channels
    double mean_error = 0.0;    ///< standard error of the mean luminance over all pixels
    std::vector<float> albedo;  ///< [pixels][3]: mean over samples of the albedo at the first collision, 0 without one
    std::vector<float> covered; ///< [pixels]: the share of samples that collided
};

/// Two renders of samples / 2 from different seeds, on all threads: half of their squared difference tells the error.
Reference make_reference(const SessionInput& input, int samples, std::uint64_t seed);

/// What arrives at the first collisions, of what would without shadows: the mean of the image over the mean of albedo
/// times mean radiance. Environment sampling wastes about the rest.
double visible_light(const Reference& reference, const Environment& light);

struct MeasuredNoise {
    double preparation_s = 0.0; ///< processor time
    double sample_s =
        0.0; ///< of one sample of every pixel: mean over the faster half of a seed's passes, the least of seeds
    std::vector<double> mse;       ///< per count of samples: mean over seeds, the reference's own error subtracted
    std::vector<double> mse_error; ///< its standard error over seeds; 0 for one seed
    /// Of single samples over the reference's pixel, luminance, at pixels that are covered by half at least and no
    /// darker than a twentieth of the mean of those.
    double percentile_9999 = 0.0;
    double kurtosis = 0.0;       ///< fourth moment about the reference by the square of the second; 3 for a normal one
    double bias_in_errors = 0.0; ///< mean luminance against the reference's, in standard errors of the difference
};

/// Renders on one thread, the calling one, and takes errors at the given ascending sample counts. Several of these take
/// turns, a seed each, so that what else the machine does meets all of them alike.
class NoiseMeasurement {
public:
    NoiseMeasurement(const std::function<std::unique_ptr<Estimator>()>& make, const Reference& reference,
                     std::vector<int> sample_counts);
    ~NoiseMeasurement();
    NoiseMeasurement(NoiseMeasurement&&) noexcept;
    NoiseMeasurement& operator=(NoiseMeasurement&&) = delete;

    void render(std::uint64_t seed);
    /// Of all that was rendered, at least one seed.
    MeasuredNoise result() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace lumisweep::bench
