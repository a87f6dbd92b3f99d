#include "lumisweep/scene/load_scene.h"

#include <chrono>
#include <cmath>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/image/hdr.h"
#include "lumisweep/light/latlong.h"
#include "lumisweep/math/trigonometry.h"
#include "lumisweep/scene/framing.h"
#include "lumisweep/scene/presets.h"
#include "lumisweep/scene/scene_file.h"
#include "lumisweep/volume/io/expand_files.h"

namespace lumisweep {

namespace {

namespace fs = std::filesystem;

SkySettings scaled_and_turned(SkySettings sky, double scale, double rotation_deg)
{
    for (Vec3d* radiance : {&sky.zenith, &sky.horizon, &sky.ground, &sky.sun_irradiance})
        *radiance = *radiance * scale;
    const double angle = rotation_deg * pi / 180.0;
    const Vec3d sun = sky.sun_direction;
    sky.sun_direction = {sun.x * std::cos(angle) - sun.y * std::sin(angle),
                         sun.x * std::sin(angle) + sun.y * std::cos(angle), sun.z};
    return sky;
}

TransferFunction transfer_function_for(const std::optional<TransferFunctionDescription>& description,
                                       const PresetInput& input, std::vector<std::string>& notes)
{
    if (description && description->preset.empty())
        return TransferFunction(description->points, description->extinction_scale);
    if (description)
        return TransferFunction(preset_points(description->preset, input), description->extinction_scale);
    const PresetChoice choice = choose_preset(input);
    notes.push_back(choice.reason);
    return TransferFunction(preset_points(choice.name, input));
}

void note_camera(const SceneDescription& scene, const Camera& camera, std::vector<std::string>& notes)
{
    if (!scene.camera.position)
        notes.push_back(fmt::format("no camera position given: framed the volume from [{:.6g}, {:.6g}, {:.6g}] towards "
                                    "[{:.6g}, {:.6g}, {:.6g}]",
                                    camera.position.x, camera.position.y, camera.position.z, camera.target.x,
                                    camera.target.y, camera.target.z));
}

} // namespace

LoadedEnvironment load_environment(const EnvironmentDescription& description)
{
    const double scale = description.scale;
    if (const auto* radiance = std::get_if<Vec3d>(&description.light))
        return {Environment::constant(*radiance * scale), {}};
    if (const auto* sky = std::get_if<SkySettings>(&description.light))
        return {environment_from_sky(scaled_and_turned(*sky, scale, description.rotation_deg)), {}};
    const fs::path& file = std::get<fs::path>(description.light);
    LatLongReport report;
    Environment environment = environment_from_latlong(load_latlong(file), scale, description.rotation_deg, &report);
    return {std::move(environment), warnings_of(report, file.string())};
}

VolumeRequest volume_request(const VolumeDescription& description)
{
    VolumeRequest request;
    request.frame = description.frame;
    for (const fs::path& file : description.files) {
        std::error_code ignored;
        if (fs::exists(file, ignored) || file.string().find_first_of("*?[") == std::string::npos) {
            request.files.push_back(file);
            continue;
        }
        const std::vector<fs::path> matches = expand_files(file.string());
        request.files.insert(request.files.end(), matches.begin(), matches.end());
    }
    return request;
}

std::uint64_t memory_estimate(const VolumeHeader& header, const SceneDescription& scene)
{
    return header.bytes_needed +
           Session::memory_needed(header.size, scene.image, scene.render.strategy, scene.visibility);
}

LoadedScene load_scene(const SceneDescription& scene)
{
    require(scene.volume.has_value(),
            "volume: missing (add \"volume\": {{\"file\": ...}} to the scene, or give --volume FILE)");
    require_files(scene);
    const auto begin = std::chrono::steady_clock::now();
    LoadedScene loaded;
    const VolumeRequest request = volume_request(*scene.volume);
    const VolumeHeader header = inspect_volume(request.files.front());
    require_memory(memory_estimate(header, scene), request.files.front().string() + ": rendering",
                   "take a smaller volume or image, a larger visibility.cell, or --strategy environment");

    LoadedEnvironment light = load_environment(scene.environment);
    loaded.warnings = std::move(light.warnings);
    SessionInput& input = loaded.input;
    input.environment = std::make_shared<const Environment>(std::move(light.environment));
    input.image = scene.image;
    input.render = scene.render;
    input.visibility = scene.visibility;

    LoadedVolume volume = load_volume(request);
    loaded.modality = volume.modality;
    loaded.frames = volume.frames;
    loaded.warnings.insert(loaded.warnings.end(), volume.warnings.begin(), volume.warnings.end());
    const PresetInput values = preset_input(volume.grid, value_statistics(volume.grid), volume.modality, volume.frames);
    input.transfer_function = transfer_function_for(scene.transfer_function, values, loaded.notes);
    VoxelBox box{{0, 0, 0}, {0, 0, 0}};
    if (!scene.camera.position || !scene.camera.target)
        box = visible_box(volume.grid, input.transfer_function, values.values);
    input.camera = frame_camera(scene.camera, volume.grid, box, scene.image);
    input.camera.validate();
    note_camera(scene, input.camera, loaded.notes);
    input.volume = std::make_shared<const ScalarGrid>(std::move(volume.grid));
    loaded.load_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return loaded;
}

} // namespace lumisweep
