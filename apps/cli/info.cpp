#include "info.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "lumisweep/base/memory.h"
#include "lumisweep/image/hdr.h"
#include "lumisweep/light/environment.h"
#include "lumisweep/light/latlong.h"
#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/presets.h"
#include "lumisweep/scene/scene_file.h"

namespace lumisweep::cli {

namespace {

using nlohmann::ordered_json;

ordered_json list(const Vec3d& v) { return ordered_json::array({v.x, v.y, v.z}); }
ordered_json list(const Vec3i& v) { return ordered_json::array({v.x, v.y, v.z}); }

/// The anatomical directions towards which voxel indices grow, "LPS" for the identity.
std::string anatomical_code(const Affine3d& world_from_voxel)
{
    constexpr std::array<const char*, 3> letters{"RL", "AP", "IS"};
    std::string code;
    for (const Vec3d& column : world_from_voxel.column) {
        int largest = 0;
        for (int axis = 1; axis < 3; ++axis)
            if (std::abs(component(column, axis)) > std::abs(component(column, largest)))
                largest = axis;
        code += letters[static_cast<std::size_t>(largest)][component(column, largest) > 0.0 ? 1 : 0];
    }
    return code;
}

/// At most `bins` counts over the whole range.
ordered_json coarse_histogram(const ValueStatistics& values, std::size_t bins)
{
    const std::size_t group = (values.histogram.size() + bins - 1) / bins;
    ordered_json counts = ordered_json::array();
    for (std::size_t b = 0; group > 0 && b < values.histogram.size(); b += group) {
        std::uint64_t count = 0;
        for (std::size_t i = b; i < std::min(b + group, values.histogram.size()); ++i)
            count += values.histogram[i];
        counts.push_back(count);
    }
    return {{"low", values.min}, {"bin_width", values.bin_width * static_cast<double>(group)}, {"counts", counts}};
}

ordered_json header_json(const std::filesystem::path& path, const VolumeHeader& header)
{
    ordered_json json;
    json["kind"] = "volume";
    json["path"] = path.string();
    json["format"] = header.format;
    json["modality"] = header.modality;
    json["voxel_type"] = header.voxel_type;
    json["size"] = list(header.size);
    json["frames"] = header.frames;
    json["spacing"] = list(header.spacing);
    const Affine3d& map = header.world_from_voxel;
    json["directions"] = ordered_json::array();
    for (const Vec3d& column : map.column)
        json["directions"].push_back(list(normalized(column)));
    json["orientation"] = anatomical_code(map);
    json["first_voxel_centre"] = list(map.point({0.5, 0.5, 0.5}));
    json["slope"] = header.slope;
    json["intercept"] = header.intercept;
    return json;
}

} // namespace

ordered_json volume_info(const std::filesystem::path& path, int frame)
{
    const VolumeHeader header = inspect_volume(path);
    require_memory(header.bytes_needed, path.string(), "take a machine with more, or a smaller volume");
    const LoadedVolume volume = load_volume({{path}, frame});
    const ValueStatistics values = value_statistics(volume.grid);
    ordered_json json = header_json(path, header);
    json["frame"] = frame;
    json["memory_bytes"] = volume.grid.bytes();
    json["min"] = values.min;
    json["max"] = values.max;
    json["non_finite"] = values.non_finite;
    json["percentiles"] = ordered_json::object();
    for (const double percent : {1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0, 99.9})
        json["percentiles"][fmt::format("{:g}", percent)] = values.percentile(percent / 100.0);
    json["histogram"] = coarse_histogram(values, 32);
    PresetInput input;
    input.modality = volume.modality;
    input.values = values;
    input.frames = volume.frames;
    json["preset"] = choose_preset(input).name;
    json["warnings"] = volume.warnings;
    return json;
}

ordered_json environment_info(const std::filesystem::path& path)
{
    const Image image = load_latlong(path);
    LatLongReport report;
    const Environment environment = environment_from_latlong(image, 1.0, 0.0, &report);
    const EnvironmentView view = environment.view();
    const auto texels =
        static_cast<std::size_t>(environment.resolution()) * static_cast<std::size_t>(environment.resolution());
    std::vector<double> luminances(texels);
    double sum = 0.0, sum_squares = 0.0;
    for (std::size_t t = 0; t < texels; ++t) {
        const float* rgb = view.radiance + 3 * t;
        luminances[t] = luminance(rgb[0], rgb[1], rgb[2]);
        sum += luminances[t];
        sum_squares += luminances[t] * luminances[t];
    }
    std::sort(luminances.begin(), luminances.end());
    double brightest = 0.0; // of the power, from a thousandth of the sphere
    for (std::size_t t = texels - std::max<std::size_t>(texels / 1000, 1); t < texels; ++t)
        brightest += luminances[t];
    ordered_json json;
    json["kind"] = "environment";
    json["path"] = path.string();
    json["size"] = {image.width, image.height};
    json["octahedral_resolution"] = environment.resolution();
    json["memory_bytes"] = environment.bytes();
    json["mean_luminance"] = environment.mean_luminance();
    json["max_luminance"] = luminances.back();
    json["contrast"] = sum > 0.0 ? sum_squares * static_cast<double>(texels) / (sum * sum) : 0.0;
    json["power_in_brightest_thousandth"] = sum > 0.0 ? brightest / sum : 0.0;
    json["negative_texels"] = report.negative_texels;
    json["non_finite_texels"] = report.non_finite_texels;
    return json;
}

ordered_json scene_info(const std::filesystem::path& path)
{
    const SceneDescription scene = read_scene_file(path);
    require_files(scene);
    ordered_json json;
    json["kind"] = "scene";
    json["path"] = path.string();
    json["scene"] = ordered_json::parse(scene_to_json(scene));
    if (scene.volume) {
        const VolumeRequest request = volume_request(*scene.volume);
        const VolumeHeader header = inspect_volume(request.files.front());
        json["volume"] = header_json(request.files.front(), header);
        json["volume"]["files"] = request.files.size();
        json["memory_bytes_needed"] = memory_estimate(header, scene);
    }
    return json;
}

} // namespace lumisweep::cli
