// What a scene file says, as plain structs; docs/scene.md is the reference of the format.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "lumisweep/light/sky.h"
#include "lumisweep/render/settings.h"
#include "lumisweep/render/stopping.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

struct VolumeDescription {
    /// One file, a DICOM directory, a glob of a time series' files, or these files in order. Absolute paths.
    std::vector<std::filesystem::path> files;
    int frame = 0; ///< of a time series
};

/// Points in data units, or a preset by name (scene/presets.h).
struct TransferFunctionDescription {
    std::string preset; ///< empty when there are points
    std::vector<TransferPoint> points;
    double extinction_scale = 1.0;
};

/// A latitude-longitude image (absolute path), a constant radiance, or the analytic sky.
struct EnvironmentDescription {
    std::variant<SkySettings, Vec3d, std::filesystem::path> light = SkySettings{};
    double scale = 1.0;
    double rotation_deg = 0.0; ///< about +Z, counter-clockwise seen from above
};

/// What is absent is found by framing the volume (scene/framing.h).
struct CameraDescription {
    std::optional<Vec3d> position, target;
    Vec3d up{0.0, 0.0, 1.0};
    double vertical_fov_deg = 35.0;
    double lens_radius = 0.0;
    std::optional<double> focus_distance; ///< absent: the target's distance
};

struct SceneDescription {
    std::optional<VolumeDescription> volume;
    std::optional<TransferFunctionDescription> transfer_function; ///< absent: a preset is chosen from the data
    EnvironmentDescription environment;
    CameraDescription camera;
    ImageSettings image;
    RenderSettings render;
    StopCriterion stop;
    VisibilitySettings visibility;
};

} // namespace lumisweep
