#include "lumisweep/render/stopping.h"

#include <algorithm>
#include <cmath>

namespace lumisweep {

namespace {

constexpr std::int64_t min_samples_for_noise = 16;
constexpr std::int64_t max_samples_of_black = 256;

} // namespace

bool Stopping::met(double elapsed_s)
{
    if (film_.samples() == 0)
        return false;
    if (const auto* samples = std::get_if<StopSamples>(&stop_))
        return film_.samples() >= samples->samples;
    if (const auto* time = std::get_if<StopTime>(&stop_))
        return passes() > 0 && elapsed_s + elapsed_s / static_cast<double>(passes()) > time->seconds;
    const bool due = film_.samples() >= next_look_ || film_.samples() == max_samples_of_black;
    if (film_.samples() < min_samples_for_noise || !due)
        return false;
    next_look_ = film_.samples() + film_.samples() / 16;
    return black() || film_.noise() <= std::get<StopNoise>(stop_).relative_error;
}

bool Stopping::black() const
{
    return std::holds_alternative<StopNoise>(stop_) && film_.samples() >= max_samples_of_black &&
           !std::isfinite(film_.noise());
}

RenderProgress Stopping::progress(double elapsed_s) const
{
    RenderProgress state{film_.samples(), elapsed_s, 0.0, std::nullopt, film_.noise()};
    const double done = static_cast<double>(passes());
    if (const auto* samples = std::get_if<StopSamples>(&stop_)) {
        const double wanted = static_cast<double>(samples->samples - first_sample_);
        state.fraction = std::min(1.0, done / wanted);
    } else if (const auto* time = std::get_if<StopTime>(&stop_)) {
        state.fraction = std::min(1.0, elapsed_s / time->seconds);
    } else {
        const double ratio = std::get<StopNoise>(stop_).relative_error / state.noise;
        state.fraction = std::isfinite(ratio) ? std::min(1.0, ratio * ratio) : 0.0; // error falls with √samples
    }
    if (state.fraction > 0.0)
        state.remaining_s = elapsed_s * (1.0 - state.fraction) / state.fraction;
    return state;
}

} // namespace lumisweep
