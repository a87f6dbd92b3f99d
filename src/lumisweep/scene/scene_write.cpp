// SceneDescription → JSON, with every default written out.
#include "lumisweep/scene/scene_sections.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;

ordered_json json_of(const Vec3d& v) { return ordered_json::array({v.x, v.y, v.z}); }

ordered_json json_of(const VolumeDescription& volume)
{
    ordered_json json = ordered_json::object();
    if (volume.files.size() == 1) {
        const std::string file = volume.files[0].string();
        json[file.find_first_of("*?[") == std::string::npos ? "file" : "files"] = file;
    } else {
        json["files"] = ordered_json::array();
        for (const std::filesystem::path& file : volume.files)
            json["files"].push_back(file.string());
    }
    json["frame"] = volume.frame;
    return json;
}

ordered_json json_of(const EnvironmentDescription& environment)
{
    ordered_json json = ordered_json::object();
    if (const auto* file = std::get_if<std::filesystem::path>(&environment.light)) {
        json["file"] = file->string();
    } else if (const auto* radiance = std::get_if<Vec3d>(&environment.light)) {
        json["radiance"] = json_of(*radiance);
    } else {
        const SkySettings& sky = std::get<SkySettings>(environment.light);
        json["sky"] = {{"zenith", json_of(sky.zenith)},
                       {"horizon", json_of(sky.horizon)},
                       {"ground", json_of(sky.ground)},
                       {"sun_direction", json_of(sky.sun_direction)},
                       {"sun_angular_diameter_deg", sky.sun_angular_diameter_deg},
                       {"sun_irradiance", json_of(sky.sun_irradiance)}};
    }
    json["scale"] = environment.scale;
    json["rotation_deg"] = environment.rotation_deg;
    return json;
}

ordered_json json_of(const CameraDescription& camera)
{
    ordered_json json = ordered_json::object();
    if (camera.position)
        json["position"] = json_of(*camera.position);
    if (camera.target)
        json["target"] = json_of(*camera.target);
    json["up"] = json_of(camera.up);
    json["vertical_fov_deg"] = camera.vertical_fov_deg;
    json["lens_radius"] = camera.lens_radius;
    if (camera.focus_distance)
        json["focus_distance"] = *camera.focus_distance;
    return json;
}

ordered_json number_or_auto(int number) { return number == 0 ? ordered_json("auto") : ordered_json(number); }

ordered_json json_of(const RenderSettings& render, const StopCriterion& stop)
{
    ordered_json json = ordered_json::object();
    json["strategy"] = std::string(strategy_names[static_cast<std::size_t>(render.strategy)]);
    if (const auto* samples = std::get_if<StopSamples>(&stop))
        json["samples"] = samples->samples;
    else if (const auto* time = std::get_if<StopTime>(&stop))
        json["time"] = time->seconds;
    else
        json["noise"] = std::get<StopNoise>(stop).relative_error;
    json["seed"] = render.seed;
    json["random_numbers"] = std::string(random_numbers_names[static_cast<std::size_t>(render.random_numbers)]);
    json["shadow_rays"] = number_or_auto(render.shadow_rays);
    return json;
}

} // namespace

ordered_json json_of(const TransferFunctionDescription& transfer_function)
{
    ordered_json json = ordered_json::object();
    if (!transfer_function.preset.empty()) {
        json["preset"] = transfer_function.preset;
    } else {
        json["points"] = ordered_json::array();
        for (const TransferPoint& point : transfer_function.points)
            json["points"].push_back(
                {{"value", point.value}, {"extinction", point.extinction}, {"albedo", json_of(point.albedo)}});
    }
    json["extinction_scale"] = transfer_function.extinction_scale;
    return json;
}

ordered_json json_of(const SceneDescription& scene)
{
    ordered_json json = ordered_json::object();
    json["version"] = 1;
    if (scene.volume)
        json["volume"] = json_of(*scene.volume);
    if (scene.transfer_function)
        json["transfer_function"] = json_of(*scene.transfer_function);
    json["environment"] = json_of(scene.environment);
    json["camera"] = json_of(scene.camera);
    json["image"] = {{"width", scene.image.width},
                     {"height", scene.image.height},
                     {"show_environment", scene.image.show_environment}};
    json["render"] = json_of(scene.render, scene.stop);
    const VisibilitySettings& visibility = scene.visibility;
    json["visibility"] = {{"directions", visibility.directions},
                          {"cell", visibility.cell},
                          {"rays", number_or_auto(visibility.rays)},
                          {"filter", std::string(filter_names[static_cast<std::size_t>(visibility.filter)])},
                          {"oversampling", visibility.oversampling},
                          {"epsilon", visibility.epsilon}};
    return json;
}

} // namespace lumisweep
