// When a render ends: after so many samples, so long, or at a noise level.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "lumisweep/render/film.h"

namespace lumisweep {

struct StopSamples {
    std::int64_t samples = 64; ///< a pixel, in the film
};
struct StopTime {
    double seconds; ///< wall-clock, of the passes
};
struct StopNoise {
    double relative_error; ///< of the image, as Film::noise() estimates it
};
using StopCriterion = std::variant<StopSamples, StopTime, StopNoise>;

struct RenderProgress {
    std::int64_t samples = 0;
    double elapsed_s = 0.0;
    double fraction = 0.0;             ///< of the whole render, in [0, 1]
    std::optional<double> remaining_s; ///< absent while it cannot be told
    double noise = 0.0;                ///< estimated relative error
};

/// Judges a film that grows by whole passes. Samples: until the film has that many. Time: ends before a pass that would
/// end too late, by the mean duration so far. Noise: from 16 samples on, below which the estimate cannot be trusted; an
/// image that stays black has no relative error and ends after 256. As it falls with the root of the samples and
/// looking at it takes as long as a pass, it is looked at again whenever there are a sixteenth more of them. An empty
/// film is never enough.
class Stopping {
public:
    /// `film` must outlive this; what it holds already does not count as this render's passes.
    Stopping(const StopCriterion& stop, const Film& film) : stop_(stop), film_(film), first_sample_(film.samples()) {}

    /// Whether to end, after `elapsed_s` seconds of passes.
    bool met(double elapsed_s);
    /// Ended waiting for the noise of an image that stays black.
    bool black() const;
    RenderProgress progress(double elapsed_s) const;

private:
    std::int64_t passes() const { return film_.samples() - first_sample_; }

    StopCriterion stop_;
    const Film& film_;
    std::int64_t first_sample_;
    std::int64_t next_look_ = 0; // at the noise, in samples
};

} // namespace lumisweep
