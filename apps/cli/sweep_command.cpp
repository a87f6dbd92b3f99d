// lumisweep sweep: the visibility grid alone, timed, and checked against brute force.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>
#include <tbb/task_arena.h>

#include "commands.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/render/session.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/scene/load_scene.h"
#include "lumisweep/visibility/brute_force.h"
#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/sweep.h"
#include "scene_options.h"

namespace lumisweep::cli {

namespace {

struct SweepOptions {
    SceneOptions scene;
    int check = 0;
    bool json = false;
};

struct SweepRun {
    double load_s = 0.0, classify_s = 0.0, product_s = 0.0;
    bool automatic_rays = false;
    SweepStats sweep;
    Vec3i cells{0, 0, 0};
    int directions = 0, threads = 0;
    std::string device;
    std::uint64_t volume_bytes = 0, extinction_bytes = 0, visibility_bytes = 0, product_bytes = 0;
    std::optional<SweepCheck> check;
};

/// The product with the light, as the direction strategies sample it; none with a black environment.
void take_product(SweepRun& run, const VisibilityGrid& grid, const SessionInput& input)
{
    if (!(input.environment->mean_luminance() > 0.0))
        return;
    const Environment light =
        input.environment->refined(std::max(input.environment->resolution(), input.visibility.directions));
    const Stopwatch watch(run.product_s);
    const JointGrid product(grid, input.volume->size(), light, JointFactor::visibility_times_light,
                            input.visibility.epsilon);
    run.product_bytes = product.bytes();
}

/// With a strategy that needs the grid, and the least of an image.
SessionInput swept_alone(SessionInput input)
{
    input.render.strategy = Strategy::two_step;
    input.image.width = input.image.height = 1;
    if (!(input.environment->mean_luminance() > 0.0)) // which nobody would sweep for
        input.environment = std::make_shared<const Environment>();
    return input;
}

/// On the CPU, stage by stage.
VisibilityGrid sweep_on_cpu(SweepRun& run, const SessionInput& input)
{
    const RawRange range = raw_range(*input.volume);
    const auto begin = std::chrono::steady_clock::now();
    const ExtinctionGrid extinction = classify(*input.volume, range, input.transfer_function,
                                               sweep_mip_level(input.volume->size(), input.visibility.rays));
    run.classify_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    VisibilityGrid grid(input.volume->size(), input.visibility.cell, input.visibility.directions);
    run.sweep = sweep_visibility(grid, extinction, input.visibility);
    run.extinction_bytes = extinction.bytes();
    run.visibility_bytes = grid.bytes();
    take_product(run, grid, input);
    return grid;
}

/// As a session does it, whose grid `session` keeps. The second time, when memory has been taken and tables are there.
const VisibilityGrid& sweep_on_device(SweepRun& run, Session& session)
{
    session.prepare();
    const SessionStats first = session.stats();
    session.set_transfer_function(session.input().transfer_function);
    session.prepare();
    const SessionStats& stats = session.stats();
    run.classify_s = stats.classify_s - first.classify_s;
    run.product_s = stats.joint_s - first.joint_s;
    run.sweep = stats.last_sweep;
    run.visibility_bytes = stats.visibility_bytes;
    run.product_bytes = stats.joint_bytes;
    return session.visibility();
}

SweepRun run_sweep(const SweepOptions& options, const SceneDescription& scene)
{
    std::shared_ptr<Backend> backend = backend_of(options.scene);
    const LoadedScene loaded = load_scene(scene);
    for (const std::string& note : loaded.notes)
        spdlog::info("{}", note);
    for (const std::string& warning : loaded.warnings)
        spdlog::warn("{}", warning);
    const SessionInput& input = loaded.input;
    SweepRun run;
    run.load_s = loaded.load_s;
    run.threads = tbb::this_task_arena::max_concurrency();
    run.device = backend->device();
    std::unique_ptr<Session> session;
    VisibilityGrid swept;
    if (run.device == "cpu")
        swept = sweep_on_cpu(run, input);
    else
        session = std::make_unique<Session>(swept_alone(input), std::move(backend));
    const VisibilityGrid& grid = session ? sweep_on_device(run, *session) : swept;
    run.cells = grid.cells();
    run.directions = grid.direction_count();
    run.volume_bytes = input.volume->bytes();
    run.automatic_rays = input.visibility.rays == 0;
    if (options.check > 0) {
        const ExtinctionGrid finest =
            classify(*input.volume, raw_range(*input.volume), input.transfer_function, 0, ExtinctionLayouts::straight);
        run.check = sweep_check(grid, finest, options.check, input.render.seed);
    }
    return run;
}

double steps_per_second(const SweepRun& run)
{
    const double seconds = run.device == "cpu" ? run.sweep.layout_s + run.sweep.march_s : run.sweep.total_s;
    return seconds > 0.0 ? static_cast<double>(run.sweep.voxel_steps) / seconds : 0.0;
}

void print_json(const SweepRun& run)
{
    nlohmann::ordered_json json;
    json["seconds"] = {
        {"load", run.load_s}, {"classify", run.classify_s}, {"sweep", run.sweep.total_s}, {"product", run.product_s}};
    if (run.device == "cpu")
        json["processor_seconds"] = {{"layouts", run.sweep.layout_s},
                                     {"march", run.sweep.march_s},
                                     {"lookup", run.sweep.lookup_s},
                                     {"filter", run.sweep.filter_s}};
    json["cells"] = {run.cells.x, run.cells.y, run.cells.z};
    json["directions"] = run.directions;
    json["rays"] = run.sweep.rays;
    json["mip_level"] = run.sweep.mip_level;
    json["rays_chosen"] = run.automatic_rays ? "auto" : "given";
    json["voxel_steps"] = run.sweep.voxel_steps;
    json["voxel_steps_per_second"] = steps_per_second(run);
    if (run.device == "cpu")
        json["bytes_read"] = run.sweep.bytes_read;
    json["threads"] = run.threads;
    json["device"] = run.device;
    json["memory_bytes"] = {{"volume", run.volume_bytes},
                            {"visibility", run.visibility_bytes},
                            {"product", run.product_bytes},
                            {"peak_rss", peak_resident_memory()}};
    if (run.device == "cpu")
        json["memory_bytes"]["extinction"] = run.extinction_bytes;
    if (run.check)
        json["check"] = {{"positions", run.check->positions},
                         {"rms", run.check->rms},
                         {"max", run.check->max},
                         {"rms_averaged", run.check->rms_averaged},
                         {"max_averaged", run.check->max_averaged}};
    fmt::print("{}\n", json.dump(2));
}

void print_text(const SweepRun& run)
{
    fmt::print("visibility grid  {} x {} x {} cells, {} directions\n", run.cells.x, run.cells.y, run.cells.z,
               run.directions);
    fmt::print("rays             {} along the longer side (mip level {}{}), {:.4g} voxel steps\n", run.sweep.rays,
               run.sweep.mip_level, run.automatic_rays ? ", chosen by \"auto\"" : "",
               static_cast<double>(run.sweep.voxel_steps));
    fmt::print("load             {:.3f} s\nclassify         {:.3f} s\nsweep            {:.4f} s on {}\n", run.load_s,
               run.classify_s, run.sweep.total_s,
               run.device == "cpu" ? fmt::format("{} threads", run.threads) : run.device);
    if (run.device == "cpu")
        fmt::print(
            "  layouts {:.3f} s, march {:.3f} s, lookup {:.3f} s, filter {:.3f} s: processor time of all threads\n",
            run.sweep.layout_s, run.sweep.march_s, run.sweep.lookup_s, run.sweep.filter_s);
    if (run.device == "cpu")
        fmt::print("  {:.3g} voxel steps a second of layouts and march, {} of voxels read\n", steps_per_second(run),
                   format_bytes(run.sweep.bytes_read));
    else
        fmt::print("  {:.3g} voxel steps a second\n", steps_per_second(run));
    fmt::print("product          {:.3f} s\n", run.product_s);
    fmt::print("memory           volume {}, {}visibility {}, product {}, peak {}\n", format_bytes(run.volume_bytes),
               run.device == "cpu" ? fmt::format("extinction {}, ", format_bytes(run.extinction_bytes)) : "",
               format_bytes(run.visibility_bytes), format_bytes(run.product_bytes),
               format_bytes(peak_resident_memory()));
    if (run.check)
        fmt::print(
            "check            {} positions: rms {:.4f}, largest {:.4f} against brute force; rms {:.4f}, largest {:.4f} "
            "against its average over cell and texel\n",
            run.check->positions, run.check->rms, run.check->max, run.check->rms_averaged, run.check->max_averaged);
}

void sweep(const SweepOptions& options)
{
    const SceneDescription scene = read_scene(options.scene);
    run_with_threads(options.scene.threads, [&] {
        const SweepRun run = run_sweep(options, scene);
        if (options.json)
            print_json(run);
        else
            print_text(run);
    });
}

} // namespace

void add_sweep(CLI::App& app, Command& command)
{
    CLI::App* sub = app.add_subcommand("sweep", "Computes the visibility grid alone: time by stage, memory, error");
    auto options = std::make_shared<SweepOptions>();
    add_scene_options(*sub, options->scene);
    sub->add_option("--check", options->check, "Compare with brute force at N random positions")
        ->check(CLI::Range(1, 1000000))
        ->type_name("N");
    sub->add_flag("--json", options->json, "Print JSON");
    sub->callback([options, &command] { command = [options] { sweep(*options); }; });
}

} // namespace lumisweep::cli
