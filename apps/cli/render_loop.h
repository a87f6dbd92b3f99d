// Passes until the stop criterion is met or the user interrupts.
#pragma once

#include <string>

#include "lumisweep/render/session.h"
#include "lumisweep/render/stopping.h"
#include "lumisweep/scene/checkpoint.h"

namespace lumisweep::cli {

struct RenderResult {
    double render_s = 0.0; ///< wall-clock time of the passes, checkpoints included
    bool stopped_by_user = false;
    bool black = false;             ///< stopped waiting for the noise of an image that stays black
    std::string checkpoint_failure; ///< why the last checkpoint could not be written; else empty
};

/// Prepares the session and adds passes to its film until `stop` is met (render/stopping.h) or the user interrupts. At
/// least one pass is in the film afterwards. `checkpoints` may be nullptr; one that cannot be written is warned about
/// and must not cost the image.
RenderResult render_until(Session& session, const StopCriterion& stop, CheckpointWriter* checkpoints);

} // namespace lumisweep::cli
