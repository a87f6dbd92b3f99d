#include "lumisweep/render/session_state.h"

#include <algorithm>

#include <tbb/task_arena.h>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/render/camera.h"
#include "lumisweep/render/session_limits.h"
#include "lumisweep/visibility/sweep_memory.h"

namespace lumisweep {

namespace {

Linear3f linear(const Affine3d& a) { return {to_float(a.column[0]), to_float(a.column[1]), to_float(a.column[2])}; }

} // namespace

Strategy Session::State::strategy() const
{
    // A black environment has no luminance to sample by; every strategy gives black, so the simplest will do.
    if (!(input.environment->mean_luminance() > 0.0))
        return Strategy::uniform;
    return input.render.strategy == Strategy::automatic ? Strategy::two_step : input.render.strategy;
}

bool Session::State::needs_joint() const
{
    return strategy() != Strategy::uniform && strategy() != Strategy::environment;
}

std::uint64_t Session::State::grid_bytes() const { return joint.bytes() + stats.visibility_bytes; }

void Session::State::validate(const SessionInput& changed, SweepMode sweep_mode, int sweep_threads) const
{
    if (device) {
        validate_with_device(changed);
        device->require_memory(changed);
        return;
    }
    validate_with_memory(changed, sweep_mode, sweep_threads, grid_bytes());
}

void Session::State::restart_film()
{
    if (device) {
        device->clear_film(film.width(), film.height());
        film.grown(0, *device);
    } else {
        film.clear();
    }
    const bool stratified = input.render.resolved().random_numbers == RandomNumbers::stratified;
    film.set_draws(stratified ? Draws::stratified : Draws::independent);
}

void Session::State::resize_film()
{
    if (film.width() != input.image.width || film.height() != input.image.height)
        film = Film(input.image.width, input.image.height);
    restart_film();
    stats.film_bytes = Film::bytes_needed(input.image.width, input.image.height);
    if (device)
        return;
    const std::size_t pixels =
        static_cast<std::size_t>(input.image.width) * static_cast<std::size_t>(input.image.height);
    sample_color = AlignedArray<float>(pixels * 3);
    sample_features = AlignedArray<float>(pixels * feature_count);
}

void Session::State::use_environment()
{
    light = input.environment;
    if (light->resolution() < input.visibility.directions)
        light = std::make_shared<Environment>(light->refined(input.visibility.directions));
    stats.environment_bytes = light->bytes();
    stale_light = true;
}

SceneView Session::State::view() const
{
    const ScalarGrid& volume = *input.volume;
    SceneView view;
    view.voxel_type = volume.type();
    view.voxels = volume.data();
    view.size = volume.size();
    view.voxel_from_world = linear(volume.voxel_from_world());
    view.world_from_voxel = linear(volume.world_from_voxel());
    view.transfer_function = input.transfer_function.view(volume.slope(), volume.intercept());
    view.majorants = majorants.view();
    view.directions.strategy = strategy();
    view.directions.environment = light->view();
    view.directions.joint = joint.view();
    view.camera = camera_view(input.camera, input.image, volume);
    view.background = input.image.show_environment ? BackgroundLight::shown : BackgroundLight::hidden;
    const RenderSettings render = input.render.resolved();
    view.draws = film.draws();
    view.shadow_rays = render.shadow_rays;
    view.seed = render.seed;
    return view;
}

void Session::State::update_bounds()
{
    if (stale_bounds) {
        const Stopwatch watch(stats.bounds_s);
        if (device) {
            device->set_volume(input.volume);
        } else {
            bounds = BoundsGrid(*input.volume);
            raw_range = lumisweep::raw_range(*input.volume);
        }
        stale_bounds = false;
    }
}

void Session::State::update_majorants()
{
    update_bounds();
    if (stale_light && device)
        device->set_environment(light);
    stale_light = false;
    if (stale_majorants) {
        const Stopwatch watch(stats.majorants_s);
        if (device) {
            device->set_transfer_function(input.transfer_function);
            update_device_stats();
        } else {
            majorants = MajorantGrid(bounds, input.transfer_function);
            stats.majorant_bytes = majorants.bytes() + bounds.bytes();
        }
        stale_majorants = false;
    }
}

void Session::State::fit_visibility()
{
    const VisibilitySettings& settings = input.visibility;
    const Vec3i& size = input.volume->size();
    if (visibility && visibility->last_read().cells() == VisibilityGrid::cells_of(size, settings.cell) &&
        visibility->last_read().directions_per_side() == settings.directions)
        return;
    background.stop();
    visibility.reset(); // the old one first
    stats.visibility_bytes = 0;
    use_visibility(VisibilityGrid(size, settings.cell, settings.directions));
}

void Session::State::use_visibility(VisibilityGrid grid)
{
    if (device) {
        device->set_visibility(std::move(grid));
        stale_joint = true;
        return;
    }
    background.stop();
    const int spare = LiveVisibility::spare_slots(grid.directions_per_side(), background_threads);
    visibility = std::make_unique<LiveVisibility>(std::move(grid), spare);
    stats.visibility_bytes = visibility->bytes();
    stale_joint = true;
}

void Session::State::rethrow()
{
    try {
        background.rethrow();
    } catch (...) {
        sweeping = false;
        sweep_failed = true;
        throw;
    }
}

bool Session::State::sweep_now(const std::atomic<bool>* cancel)
{
    drop_sweep();
    background.stop();
    const VisibilitySettings& settings = input.visibility;
    if (device) {
        ++stats.classifications;
        ++stats.sweeps;
        stale_visibility = !device->sweep(settings, cancel, stats);
        stale_joint = true;
        update_device_stats();
        return !stale_visibility;
    }
    const Vec3i& size = input.volume->size();
    // A joint grid that stays is rebuilt in place, which saves its allocation; where memory is short, sweeps need it.
    const std::uint64_t sweep_needs =
        extinction_bytes(size, settings) + sweep_scratch_bytes(size, settings, tbb::this_task_arena::max_concurrency());
    if (joint.bytes() > 0 && available_memory() / 2 < sweep_needs) {
        joint = JointGrid();
        stale_joint = true;
    }
    ExtinctionGrid extinction;
    {
        const Stopwatch watch(stats.classify_s);
        extinction = classify(*input.volume, raw_range, input.transfer_function, sweep_mip_level(size, settings.rays),
                              ExtinctionLayouts::with_transposed, cancel);
        ++stats.classifications;
    }
    if (is_cancelled(cancel))
        return false;
    const Stopwatch watch(stats.sweep_s);
    fit_visibility();
    stats.last_sweep = sweep_visibility(visibility->settled(), extinction, settings, {}, cancel);
    ++stats.sweeps;
    stats.visibility_bytes = visibility->bytes();
    if (is_cancelled(cancel))
        return false;
    stale_visibility = false;
    stale_joint = true;
    return true;
}

void Session::State::sweep_in_background()
{
    if (device || sweeping || sweep_failed || !stale_visibility || mode != SweepMode::in_background || !needs_joint())
        return;
    if (stale_bounds)
        return; // the next pass takes them first
    fit_visibility();
    sweeping_stats = std::make_shared<LiveSweepStats>();
    LiveSweepInput job;
    job.volume = input.volume;
    job.range = raw_range;
    job.transfer_function = input.transfer_function;
    job.visibility = input.visibility;
    job.threads = background_threads;
    background.start([grid = visibility.get(), stats_of_task = sweeping_stats, job = std::move(job)](
                         const std::atomic<bool>& cancelled) { sweep_live(*grid, job, cancelled, *stats_of_task); });
    sweeping = true;
    ++stats.classifications;
    ++stats.sweeps;
}

void Session::State::drop_sweep()
{
    background.cancel();
    sweeping = sweep_failed = false;
    stale_visibility = true;
}

bool Session::State::update_joint(const std::atomic<bool>* cancel)
{
    const JointFactor factor =
        strategy() == Strategy::visibility ? JointFactor::visibility_only : JointFactor::visibility_times_light;
    if (device) {
        if (!stale_joint)
            return true;
        const Stopwatch watch(stats.joint_s);
        device->build_joint(factor, input.visibility.epsilon);
        ++stats.joint_builds;
        stale_joint = false;
        update_device_stats();
        return true;
    }
    const bool ended = sweeping && !background.busy(); // looked at before what is published
    const std::uint64_t published = visibility->published();
    if (stale_joint || (published != published_in_joint && (ended || since_build_s >= 3.0 * joint_build_s))) {
        joint_build_s = since_build_s = 0.0;
        {
            const Stopwatch watch(joint_build_s);
            stale_joint = true; // unless all goes well
            visibility->read([&](const VisibilityGrid& grid) {
                stale_joint =
                    !joint.build(grid, input.volume->size(), *light, factor, input.visibility.epsilon, cancel);
            });
        }
        if (stale_joint)
            return false;
        stats.joint_s += joint_build_s;
        ++stats.joint_builds;
        stats.joint_bytes = joint.bytes();
        published_in_joint = published;
    }
    if (!ended)
        return true;
    rethrow();
    sweeping = stale_visibility = false;
    stats.classify_s += sweeping_stats->classify_s;
    stats.sweep_s += sweeping_stats->sweep_s;
    stats.last_sweep = sweeping_stats->sweep;
    stats.visibility_bytes = visibility->bytes();
    return true;
}

PassEnd Session::State::render_pass(const std::atomic<bool>* cancel)
{
    const Stopwatch watch(stats.render_s), since_build(since_build_s);
    if (!device)
        return render_on_host(cancel);
    // Begins the pass; wait_for_passes() takes the rest of its time.
    const PassEnd end = device->render_pass(view(), film.samples(), cancel);
    if (end == PassEnd::complete)
        film.grown(film.samples() + 1, *device);
    return end;
}

void Session::State::wait_for_passes()
{
    const Stopwatch watch(stats.render_s);
    film.arrays();
}

PassEnd Session::State::render_on_host(const std::atomic<bool>* cancel)
{
    const SampleView samples{sample_color.data(), sample_features.data()};
    PassCounts counts;
    const auto discard = [&] {
        std::fill(sample_color.begin(), sample_color.end(), 0.0F);
        std::fill(sample_features.begin(), sample_features.end(), 0.0F);
    };
    PassEnd end = PassEnd::cancelled;
    try {
        end = host->render_pass(view(), samples, film.samples(), cancel, counts);
    } catch (...) {
        discard();
        throw;
    }
    if (end == PassEnd::cancelled) {
        discard();
        return end;
    }
    film.add(samples);
    stats.counts += counts;
    return end;
}

void Session::State::update_device_stats()
{
    const DeviceScene::Bytes bytes = device->bytes();
    stats.film_bytes = bytes.film;
    stats.visibility_bytes = bytes.visibility;
    stats.joint_bytes = bytes.joint;
    stats.majorant_bytes = bytes.majorants;
}

} // namespace lumisweep
