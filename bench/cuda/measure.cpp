#include "measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "lumisweep/backends/cpu/cpu_backend.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/backend.h"

namespace lumisweep::bench {

namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

SessionInput scene_of(const DeviceSubject& subject, const std::string& name, int side)
{
    const int small = std::min(side, 48);
    const std::optional<SessionInput> input =
        load_bench_scene(name, subject.sources, subject.quick ? SceneScale::quick : SceneScale::full,
                         {subject.quick ? small : side, subject.quick ? small : side, false});
    require(input.has_value(), "scene {}: its data are not there", name);
    return *input;
}

/// A little denser or thinner: another transfer function each time.
TransferFunction scaled(const TransferFunction& transfer_function, int step)
{
    return TransferFunction(transfer_function.points(),
                            transfer_function.extinction_scale() * (1.0 + 0.01 * (step % 5)));
}

/// Least and median.
Json summary(std::vector<double> seconds)
{
    std::sort(seconds.begin(), seconds.end());
    return {{"least", seconds.front()}, {"median", seconds[seconds.size() / 2]}};
}

Json settings_of(const SessionInput& input)
{
    const Vec3i size = input.volume->size();
    return {{"volume", {size.x, size.y, size.z}},
            {"cell", input.visibility.cell},
            {"directions", input.visibility.directions},
            {"rays", input.visibility.rays}};
}

Json measure_edit(const DeviceSubject& subject, SessionInput input)
{
    const TransferFunction transfer_function = input.transfer_function;
    Session session(std::move(input), subject.make_backend());
    session.prepare();
    std::vector<double> majorants, classify, sweep, joint;
    for (int i = 0; i < (subject.quick ? 3 : 30); ++i) {
        const SessionStats before = session.stats();
        session.set_transfer_function(scaled(transfer_function, i));
        session.prepare();
        const SessionStats& after = session.stats();
        majorants.push_back(after.majorants_s - before.majorants_s);
        classify.push_back(after.classify_s - before.classify_s);
        sweep.push_back(after.sweep_s - before.sweep_s);
        joint.push_back(after.joint_s - before.joint_s);
    }
    Json json = settings_of(session.input());
    json["seconds"] = {{"majorants", summary(majorants)},
                       {"classify", summary(classify)},
                       {"sweep", summary(sweep)},
                       {"joint", summary(joint)}};
    const auto steps = static_cast<double>(session.stats().last_sweep.voxel_steps);
    json["voxel_steps"] = steps;
    json["voxel_steps_per_s"] = steps / *std::min_element(sweep.begin(), sweep.end());
    return json;
}

} // namespace

void run_for_profiler(const DeviceSubject& subject)
{
    for (const char* scene : {"ct_like", "smoke_like"}) {
        SessionInput input = scene_of(subject, scene, 512);
        input.render.strategy = Strategy::two_step;
        input.visibility.rays = 512;
        Session session(std::move(input), subject.make_backend());
        for (int i = 0; i < 16; ++i)
            session.render_pass();
        session.film().arrays();
    }
}

nlohmann::ordered_json measure_edits(const DeviceSubject& subject)
{
    Json all = Json::array();
    SessionInput input = scene_of(subject, "ct_like", 64);
    input.render.strategy = Strategy::two_step;
    const int full = subject.quick ? 64 : 512;
    for (const SweepFilter filter : {SweepFilter::half_angle, SweepFilter::none})
        for (const int rays : {full, full / 2, full / 4})
            for (const int cell : {4, 8}) {
                input.visibility.filter = filter;
                input.visibility.rays = rays;
                input.visibility.cell = cell;
                Json json = measure_edit(subject, input);
                json["filter"] = filter == SweepFilter::none ? "none" : "half-angle";
                all.push_back(std::move(json));
            }
    return all;
}

nlohmann::ordered_json measure_first_sample(const DeviceSubject& subject)
{
    SessionInput input = scene_of(subject, "ct_like", 512);
    Session session(input, subject.make_backend());
    session.render_pass();
    session.film().arrays();
    std::vector<double> seconds;
    for (int i = 0; i < (subject.quick ? 3 : 20); ++i) {
        double elapsed_s = 0.0;
        {
            const Stopwatch watch(elapsed_s);
            session.set_transfer_function(scaled(input.transfer_function, i));
            session.render_pass();
            session.film().arrays();
        }
        seconds.push_back(elapsed_s);
    }
    Json json = settings_of(session.input());
    json["image"] = {session.input().image.width, session.input().image.height};
    json["seconds"] = summary(seconds);
    return json;
}

