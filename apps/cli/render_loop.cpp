#include "render_loop.h"

#include <chrono>

#include <spdlog/spdlog.h>

#include "interrupt.h"
#include "lumisweep/base/error.h"
#include "progress.h"

namespace lumisweep::cli {

namespace {

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
    Stopping stopping(stop, session.film());
    Progress progress;
    RenderResult result;
    const Clock::time_point begin = Clock::now();
    while (!stopping.met(result.render_s)) {
        // A film without a single pass is no image: an interrupt waits for the first.
        if (interrupted() && session.film().samples() > 0) {
            result.stopped_by_user = true;
            break;
        }
        session.render_pass();
        if (checkpoints != nullptr)
            offer(*checkpoints, session.film(), result);
        result.render_s = std::chrono::duration<double>(Clock::now() - begin).count();
        if (progress.due(result.render_s)) {
            progress.draw(stopping.progress(result.render_s));
            progress.cost(std::chrono::duration<double>(Clock::now() - begin).count() - result.render_s);
        }
    }
    session.wait_for_passes();
    result.render_s = std::chrono::duration<double>(Clock::now() - begin).count();
    result.black = stopping.black();
    if (checkpoints != nullptr)
        finish(*checkpoints, session.film(), result);
    return result;
}

} // namespace lumisweep::cli
