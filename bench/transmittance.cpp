#include "transmittance.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/scene_file.h"
#include "transmittance_study.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

struct Medium {
    std::string name;
    std::function<SessionInput()> make;
};

SessionInput from_specimen(Specimen specimen, double extinction_scale, const std::filesystem::path& light)
{
    SessionInput input;
    input.transfer_function = TransferFunction(specimen.transfer_function.points(), extinction_scale);
    input.volume = std::make_shared<const ScalarGrid>(std::move(specimen.volume));
    if (std::filesystem::exists(light))
        input.environment = std::make_shared<Environment>(load_environment({light, 1.0, 30.0}).environment);
    else
        input.environment = std::make_shared<Environment>(environment_from_sky({}, 256));
    input.camera.position = {-200.0, -560.0, 90.0};
    input.camera.vertical_fov_deg = 28.0;
    return input;
}

std::vector<Medium> media_of(const std::filesystem::path& data, bool quick)
{
    const std::filesystem::path light = data / "environments" / "sunrise.exr";
    std::vector<Medium> media;
    if (!quick) {
        const std::pair<const char*, const char*> scenes[] = {
            {"ct_head", "ct_head.nrrd"}, {"stent", "stent.nrrd"}, {"ch2", "ch2.nii.gz"}};
        for (const auto& [name, file] : scenes)
            if (std::filesystem::exists(data / file))
                media.push_back({name, [scene = data.parent_path() / "scenes" / fmt::format("{}.json", name)] {
                                     return load_scene(read_scene_file(scene)).input;
                                 }});
    }
    const int side = quick ? 48 : 192;
    media.push_back({"ct", [=] { return from_specimen(ct_like({side, side, side * 9 / 10}), 1.0, light); }});
    // Mean optical depths of about 3, 400 and 4000 through the middle.
    for (const double scale : {1.0, 130.0, 1300.0})
        media.push_back({fmt::format("smoke:{}", static_cast<int>(3 * scale + 0.5)), [=] {
                             return from_specimen(smoke_like({side, side, side * 4 / 3}), scale, light);
                         }});
    return media;
}

/// Measures a medium under a strategy when it is first asked for, all estimators at once; keeps the last.
class Studies {
public:
    Studies(std::vector<Medium> media, StudySize size) : media_(std::move(media)), size_(size) {}
    const std::vector<Medium>& media() const { return media_; }

    const StudyResult& get(std::size_t medium, Strategy strategy)
    {
        if (!result_ || key_ != std::pair{medium, strategy}) {
            if (!input_ || key_.first != medium)
                input_ = media_[medium].make();
            key_ = {medium, strategy};
            SessionInput input = *input_;
            input.render.strategy = strategy;
            input.render.shadow_rays = 1; // what the arrays of rays have room for
            result_ = study_transmittance(std::move(input), size_);
        }
        return *result_;
    }

private:
    std::vector<Medium> media_;
    StudySize size_;
    std::pair<std::size_t, Strategy> key_{0, Strategy::uniform};
    std::optional<SessionInput> input_;
    std::optional<StudyResult> result_;
};

void report(benchmark::State& state, Studies& studies, std::size_t medium, Strategy strategy, std::size_t estimator)
{
    const StudyResult& study = studies.get(medium, strategy);
    const EstimatorResult& e = study.estimators[estimator];
    for (auto _ : state)
        state.SetIterationTime(e.ray_s);
    auto& counters = state.counters;
    counters["camera_s"] = study.camera_s;
    counters["direction_s"] = study.direction_s;
    counters["rays_per_path"] = study.rays_per_path;
    counters["mean_transmittance"] = study.mean_transmittance;
    counters["background_variance"] = study.background_variance;
    counters["ray_s"] = e.ray_s;
    counters["cells"] = e.cells;
    counters["lookups"] = e.lookups;
    counters["mean"] = e.mean;
    counters["variance"] = e.variance;
    counters["weighted_variance"] = e.weighted_variance;
    for (int k = 0; k < 3; ++k) {
        counters[fmt::format("image_variance_{}", 1 << k)] = e.image_variance[k];
        counters[fmt::format("image_s_{}", 1 << k)] = e.image_s[k];
    }
}

} // namespace

void register_transmittance(const std::filesystem::path& data, bool quick)
{
    const auto studies = std::make_shared<Studies>(media_of(data, quick), quick ? StudySize{32, 2, 2} : StudySize{});
    const auto& cases = estimator_cases();
    for (std::size_t medium = 0; medium < studies->media().size(); ++medium)
        for (const Strategy strategy : {Strategy::uniform, Strategy::two_step})
            for (std::size_t e = 0; e < cases.size(); ++e)
                benchmark::RegisterBenchmark(
                    fmt::format("transmittance/{}/{}/{}", studies->media()[medium].name, name_of(strategy),
                                cases[e].name)
                        .c_str(),
                    [=](benchmark::State& state) { report(state, *studies, medium, strategy, e); })
                    ->UseManualTime()
                    ->Iterations(1);
}

} // namespace lumisweep::bench
