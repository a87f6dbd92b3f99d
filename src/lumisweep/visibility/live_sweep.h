// Classification and sweeps beside rendering, group by group into a live grid.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "lumisweep/visibility/live_visibility.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

struct LiveSweepInput {
    std::shared_ptr<const ScalarGrid> volume;
    RawRange range; ///< of the volume
    TransferFunction transfer_function;
    VisibilitySettings visibility;
    std::vector<int> directions; ///< Morton indices; all when there are none
    int threads = 1;             ///< in a task arena of its own
};

struct LiveSweepStats {
    double classify_s = 0.0, sweep_s = 0.0; ///< elapsed
    SweepStats sweep;                       ///< of all groups together
};

/// Classifies the volume, then sweeps the directions of `grid`, which must be of the input's shape, and publishes each
/// group when it is done. When it has returned true these are what sweep_visibility() gives, to the bit. False, and
/// what is published stays so, when `cancel` became true.
bool sweep_live(LiveVisibility& grid, const LiveSweepInput& input, const std::atomic<bool>& cancel,
                LiveSweepStats& stats);

} // namespace lumisweep
