// The sections of a scene file, one reader each.
#pragma once

#include <filesystem>

#include "lumisweep/scene/json_reader.h"
#include "lumisweep/scene/scene_description.h"

namespace lumisweep {

VolumeDescription read_volume(const nlohmann::ordered_json& value, const JsonPlace& place,
                              const std::filesystem::path& base_directory);
TransferFunctionDescription read_transfer_function(const nlohmann::ordered_json& value, const JsonPlace& place);
EnvironmentDescription read_environment(const nlohmann::ordered_json& value, const JsonPlace& place,
                                        const std::filesystem::path& base_directory);
SkySettings read_sky(const nlohmann::ordered_json& value, const JsonPlace& place);
CameraDescription read_camera(const nlohmann::ordered_json& value, const JsonPlace& place);
ImageSettings read_image(const nlohmann::ordered_json& value, const JsonPlace& place);
void read_render(const nlohmann::ordered_json& value, const JsonPlace& place, RenderSettings& render,
                 StopCriterion& stop);
VisibilitySettings read_visibility(const nlohmann::ordered_json& value, const JsonPlace& place);

nlohmann::ordered_json json_of(const TransferFunctionDescription& transfer_function);
nlohmann::ordered_json json_of(const SceneDescription& scene);

} // namespace lumisweep
