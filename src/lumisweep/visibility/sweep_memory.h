// What sweeps take beside the grid that they fill.
#pragma once

#include <cstdint>

#include "lumisweep/math/vec.h"
#include "lumisweep/visibility/settings.h"

namespace lumisweep {

/// Bytes of the classified level in both layouts.
std::uint64_t extinction_bytes(Vec3i volume_size, const VisibilitySettings& settings);

/// Bytes of all threads' working memory, at most.
std::uint64_t sweep_scratch_bytes(Vec3i volume_size, const VisibilitySettings& settings, int threads);

} // namespace lumisweep
