#include "scene_options.h"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "commands.h"
#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/backends/make_backend.h"
#include "lumisweep/base/error.h"
#include "lumisweep/scene/presets.h"
#include "lumisweep/scene/scene_file.h"

namespace lumisweep::cli {

namespace {

namespace fs = std::filesystem;

TransferFunctionDescription transfer_function_of(const std::string& file_or_preset)
{
    const auto presets = preset_names();
    if (std::find(presets.begin(), presets.end(), file_or_preset) != presets.end()) {
        TransferFunctionDescription description;
        description.preset = file_or_preset;
        return description;
    }
    std::error_code ignored;
    require(fs::exists(file_or_preset, ignored), "--transfer-function {}: neither a file nor a preset (presets: {})",
            file_or_preset, fmt::join(presets, ", "));
    return read_transfer_function_file(file_or_preset);
}

/// A path given on the command line, relative to the current directory, as a JSON string.
std::string json_path(const std::string& option, const std::string& path)
{
    try {
        return nlohmann::json(fs::absolute(path).lexically_normal().string()).dump();
    } catch (const nlohmann::json::exception&) {
        fail("{} {}: the path is not UTF-8 (rename it)", option, path);
    }
}

/// Files come first, so that --set can say more of them.
std::vector<SceneOverride> overrides_of(const SceneOptions& options)
{
    std::vector<SceneOverride> overrides;
    if (!options.volume.empty())
        overrides.push_back({"volume", "{\"file\": " + json_path("--volume", options.volume) + "}"});
    if (!options.environment.empty())
        overrides.push_back({"environment.file", json_path("--environment", options.environment)});
    for (const std::string& text : options.overrides) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0)
            throw UsageError(fmt::format("--set {}: no KEY.PATH=VALUE (write as in --set visibility.cell=8)", text));
        overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
    }
    return overrides;
}

void require_isa(const SceneOptions& options)
{
    const std::vector<std::string> isas = available_isas();
    require(options.isa == "auto" || std::find(isas.begin(), isas.end(), options.isa) != isas.end(),
            "--isa {}: this machine or build does not have it (take one of auto, {})", options.isa,
            fmt::join(isas, ", "));
}

} // namespace

void add_scene_options(CLI::App& app, SceneOptions& options)
{
    app.add_option("scene", options.scene_file, "Scene file (JSON); may be left out when --volume is given")
        ->type_name("SCENE.json");
    app.add_option("--volume", options.volume,
                   "Volume: NRRD, MetaImage, NIfTI, a DICOM directory, or a glob of a series")
        ->type_name("FILE|DIR");
    app.add_option("--transfer-function,--preset", options.transfer_function,
                   fmt::format("JSON of a transfer function, or a preset: {}", fmt::join(preset_names(), ", ")))
        ->type_name("FILE|PRESET");
    app.add_option("--environment", options.environment, "Latitude-longitude map of the light")
        ->type_name("FILE.exr|FILE.hdr");
    app.add_option("--set", options.overrides, "Overrides a scene entry, as in --set visibility.cell=8; repeatable")
        ->type_name("KEY.PATH=VALUE")
        ->allow_extra_args(false);
    app.add_option("--device", options.device, "Where to compute; auto takes a GPU if there is one")
        ->check(CLI::IsMember({"cpu", "cuda", "auto"}))
        ->capture_default_str();
    app.add_option("--isa", options.isa, "Instruction set")
        ->check(CLI::IsMember({"auto", "baseline", "avx2", "avx512"}))
        ->capture_default_str();
    app.add_option("--threads", options.threads, "Number of threads; all cores when left out")
        ->check(CLI::Range(1, 4096));
    app.add_flag("-q,--quiet", options.quiet, "Only warnings and errors on stderr");
}

SceneDescription read_scene(const SceneOptions& options)
{
    if (options.scene_file.empty() && options.volume.empty())
        throw UsageError("nothing to render: give SCENE.json or --volume FILE (see lumisweep render --help)");
    if (options.quiet)
        spdlog::set_level(spdlog::level::warn);
    require_isa(options);
    const std::vector<SceneOverride> overrides = overrides_of(options);
    SceneDescription scene = options.scene_file.empty()
                                 ? parse_scene("{}", "command line", fs::current_path(), overrides)
                                 : read_scene_file(options.scene_file, overrides);
    if (!options.transfer_function.empty())
        scene.transfer_function = transfer_function_of(options.transfer_function);
    require(scene.volume.has_value(), "{}: volume: missing (add \"volume\": {{\"file\": ...}}, or give --volume FILE)",
            options.scene_file);
    require_files(scene);
    return scene;
}

std::shared_ptr<Backend> backend_of(const SceneOptions& options)
{
    ChosenBackend chosen = make_backend(device_of(options.device), options.isa);
    if (!chosen.note.empty())
        spdlog::info("{}", chosen.note);
    return std::move(chosen.backend);
}

void run_with_threads(int threads, const std::function<void()>& work)
{
    if (threads == 0)
        return work();
    const auto count = static_cast<std::size_t>(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, count);
    tbb::task_arena arena(threads);
    arena.execute(work);
}

} // namespace lumisweep::cli
