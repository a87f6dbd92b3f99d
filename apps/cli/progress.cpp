#include "progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace lumisweep::cli {

namespace {

std::string clock_text(double seconds)
{
    const auto s = static_cast<long>(std::min(std::max(seconds, 0.0), 1e7));
    return s >= 3600 ? fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
                     : fmt::format("{}:{:02}", s / 60, s % 60);
}

} // namespace

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress()
{
    if (drawn_)
        std::fputs("\n", stderr);
}

bool Progress::due(double elapsed_s) const { return terminal_ && elapsed_s - last_s_ >= pause_s_; }

void Progress::cost(double seconds) { pause_s_ = std::max(0.1, 20.0 * seconds); }

void Progress::draw(const RenderProgress& state)
{
    constexpr int width = 24;
    const int filled = static_cast<int>(std::clamp(state.fraction, 0.0, 1.0) * width);
    const std::string remaining = state.remaining_s ? clock_text(*state.remaining_s) : "?";
    const std::string noise = std::isfinite(state.noise) ? fmt::format("{:.2f} %", 100.0 * state.noise) : "?";
    fmt::print(stderr, "\r[{:<{}}] {} samples, {} elapsed, {} remaining, noise {} \x1b[K", std::string(filled, '='),
               width, state.samples, clock_text(state.elapsed_s), remaining, noise);
    std::fflush(stderr);
    drawn_ = true;
    last_s_ = state.elapsed_s;
}

} // namespace lumisweep::cli
