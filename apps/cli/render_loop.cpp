#include "render_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <spdlog/spdlog.h>

#include "interrupt.h"
#include "lumisweep/base/error.h"
#include "progress.h"

namespace lumisweep::cli {

namespace {

constexpr std::int64_t min_samples_for_noise = 16;
constexpr std::int64_t max_samples_of_black = 256;

class Stopping {
public:
    Stopping(const StopCriterion& stop, const Film& film) : stop_(stop), film_(film), first_sample_(film.samples()) {}

    bool met(double elapsed_s, RenderResult& result) const
    {
        if (film_.samples() == 0)
            return false;
        if (const auto* samples = std::get_if<StopSamples>(&stop_))
            return film_.samples() >= samples->samples;
        if (const auto* time = std::get_if<StopTime>(&stop_))
            return passes() > 0 && elapsed_s + elapsed_s / static_cast<double>(passes()) > time->seconds;
        if (film_.samples() < min_samples_for_noise)
            return false;
        const double noise = film_.noise();
        result.black = !std::isfinite(noise) && film_.samples() >= max_samples_of_black;
        return result.black || noise <= std::get<StopNoise>(stop_).relative_error;
    }

    ProgressState progress(double elapsed_s) const
    {
        ProgressState state{film_.samples(), elapsed_s, 0.0, std::nullopt, film_.noise()};
        const double done = static_cast<double>(passes());
        if (const auto* samples = std::get_if<StopSamples>(&stop_)) {
            const double wanted = static_cast<double>(samples->samples - first_sample_);
            state.fraction = done / wanted;
        } else if (const auto* time = std::get_if<StopTime>(&stop_)) {
            state.fraction = elapsed_s / time->seconds;
        } else {
            const double ratio = std::get<StopNoise>(stop_).relative_error / state.noise;
            state.fraction = std::isfinite(ratio) ? std::min(1.0, ratio * ratio) : 0.0; // error falls with √samples
        }
        if (state.fraction > 0.0)
            state.remaining_s = elapsed_s * (1.0 - state.fraction) / state.fraction;
        return state;
    }

private:
    std::int64_t passes() const { return film_.samples() - first_sample_; }

    const StopCriterion& stop_;
    const Film& film_;
    std::int64_t first_sample_;
};

void offer(CheckpointWriter& checkpoints, const Film& film, RenderResult& result)
{
    try {
        checkpoints.offer(film);
    } catch (const Error& error) {
        if (result.checkpoint_failure.empty())
            spdlog::warn("{}; rendering goes on", error.what());
        result.checkpoint_failure = error.what();
    }
}

void finish(CheckpointWriter& checkpoints, const Film& film, RenderResult& result)
{
    try {
        checkpoints.finish(film);
        result.checkpoint_failure.clear();
    } catch (const Error& error) {
        result.checkpoint_failure = error.what();
    }
}

} // namespace

RenderResult render_until(Session& session, const StopCriterion& stop, CheckpointWriter* checkpoints)
{
    using Clock = std::chrono::steady_clock;
    session.prepare();
    const Stopping stopping(stop, session.film());
    Progress progress;
    RenderResult result;
    const Clock::time_point begin = Clock::now();
    while (!stopping.met(result.render_s, result)) {
        // A film without a single pass is no image: an interrupt waits for the first.
        if (interrupted() && session.film().samples() > 0) {
            result.stopped_by_user = true;
            break;
        }
        session.render_pass();
        if (checkpoints != nullptr)
            offer(*checkpoints, session.film(), result);
        result.render_s = std::chrono::duration<double>(Clock::now() - begin).count();
        if (progress.due(result.render_s))
            progress.draw(stopping.progress(result.render_s));
    }
    if (checkpoints != nullptr)
        finish(*checkpoints, session.film(), result);
    return result;
}

} // namespace lumisweep::cli
