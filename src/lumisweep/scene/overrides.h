// Entries that replace a scene file's before it is validated.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "lumisweep/scene/scene_file.h"

namespace lumisweep {

/// Applies the overrides in order. Missing objects on the way are created; unknown keys are left to validation. Throws
/// Error for an impossible list index or a path through something that is neither object nor list.
void apply_overrides(nlohmann::ordered_json& scene, const std::vector<SceneOverride>& overrides);

} // namespace lumisweep