nlohmann::ordered_json measure_paths(const DeviceSubject& subject)
{
    Json all = Json::array();
    for (const char* scene : {"ct_like", "smoke_like"})
        for (const Strategy strategy : {Strategy::two_step, Strategy::automatic, Strategy::uniform}) {
            SessionInput input = scene_of(subject, scene, 512);
            input.render.strategy = strategy;
            Session session(input, subject.make_backend());
            session.prepare();
            session.render_pass();
            session.film().arrays();
            const PassCounts before = session.stats().counts;
            const double least_s = subject.quick ? 0.01 : 1.0;
            const auto begin = Clock::now();
            const auto elapsed_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
            while (elapsed_s() < least_s)
                session.render_pass();
            session.wait_for_passes();
            const double seconds = elapsed_s();
            const PassCounts after = session.stats().counts;
            const auto share = [](std::uint64_t part, std::uint64_t whole) {
                return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
            };
            const std::uint64_t paths = after.paths - before.paths;
            all.push_back(
                {{"scene", scene},
                 {"strategy", name_of(strategy)},
                 {"paths_per_s", static_cast<double>(paths) / seconds},
                 {"shadow_rays_per_s", static_cast<double>(after.shadow_rays - before.shadow_rays) / seconds},
                 {"camera_steps", share(after.camera_steps - before.camera_steps, paths)},
                 {"shadow_steps", share(after.shadow_steps - before.shadow_steps, paths)},
                 {"advance_steps", share(after.advance_steps - before.advance_steps, paths)},
                 {"advance_utilisation", share(after.advance_steps, after.advance_lanes)},
                 {"candidate_utilisation", share(after.camera_steps + after.shadow_steps, after.candidate_lanes)},
                 {"noise", session.film().noise()}});
        }
    return all;
}

nlohmann::ordered_json measure_equality(const DeviceSubject& subject)
{
    Json all = Json::array();
    for (const char* scene : {"ct_like", "smoke_like"}) {
        SessionInput input = scene_of(subject, scene, 256);
        input.render.strategy = Strategy::two_step;
        Session device(input, subject.make_backend()), scalar(input, make_cpu_backend("baseline"));
        // One sample: the same path, unless rounding has decided otherwise somewhere along it.
        device.render_pass();
        scalar.render_pass();
        std::size_t same = 0, equal_bits = 0;
        const AlignedArray<double>&a = device.film().color_sum(), &b = scalar.film().color_sum();
        for (std::size_t i = 0; i < a.size(); ++i) {
            same += std::fabs(a[i] - b[i]) <= 1e-4 * std::fabs(b[i]) + 1e-9 ? 1 : 0;
            equal_bits += a[i] == b[i] ? 1 : 0;
        }
        const auto count = static_cast<double>(a.size());
        Json json = {{"scene", scene},
                     {"same_samples", static_cast<double>(same) / count},
                     {"equal_to_the_bit", static_cast<double>(equal_bits) / count}};
        // Means of independent samples: another seed on the CPU.
        RenderSettings render = input.render;
        render.seed = 1;
        scalar.set_render(render);
        const int passes = subject.quick ? 16 : 256;
        for (int i = 0; i < passes; ++i) {
            device.render_pass();
            scalar.render_pass();
        }
        double difference = 0.0, variance = 0.0, mean = 0.0;
        for (const Session* session : {&device, &scalar}) {
            const Film& film = session->film();
            const double sign = session == &device ? 1.0 : -1.0;
            for (std::size_t i = 1; i < film.color_sum().size(); i += 3) { // green
                const double value = film.color_sum()[i] / static_cast<double>(film.samples());
                difference += sign * value;
                mean += 0.5 * value;
                variance += film.unbiased_variance_of_mean(i);
            }
        }
        json["means_differ"] = difference / mean;
        json["standard_error"] = std::sqrt(variance) / mean;
        all.push_back(std::move(json));
    }
    return all;
}

nlohmann::ordered_json measure_series(const DeviceSubject& subject)
{
    SessionInput input = scene_of(subject, "smoke_like", 512);
    // Frames of the same smoke, as another object each: what they hold does not matter here.
    std::vector<std::shared_ptr<const ScalarGrid>> frames{input.volume};
    const int count = subject.quick ? 2 : 4;
    for (int i = 1; i < count; ++i) {
        const ScalarGrid& first = *input.volume;
        auto frame = std::make_shared<ScalarGrid>(first.type(), first.size(), first.world_from_voxel(), first.slope(),
                                                  first.intercept());
        std::copy(first.data(), first.data() + first.bytes(), frame->data());
        frames.push_back(std::move(frame));
    }
    Json json = {{"frame_bytes", input.volume->bytes()}};
    for (const bool ahead : {false, true}) {
        Session session(input, subject.make_backend());
        session.render_pass();
        session.film().arrays();
        double seconds = 0.0;
        const int shown = subject.quick ? 3 : 60;
        {
            const Stopwatch watch(seconds);
            for (int i = 1; i <= shown; ++i) {
                session.set_volume(frames[static_cast<std::size_t>(i % count)]);
                session.prepare();
                if (ahead)
                    session.prefetch(frames[static_cast<std::size_t>((i + 1) % count)]);
                session.render_pass();
                session.film().arrays();
            }
        }
        json[ahead ? "frames_per_s_ahead" : "frames_per_s"] = shown / seconds;
    }
    return json;
}

} // namespace lumisweep::bench
