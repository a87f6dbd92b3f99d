// lumisweep_efficiency: squared error by processor time; studies/efficiency.py runs it and writes the report.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "efficiency.h"
#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/base/error.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/scene_file.h"
#include "reference_file.h"
#include "scenes.h"

namespace lumisweep::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct MeasureOptions {
    fs::path scene, reference;
    std::string light, isa = "auto";
    int width = 128, reference_samples = 1024, seeds = 2;
    std::vector<int> sample_counts{16, 64};
    std::vector<std::string> settings, variants, reference_settings;
    bool scalar = false;
};

std::vector<SceneOverride> overrides_of(const std::vector<std::string>& settings)
{
    std::vector<SceneOverride> overrides;
    for (const std::string& text : settings) {
        const std::size_t equals = text.find('=');
        require(equals != std::string::npos, "{}: no KEY.PATH=VALUE", text);
        overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
    }
    return overrides;
}

/// The scene's own settings and, over them, what `settings` say of rendering and visibility.
SessionInput with_settings(SessionInput input, const MeasureOptions& options, const std::vector<std::string>& settings)
{
    std::vector<SceneOverride> overrides = overrides_of(options.settings);
    for (SceneOverride& added : overrides_of(settings))
        overrides.push_back(std::move(added));
    const SceneDescription scene = read_scene_file(options.scene, overrides);
    input.render = scene.render;
    input.visibility = scene.visibility;
    return input;
}

SessionInput load(const MeasureOptions& options)
{
    SceneDescription scene = read_scene_file(options.scene, overrides_of(options.settings));
    scene.image = {options.width, options.width, false};
    if (options.light != "behind")
        scene.environment = {fs::absolute(options.light), 1.0, scene.environment.rotation_deg};
    SessionInput input = load_scene(scene).input;
    if (options.light == "behind")
        input.environment = light_from_behind(input.camera);
    return input;
}

Reference reference_of(const SessionInput& input, const MeasureOptions& options)
{
    std::error_code ignored;
    if (fs::exists(options.reference, ignored))
        return read_reference(options.reference);
    constexpr std::uint64_t seed = 900000;
    Reference reference =
        make_reference(with_settings(input, options, options.reference_settings), options.reference_samples, seed);
    write_reference(options.reference, reference);
    return reference;
}

Json json_of(const MeasuredNoise& noise)
{
    return {{"preparation_s", noise.preparation_s},
            {"sample_s", noise.sample_s},
            {"mse", noise.mse},
            {"mse_error", noise.mse_error},
            {"percentile_9999", noise.percentile_9999},
            {"kurtosis", noise.kurtosis},
            {"bias_in_errors", noise.bias_in_errors}};
}

void measure(MeasureOptions options)
{
    std::sort(options.sample_counts.begin(), options.sample_counts.end());
    const SessionInput input = load(options);
    const Reference reference = reference_of(input, options);
    Json json;
    json["isa"] = make_cpu_backend(options.isa)->isa();
    json["sample_counts"] = options.sample_counts;
    json["visible_light"] = visible_light(reference, *input.environment);
    json["reference_mse"] = reference.own_mse;
    std::vector<std::pair<std::string, NoiseMeasurement>> measurements;
    const auto add = [&](const std::string& name, auto&& make) {
        measurements.emplace_back(name, NoiseMeasurement(make, reference, options.sample_counts));
    };
    for (const std::string& variant : options.variants) {
        const std::size_t colon = variant.find(':');
        std::vector<std::string> settings;
        if (colon != std::string::npos)
            settings = CLI::detail::split(variant.substr(colon + 1), ',');
        const SessionInput changed = with_settings(input, options, settings);
        add(variant.substr(0, colon), [&] { return make_session_estimator(changed, options.isa); });
    }
    if (options.scalar)
        add("scalar", [&] { return make_scalar_estimator(input); });
    for (int seed = 1; seed <= options.seeds; ++seed)
        for (auto& [name, measurement] : measurements)
            measurement.render(static_cast<std::uint64_t>(seed));
    for (const auto& [name, measurement] : measurements)
        json["estimators"][name] = json_of(measurement.result());
    std::printf("%s\n", json.dump(1).c_str());
}

void add_measure(CLI::App& app)
{
    auto options = std::make_shared<MeasureOptions>();
    CLI::App* sub =
        app.add_subcommand("measure", "Prints the noise and the time of each way to render a scene as JSON");
    sub->add_option("scene", options->scene, "Scene file")->required();
    sub->add_option("--light", options->light, "Light map, or \"behind\": a sun behind the volume")->required();
    sub->add_option("--reference", options->reference, "OpenEXR file of the reference; rendered if it is not there")
        ->required();
    sub->add_option("--reference-samples", options->reference_samples, "Samples of a reference");
    sub->add_option("--reference-set", options->reference_settings, "KEY=VALUE for the reference; repeatable")
        ->allow_extra_args(false);
    sub->add_option("--set", options->settings, "KEY=VALUE for all; repeatable")->allow_extra_args(false);
    sub->add_option("--variant", options->variants, "NAME:KEY=VALUE,KEY=VALUE; repeatable")->allow_extra_args(false);
    sub->add_flag("--scalar", options->scalar, "The scalar tracker, too");
    sub->add_option("--width", options->width, "Pixels along each side");
    sub->add_option("--samples", options->sample_counts, "Sample counts at which errors are taken")->delimiter(',');
    sub->add_option("--seeds", options->seeds, "Images of different seeds");
    sub->add_option("--isa", options->isa, "Instruction set");
    sub->callback([options] { measure(*options); });
}

void add_scenes(CLI::App& app)
{
    struct Options {
        fs::path folder, data = LUMISWEEP_FETCHED_DATA;
        bool quick = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* sub = app.add_subcommand("scenes", "Writes the scenes that are there as scene files; prints their names");
    sub->add_option("folder", options->folder, "Where to")->required();
    sub->add_option("--data", options->data, "Fetched data");
    sub->add_flag("--quick", options->quick, "Small generated volumes");
    sub->callback([options] {
        fs::create_directories(options->folder);
        for (const std::string& name : scene_names())
            if (write_bench_scene(name, {LUMISWEEP_PROJECT, options->data},
                                  options->quick ? SceneScale::quick : SceneScale::full, options->folder))
                std::printf("%s\n", name.c_str());
    });
}

} // namespace
} // namespace lumisweep::bench

int main(int argc, char** argv)
{
    try {
        CLI::App app("Squared error by processor time", "lumisweep_efficiency");
        app.require_subcommand(1);
        lumisweep::bench::add_measure(app);
        lumisweep::bench::add_scenes(app);
        CLI11_PARSE(app, argc, argv);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lumisweep_efficiency: %s\n", error.what());
        return 1;
    }
}
