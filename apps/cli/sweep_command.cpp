// lumisweep sweep: the visibility grid alone, timed, and checked against brute force.
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
    double load_s = 0.0, classify_s = 0.0;
    SweepStats sweep;
    Vec3i cells{0, 0, 0};
    int directions = 0, threads = 0;
    std::uint64_t volume_bytes = 0, extinction_bytes = 0, visibility_bytes = 0;
    std::optional<SweepCheck> check;
};

SweepRun run_sweep(const SweepOptions& options, const SceneDescription& scene)
{
    const LoadedScene loaded = load_scene(scene);
    for (const std::string& note : loaded.notes)
        spdlog::info("{}", note);
    for (const std::string& warning : loaded.warnings)
        spdlog::warn("{}", warning);
    const SessionInput& input = loaded.input;
    SweepRun run;
    run.load_s = loaded.load_s;
    run.threads = tbb::this_task_arena::max_concurrency();
    const RawRange range = raw_range(*input.volume);
    const auto begin = std::chrono::steady_clock::now();
    const ExtinctionGrid extinction = classify(*input.volume, range, input.transfer_function,
                                               sweep_mip_level(input.volume->size(), input.visibility.rays));
    run.classify_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    VisibilityGrid grid(input.volume->size(), input.visibility.cell, input.visibility.directions);
    run.sweep = sweep_visibility(grid, extinction, input.visibility);
    run.cells = grid.cells();
    run.directions = grid.direction_count();
    run.volume_bytes = input.volume->bytes();
    run.extinction_bytes = extinction.bytes();
    run.visibility_bytes = grid.bytes();
    if (options.check > 0) {
        const ExtinctionGrid finest =
            classify(*input.volume, range, input.transfer_function, 0, ExtinctionLayouts::straight);
        run.check = sweep_check(grid, finest, options.check, input.render.seed);
    }
    return run;
}

void print_json(const SweepRun& run)
{
    nlohmann::ordered_json json;
    json["seconds"] = {{"load", run.load_s},         {"classify", run.classify_s},   {"sweep", run.sweep.total_s},
                       {"march", run.sweep.march_s}, {"lookup", run.sweep.lookup_s}, {"filter", run.sweep.filter_s}};
    json["cells"] = {run.cells.x, run.cells.y, run.cells.z};
    json["directions"] = run.directions;
    json["rays"] = run.sweep.rays;
    json["mip_level"] = run.sweep.mip_level;
    json["voxel_steps"] = run.sweep.voxel_steps;
    json["threads"] = run.threads;
    json["memory_bytes"] = {{"volume", run.volume_bytes},
                            {"extinction", run.extinction_bytes},
                            {"visibility", run.visibility_bytes},
                            {"peak_rss", peak_resident_memory()}};
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
    fmt::print("sweep kernel     {} rays along the longer side (mip level {}), {:.4g} voxel steps\n", run.sweep.rays,
               run.sweep.mip_level, static_cast<double>(run.sweep.voxel_steps));
    fmt::print("load             {:.3f} s\nclassify         {:.3f} s\nsweep            {:.3f} s on {} threads\n",
               run.load_s, run.classify_s, run.sweep.total_s, run.threads);
    fmt::print("  march {:.3f} s, lookup {:.3f} s, filter {:.3f} s, summed over threads\n", run.sweep.march_s,
               run.sweep.lookup_s, run.sweep.filter_s);
    fmt::print("memory           volume {}, extinction {}, visibility {}, peak {}\n", format_bytes(run.volume_bytes),
               format_bytes(run.extinction_bytes), format_bytes(run.visibility_bytes),
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
