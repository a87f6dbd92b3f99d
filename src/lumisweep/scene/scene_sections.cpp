#include "lumisweep/scene/scene_sections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/json_text.h"
#include "lumisweep/scene/presets.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;

// Wide enough for any unit, narrow enough that float arithmetic in the kernels stays finite.
constexpr NumberRange coordinate{-1e9, 1e9};
constexpr NumberRange data_value{-1e30, 1e30};
constexpr NumberRange extinction_range{0.0, 1e9};
constexpr NumberRange unit_range{0.0, 1.0};
constexpr NumberRange radiance_range{0.0, 1e12};
constexpr NumberRange positive{0.0, 1e9, Ends::open_low};
constexpr std::size_t max_points = 4096;

std::filesystem::path resolve(const ordered_json& value, const JsonPlace& place,
                              const std::filesystem::path& base_directory)
{
    const std::string& text = read_string(value, place);
    require(!text.empty(), "{}: is empty (give a path)", place.text());
    require(text.size() <= 4096 && text.find('\0') == std::string::npos, "{}: no path can be like that", place.text());
    return (base_directory / text).lexically_normal();
}

TransferPoint read_point(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(value, place, {"value", "extinction", "albedo"});
    TransferPoint point;
    point.value = read_number(reader.required("value"), reader.place("value"), data_value);
    point.extinction = read_number(reader.required("extinction"), reader.place("extinction"), extinction_range);
    reader.vector("albedo", point.albedo, unit_range);
    return point;
}

std::vector<TransferPoint> read_points(const ordered_json& value, const JsonPlace& place)
{
    require(value.is_array() && !value.empty(),
            "{}: must be a list of at least one point {{\"value\": ..., \"extinction\": ...}}", place.text());
    require(value.size() <= max_points, "{}: has {} points (give at most {})", place.text(), value.size(), max_points);
    std::vector<TransferPoint> points;
    for (std::size_t i = 0; i < value.size(); ++i) {
        points.push_back(read_point(value[i], place.at(i)));
        require(i == 0 || points[i].value >= points[i - 1].value,
                "{}: {} is below the point before it, {} (sort the points by value)", place.at(i).at("value").text(),
                points[i].value, points[i == 0 ? 0 : i - 1].value);
    }
    return points;
}

/// From 1 to `most`; "auto" is 0.
void read_whole_or_auto(const ObjectReader& reader, const char* key, int& number, int most)
{
    const ordered_json* value = reader.find(key);
    if (value == nullptr)
        return;
    number = 0;
    if (*value == "auto")
        return;
    require(value->is_number(), "{}: must be \"auto\" or a whole number", reader.place(key).text());
    number = static_cast<int>(read_whole(*value, reader.place(key), 1, static_cast<std::uint64_t>(most)));
}

} // namespace

VolumeDescription read_volume(const ordered_json& value, const JsonPlace& place,
                              const std::filesystem::path& base_directory)
{
    const ObjectReader reader(value, place, {"file", "files", "frame"});
    reader.at_most_one({"file", "files"});
    VolumeDescription volume;
    if (const ordered_json* files = reader.find("files"); files != nullptr && files->is_array()) {
        require(!files->empty(), "{}: is empty (give a glob or a list of files)", reader.place("files").text());
        for (std::size_t i = 0; i < files->size(); ++i)
            volume.files.push_back(resolve((*files)[i], reader.place("files").at(i), base_directory));
    } else if (files != nullptr) {
        volume.files.push_back(resolve(*files, reader.place("files"), base_directory));
    } else {
        volume.files.push_back(resolve(reader.required("file"), reader.place("file"), base_directory));
    }
    reader.whole("frame", volume.frame, 0, std::numeric_limits<int>::max());
    return volume;
}

TransferFunctionDescription read_transfer_function(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(value, place, {"points", "preset", "extinction_scale"});
    reader.at_most_one({"points", "preset"});
    TransferFunctionDescription transfer_function;
    if (const auto preset = reader.choice("preset", preset_names()))
        transfer_function.preset = preset_names()[*preset];
    else
        transfer_function.points = read_points(reader.required("points"), reader.place("points"));
    reader.number("extinction_scale", transfer_function.extinction_scale, extinction_range);
    return transfer_function;
}

EnvironmentDescription read_environment(const ordered_json& value, const JsonPlace& place,
                                        const std::filesystem::path& base_directory)
{
    const ObjectReader reader(value, place, {"file", "radiance", "sky", "scale", "rotation_deg"});
    reader.at_most_one({"file", "radiance", "sky"});
    EnvironmentDescription environment;
    if (const ordered_json* file = reader.find("file"))
        environment.light = resolve(*file, reader.place("file"), base_directory);
    else if (const ordered_json* radiance = reader.find("radiance"))
        environment.light = read_vector(*radiance, reader.place("radiance"), radiance_range);
    else if (const ordered_json* sky = reader.find("sky"))
        environment.light = read_sky(*sky, reader.place("sky"));
    reader.number("scale", environment.scale, radiance_range);
    reader.number("rotation_deg", environment.rotation_deg, {-1e6, 1e6});
    return environment;
}

