// From a scene's description to what a session starts with.
#pragma once

#include <string>
#include <vector>

#include "lumisweep/render/session.h"
#include "lumisweep/scene/scene_description.h"
#include "lumisweep/scene/value_statistics.h"
#include "lumisweep/volume/io/load_volume.h"

namespace lumisweep {

struct LoadedScene {
    SessionInput input;
    std::string modality;              ///< of the volume: DICOM's code or empty
    int frames = 1;                    ///< in all of the volume's files together
    std::vector<std::string> notes;    ///< what was chosen where the scene left it open, one line each
    std::vector<std::string> warnings; ///< what the data made necessary, one line each
    double load_s = 0.0;               ///< wall-clock seconds
};

struct LoadedEnvironment {
    Environment environment;
    std::vector<std::string> warnings;
};

LoadedEnvironment load_environment(const EnvironmentDescription& description);

/// Files of the description with globs expanded, as load_volume takes them. Throws Error when nothing matches.
VolumeRequest volume_request(const VolumeDescription& description);

/// Bytes that rendering will take for a volume of this header, before any of it is loaded: the volume while it is read,
/// the visibility and joint grids, the film.
std::uint64_t memory_estimate(const VolumeHeader& header, const SceneDescription& scene);

/// Loads volume and light, chooses transfer function and camera where they are open. Throws Error when the scene has no
/// volume, for unreadable files, and when the memory that the whole render will need is not there.
LoadedScene load_scene(const SceneDescription& scene);

} // namespace lumisweep
