#include "paths.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <utility>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/base/stopwatch.h"

namespace lumisweep::bench {
namespace {

/// The scene asked for last: they are large.
class LoadedScenes {
public:
    LoadedScenes(SceneSources sources, bool quick) : sources_(std::move(sources)), quick_(quick) {}

    /// Nothing when its data are not there.
    const std::optional<SessionInput>& get(const std::string& name)
    {
        if (name != name_) {
            input_.reset();
            const int side = quick_ ? 64 : 512;
            input_ =
                load_bench_scene(name, sources_, quick_ ? SceneScale::quick : SceneScale::full, {side, side, false});
            name_ = name;
        }
        return input_;
    }

private:
    SceneSources sources_;
    bool quick_;
    std::string name_;
    std::optional<SessionInput> input_;
};

/// The same medium, but black: no light is worth a shadow segment.
TransferFunction without_albedo(const TransferFunction& transfer_function)
{
    std::vector<TransferPoint> points = transfer_function.points();
    for (TransferPoint& point : points)
        point.albedo = {0.0, 0.0, 0.0};
    return TransferFunction(std::move(points), transfer_function.extinction_scale());
}

/// The least of several passes: what else the machine does only adds.
class Timed {
public:
    Timed(const SessionInput& input, const std::string& isa) : session_(input, make_cpu_backend(isa))
    {
        session_.prepare();
        session_.render_pass();
    }

    /// On one thread, the calling one.
    void pass()
    {
        double seconds = 0.0;
        {
            const ProcessorStopwatch watch(seconds);
            session_.render_pass();
        }
        least_s_ = std::min(least_s_, seconds);
    }
    double least_s() const { return least_s_; }
    const Session& session() const { return session_; }

private:
    Session session_;
    double least_s_ = 1e30;
};

struct Case {
    std::string scene, isa;
    bool quick;

    /// At least three passes, and more of the short ones.
    bool enough(int passes, double least_s) const
    {
        return quick ? passes >= 2 : passes >= 3 && passes * least_s > 1.0;
    }
};

/// Where a sample's time goes, by differences: with all light, without albedo (no shadow segment; the directions are
/// chosen all the same), and without albedo by uniform sampling. Passes of the three alternate.
void measure_on_one_thread(benchmark::State& state, const SessionInput& input, const Case& c)
{
    SessionInput dark = input;
    dark.transfer_function = without_albedo(input.transfer_function);
    SessionInput dark_uniform = dark;
    dark_uniform.render.strategy = Strategy::uniform;
    Timed full(input, c.isa), camera(dark, c.isa), uniform(dark_uniform, c.isa);
    for (auto _ : state) {
        tbb::task_arena(1).execute([&] {
            for (int i = 0; !c.enough(i, full.least_s()); ++i) {
                full.pass();
                camera.pass();
                uniform.pass();
            }
        });
        state.SetIterationTime(full.least_s());
    }
    const PassCounts& counts = full.session().stats().counts;
    const auto paths = static_cast<double>(counts.paths);
    const double paths_a_pass = static_cast<double>(input.image.width) * input.image.height;
    const Film& film = full.session().film();
    double hits = 0.0;
    for (std::size_t i = 7; i < film.features().size(); i += feature_count)
        hits += film.features()[i];
    state.counters["paths_per_s"] = paths_a_pass / full.least_s();
    state.counters["collided"] = hits / paths;
    state.counters["camera_steps"] = static_cast<double>(counts.camera_steps) / paths;
    state.counters["shadow_steps"] = static_cast<double>(counts.shadow_steps) / paths;
    state.counters["advance_utilisation"] =
        static_cast<double>(counts.advance_steps) / static_cast<double>(counts.advance_lanes);
    state.counters["candidate_utilisation"] =
        static_cast<double>(counts.camera_steps + counts.shadow_steps) / static_cast<double>(counts.candidate_lanes);
    state.counters["camera_share"] = uniform.least_s() / full.least_s();
    state.counters["direction_share"] = (camera.least_s() - uniform.least_s()) / full.least_s();
    state.counters["shadow_share"] = 1.0 - camera.least_s() / full.least_s();
}

void measure_on_threads(benchmark::State& state, const SessionInput& input, const Case& c, int threads)
{
    Session session(input, make_cpu_backend(c.isa));
    session.prepare();
    double least_s = 1e30;
    for (auto _ : state) {
        tbb::task_arena arena(threads);
        for (int i = 0; !c.enough(i, least_s); ++i) {
            double seconds = 0.0;
            {
                const Stopwatch watch(seconds);
                arena.execute([&] { session.render_pass(); });
            }
            least_s = std::min(least_s, seconds);
        }
        state.SetIterationTime(least_s);
    }
    state.counters["paths_per_s"] = static_cast<double>(input.image.width) * input.image.height / least_s;
}

} // namespace

void register_paths(const SceneSources& sources, bool quick)
{
    const auto scenes = std::make_shared<LoadedScenes>(sources, quick);
    const std::vector<std::string> isas = available_isas();
    const auto add = [&](const Case& c, int threads) {
        const auto body = [scenes, c, threads](benchmark::State& state) {
            std::optional<SessionInput> input = scenes->get(c.scene);
            if (!input) {
                state.SkipWithError("no data (scripts/fetch_data)");
                return;
            }
            // One shadow ray a path, as paths are counted everywhere.
            input->render = {};
            input->render.strategy = Strategy::two_step;
            if (threads == 1)
                measure_on_one_thread(state, *input, c);
            else
                measure_on_threads(state, *input, c, threads);
        };
        benchmark::RegisterBenchmark(fmt::format("paths/{}/isa:{}/threads:{}", c.scene, c.isa, threads).c_str(), body)
            ->Iterations(1)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    };
    for (const std::string& scene : scene_names()) {
        for (const std::string& isa : isas)
            add({scene, isa, quick}, 1);
        add({scene, isas.front(), quick}, 2);
    }
}

} // namespace lumisweep::bench