SkySettings read_sky(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(
        value, place, {"zenith", "horizon", "ground", "sun_direction", "sun_angular_diameter_deg", "sun_irradiance"});
    SkySettings sky;
    reader.vector("zenith", sky.zenith, radiance_range);
    reader.vector("horizon", sky.horizon, radiance_range);
    reader.vector("ground", sky.ground, radiance_range);
    reader.vector("sun_direction", sky.sun_direction, coordinate);
    reader.number("sun_angular_diameter_deg", sky.sun_angular_diameter_deg, {0.001, 180.0});
    reader.vector("sun_irradiance", sky.sun_irradiance, radiance_range);
    require(dot(sky.sun_direction, sky.sun_direction) > 0.0, "{}: is zero (give the direction towards the sun)",
            place.at("sun_direction").text());
    return sky;
}

CameraDescription read_camera(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(value, place,
                              {"position", "target", "up", "vertical_fov_deg", "lens_radius", "focus_distance"});
    CameraDescription camera;
    reader.vector("position", camera.position, coordinate);
    reader.vector("target", camera.target, coordinate);
    reader.vector("up", camera.up, coordinate);
    reader.number("vertical_fov_deg", camera.vertical_fov_deg, {0.0, 180.0, Ends::open});
    reader.number("lens_radius", camera.lens_radius, {0.0, 1e9});
    reader.number("focus_distance", camera.focus_distance, positive);
    require(dot(camera.up, camera.up) > 0.0, "{}: is zero (give a direction, as in [0, 0, 1])", place.at("up").text());
    if (camera.position && camera.target) {
        const Vec3d view = *camera.target - *camera.position;
        require(dot(view, view) > 0.0, "{}: is the target itself (move one of them)", place.at("position").text());
        require(length(cross(normalized(view), normalized(camera.up))) > 1e-6,
                "{}: is parallel to the view from position to target (give another direction)", place.at("up").text());
    }
    return camera;
}

ImageSettings read_image(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(value, place, {"width", "height", "show_environment"});
    ImageSettings image;
    reader.whole("width", image.width, 1, 16384);
    reader.whole("height", image.height, 1, 16384);
    reader.boolean("show_environment", image.show_environment);
    return image;
}

void read_render(const ordered_json& value, const JsonPlace& place, RenderSettings& render, StopCriterion& stop)
{
    const ObjectReader reader(value, place,
                              {"strategy", "samples", "time", "noise", "seed", "random_numbers", "shadow_rays"});
    reader.at_most_one({"samples", "time", "noise"});
    if (const auto strategy = reader.choice("strategy", strategy_names))
        render.strategy = static_cast<Strategy>(*strategy);
    if (const ordered_json* samples = reader.find("samples"))
        stop = StopSamples{static_cast<std::int64_t>(
            read_whole(*samples, reader.place("samples"), 1, std::numeric_limits<std::int32_t>::max()))};
    if (const ordered_json* time = reader.find("time"))
        stop = StopTime{read_number(*time, reader.place("time"), positive)};
    if (const ordered_json* noise = reader.find("noise"))
        stop = StopNoise{read_number(*noise, reader.place("noise"), positive)};
    if (const ordered_json* seed = reader.find("seed"))
        render.seed = read_whole(*seed, reader.place("seed"), 0, std::numeric_limits<std::uint64_t>::max());
    if (const auto numbers = reader.choice("random_numbers", random_numbers_names))
        render.random_numbers = static_cast<RandomNumbers>(*numbers);
    read_whole_or_auto(reader, "shadow_rays", render.shadow_rays, most_shadow_rays);
}

VisibilitySettings read_visibility(const ordered_json& value, const JsonPlace& place)
{
    const ObjectReader reader(value, place, {"directions", "cell", "rays", "filter", "oversampling", "epsilon"});
    VisibilitySettings visibility;
    reader.whole("directions", visibility.directions, 1, 32);
    require((visibility.directions & (visibility.directions - 1)) == 0,
            "{}: {} is no power of two (give 1, 2, 4, 8, 16 or 32)", reader.place("directions").text(),
            visibility.directions);
    reader.whole("cell", visibility.cell, 1, 64);
    read_whole_or_auto(reader, "rays", visibility.rays, 8192);
    if (const auto filter = reader.choice("filter", filter_names))
        visibility.filter = static_cast<SweepFilter>(*filter);
    reader.whole("oversampling", visibility.oversampling, 1, 16);
    require(visibility.oversampling == 1 || visibility.oversampling == 4 || visibility.oversampling == 16,
            "{}: {} is not one of 1, 4 and 16", reader.place("oversampling").text(), visibility.oversampling);
    reader.number("epsilon", visibility.epsilon, {0.0, 1.0, Ends::open_low});
    return visibility;
}

} // namespace lumisweep
