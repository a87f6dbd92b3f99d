// The progress bar: one line on stderr, redrawn, and only when that is a terminal.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace lumisweep::cli {

struct ProgressState {
    std::int64_t samples = 0;
    double elapsed_s = 0.0;
    double fraction = 0.0;             ///< of the whole render, in [0, 1]
    std::optional<double> remaining_s; ///< absent while it cannot be told
    double noise = 0.0;                ///< estimated relative error
};

class Progress {
public:
    Progress();
    /// Ends the line.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Whether it is time to draw: a terminal, and a tenth of a second since the last time.
    bool due(double elapsed_s) const;
    void draw(const ProgressState& state);

private:
    bool terminal_;
    bool drawn_ = false;
    double last_s_ = -1e300;
};

} // namespace lumisweep::cli
