// The benchmarks of the render loop: paths a second, by scene and instruction set.
#pragma once

#include "scenes.h"

namespace lumisweep::bench {

/// Registers "paths/SCENE/isa:NAME/threads:N" for every scene whose data are there and every instruction set that runs
/// here. `quick` takes small volumes and images.
void register_paths(const SceneSources& sources, bool quick);

} // namespace lumisweep::bench
