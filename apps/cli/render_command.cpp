// lumisweep render: a scene to images.
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include "commands.h"
#include "interrupt.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/version.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/scene/checkpoint.h"
#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/scene_file.h"
#include "lumisweep/visibility/sweep.h"
#include "outputs.h"
#include "render_loop.h"
#include "scene_options.h"

namespace lumisweep::cli {

namespace {

struct RenderOptions {
    SceneOptions scene;
    std::vector<std::string> outputs;
    std::string stats, resume, checkpoint;
    std::optional<Strategy> strategy;
    std::optional<std::int64_t> samples;
    std::optional<double> time_s, noise;
    std::optional<std::uint64_t> seed;
    std::optional<int> width, height;
};

template <class Number>
std::optional<Number> parse(const std::string& text)
{
    Number number{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

// In place of CLI11's checks, which take NaN for positive and name the largest double in their messages.
std::string require_positive(const std::string& text)
{
    const auto number = parse<double>(text);
    return number && *number > 0.0 && std::isfinite(*number) ? "" : text + " is no positive number";
}

std::string require_seed(const std::string& text)
{
    return parse<std::uint64_t>(text) ? "" : text + " is no whole number from 0 to 18446744073709551615";
}

void add_options(CLI::App& app, RenderOptions& options)
{
    add_scene_options(app, options.scene);
    app.add_option("-o,--output", options.outputs, "Image to write; repeatable")
        ->type_name("OUT.exr|OUT.png")
        ->allow_extra_args(false);
    std::map<std::string, Strategy> strategies;
    for (const Strategy s : {Strategy::uniform, Strategy::environment, Strategy::visibility, Strategy::combined,
                             Strategy::two_step, Strategy::automatic})
        strategies[name_of(s)] = s;
    app.add_option_function<std::string>(
           "--strategy", [&options, strategies](const std::string& name) { options.strategy = strategies.at(name); },
           "How directions towards the light are chosen: auto when left out, the least noise for the time; the others "
           "are "
           "the papers', for comparison")
        ->check(CLI::IsMember(strategies).description(""))
        ->type_name("uniform|environment|visibility|combined|two-step|auto");
    auto* samples =
        app.add_option("--samples", options.samples, "Stop after N samples a pixel (64 when nothing is given)")
            ->check(CLI::Range(std::int64_t{1}, std::int64_t{2147483647}))
            ->type_name("N");
    auto* time = app.add_option("--time", options.time_s, "Stop after so many seconds of rendering")
                     ->check(require_positive)
                     ->type_name("SECONDS");
    auto* noise = app.add_option("--noise", options.noise, "Stop at this estimated relative error of the image")
                      ->check(require_positive)
                      ->type_name("REL");
    samples->excludes(time)->excludes(noise);
    time->excludes(noise);
    app.add_option("--seed", options.seed, "Seed of the random numbers")->check(require_seed)->type_name("N");
    app.add_option("--width", options.width, "Image width in pixels")->check(CLI::Range(1, 16384))->type_name("W");
    app.add_option("--height", options.height, "Image height in pixels")->check(CLI::Range(1, 16384))->type_name("H");
    app.add_option("--stats", options.stats, "Timings and counts of this run")->type_name("FILE.json");
    app.add_option("--checkpoint", options.checkpoint, "Keep the accumulated image here, to go on with --resume")
        ->type_name("FILE");
    app.add_option("--resume", options.resume, "Go on accumulating from a checkpoint")->type_name("FILE");
}

SceneDescription scene_of(const RenderOptions& options)
{
    SceneDescription scene = read_scene(options.scene);
    if (options.strategy)
        scene.render.strategy = *options.strategy;
    if (options.samples)
        scene.stop = StopSamples{*options.samples};
    if (options.time_s)
        scene.stop = StopTime{*options.time_s};
    if (options.noise)
        scene.stop = StopNoise{*options.noise};
    if (options.seed)
        scene.render.seed = *options.seed;
    if (options.width)
        scene.image.width = *options.width;
    if (options.height)
        scene.image.height = *options.height;
    return scene;
}

/// "head-render.exr" for head.json or head.nii.gz, in the current directory.
std::string default_output(const SceneOptions& options)
{
    const std::filesystem::path input = options.scene_file.empty() ? options.volume : options.scene_file;
    std::string name = input.has_filename() ? input.filename().string() : input.parent_path().filename().string();
    name = name.substr(0, name.find('.', 1));
    return (name.empty() ? "volume" : name) + "-render.exr";
}

void require_outputs(RenderOptions& options)
{
    if (options.outputs.empty()) {
        options.outputs.push_back(default_output(options.scene));
        spdlog::info("no -o given: the image will be {}", options.outputs[0]);
    }
    for (const std::string& file : options.outputs)
        require_writable(file);
    for (const std::string& file : {options.stats, options.checkpoint})
        if (!file.empty())
            require_writable(file);
}

RenderHeader header_of(const RenderOptions& options, const SceneDescription& scene)
{
    RenderHeader header;
    header.effective_text = scene_to_json(scene);
    header.scene_text =
        options.scene.scene_file.empty() ? header.effective_text : read_scene_text(options.scene.scene_file);
    return header;
}

void report(const LoadedScene& loaded, const Backend& backend)
{
    for (const std::string& note : loaded.notes)
        spdlog::info("{}", note);
    for (const std::string& warning : loaded.warnings)
        spdlog::warn("{}", warning);
    const SessionInput& input = loaded.input;
    if (input.render.strategy != Strategy::uniform && input.render.strategy != Strategy::environment) {
        const int level = sweep_mip_level(input.volume->size(), input.visibility.rays);
        spdlog::info("visibility from rays {} voxels apart{}", 1 << level,
                     input.visibility.rays == 0 ? ", chosen by \"auto\"" : "");
    }
    const std::string model = backend.model();
    spdlog::info("rendering on {} ({}{}{})", backend.device(), backend.isa(), model.empty() ? "" : ", ", model);
}

void report_end(const RenderResult& result, const Session& session)
{
    if (result.stopped_by_user)
        spdlog::warn("interrupted: writing the image as it is, with {} samples a pixel", session.film().samples());
    if (result.black)
        spdlog::warn("the image is black, so that its relative error is undefined: stopped after {} samples a pixel",
                     session.film().samples());
}

void resume_from(const std::string& file, const Fingerprint& fingerprint, const StopCriterion& stop, Session& session)
{
    Film film = read_checkpoint(file, fingerprint);
    const auto* wanted = std::get_if<StopSamples>(&stop);
    if (wanted != nullptr && film.samples() > wanted->samples)
        spdlog::warn("{}: has {} samples a pixel already, more than the {} asked for", file, film.samples(),
                     wanted->samples);
    spdlog::info("resuming from {} samples a pixel", film.samples());
    session.restore_film(std::move(film));
}

void render(RenderOptions options)
{
    require_image_extensions(options.outputs);
    const SceneDescription scene = scene_of(options);
    require_outputs(options);
    const RenderHeader header = header_of(options, scene);
    std::error_code ignored;
    require(options.resume.empty() || std::filesystem::exists(options.resume, ignored),
            "{}: no such checkpoint (check the path after --resume)", options.resume);

    run_with_threads(options.scene.threads, [&] {
        std::shared_ptr<Backend> backend = backend_of(options.scene);
        LoadedScene loaded = load_scene(scene);
        report(loaded, *backend);
        const std::string isa = backend->isa();
        Fingerprint fingerprint;
        if (!options.checkpoint.empty() || !options.resume.empty())
            fingerprint = fingerprint_of(loaded.input, isa, version());
        Session session(std::move(loaded.input), std::move(backend));
        if (!options.resume.empty())
            resume_from(options.resume, fingerprint, scene.stop, session);
        std::unique_ptr<CheckpointWriter> checkpoints;
        if (!options.checkpoint.empty())
            checkpoints = std::make_unique<CheckpointWriter>(options.checkpoint, fingerprint);

        catch_interrupts();
        const RenderResult result = render_until(session, scene.stop, checkpoints.get());
        report_end(result, session);
        write_images(options.outputs, session, result, header);
        if (!options.stats.empty())
            write_stats(options.stats, session, result, loaded.load_s, tbb::this_task_arena::max_concurrency());
        require(result.checkpoint_failure.empty(), "{}", result.checkpoint_failure); // the image is safe
    });
}

} // namespace

void add_render(CLI::App& app, Command& command)
{
    CLI::App* sub = app.add_subcommand("render", "Renders a scene, or a volume under natural light, to images");
    auto options = std::make_shared<RenderOptions>();
    add_options(*sub, *options);
    sub->callback([options, &command] { command = [options] { render(*options); }; });
}

} // namespace lumisweep::cli
