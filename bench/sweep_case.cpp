#include "sweep_case.h"

#include <utility>

#include <fmt/format.h>

#include "lumisweep/visibility/sweep.h"

namespace lumisweep::bench {

std::string filter_name(const SweepCase& c)
{
    if (c.oversampling > 1)
        return fmt::format("{}x", c.oversampling);
    return c.filter == SweepFilter::none ? "none" : c.filter == SweepFilter::half_angle ? "half" : "full";
}

void measure_sweep(benchmark::State& state, Subject& subject, const SweepCase& c)
{
    VisibilitySettings settings;
    settings.cell = c.cell;
    settings.rays = c.rays;
    settings.filter = c.filter;
    settings.oversampling = c.oversampling;
    const ExtinctionGrid& extinction = subject.extinction(sweep_mip_level(subject.volume().size(), c.rays));
    VisibilityGrid& grid = subject.grid(c.cell);
    SweepStats stats;
    run_with_threads(state, c.threads, [&] { stats = sweep_visibility(grid, extinction, settings); });
    state.counters["layout_s"] = stats.layout_s;
    state.counters["march_s"] = stats.march_s;
    state.counters["lookup_s"] = stats.lookup_s;
    state.counters["filter_s"] = stats.filter_s;
    state.counters["voxel_steps"] = static_cast<double>(stats.voxel_steps);
    state.counters["mip_level"] = stats.mip_level;
    state.counters["rays"] = stats.rays;
    state.counters["cell_directions"] = static_cast<double>(grid.cell_count()) * grid.direction_count();
    state.counters["grid_bytes"] = static_cast<double>(grid.bytes());
    state.counters["extinction_bytes"] = static_cast<double>(extinction.bytes());
}

void add_benchmark(Subjects& subjects, const std::string& subject, const std::string& name, int threads,
                   int repetitions, std::function<void(benchmark::State&, Subject&)> body)
{
    const auto guarded = [&subjects, subject, body = std::move(body)](benchmark::State& state) {
        if (Subject* const found = subjects.get(subject))
            body(state, *found);
        else
            state.SkipWithError("not enough memory");
    };
    auto* added = benchmark::RegisterBenchmark(fmt::format("{}/threads:{}", name, threads).c_str(), guarded);
    added->Iterations(1)->Repetitions(repetitions)->Unit(benchmark::kMillisecond);
    if (threads > 1)
        added->UseRealTime()->MeasureProcessCPUTime();
}

} // namespace lumisweep::bench
