// The progress bar: one line on stderr, redrawn, and only when that is a terminal.
#pragma once

#include "lumisweep/render/stopping.h"

namespace lumisweep::cli {

class Progress {
public:
    Progress();
    /// Ends the line.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Whether it is time to draw: a terminal, and a tenth of a second since the last time, or twenty times what that
    /// cost (the noise of a large film takes a while).
    bool due(double elapsed_s) const;
    void draw(const RenderProgress& state);
    /// Seconds that finding out the state and drawing it took.
    void cost(double seconds);

private:
    bool terminal_;
    bool drawn_ = false;
    double last_s_ = -1e300, pause_s_ = 0.1;
};

} // namespace lumisweep::cli
