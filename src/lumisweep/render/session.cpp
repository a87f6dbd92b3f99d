#include "lumisweep/render/session.h"

#include <algorithm>
#include <thread>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/error.h"
#include "lumisweep/render/backend.h"
#include "lumisweep/render/session_limits.h"
#include "lumisweep/render/session_state.h"

namespace lumisweep {

Session::Session(SessionInput input, std::shared_ptr<Backend> backend) : state_(std::make_unique<State>())
{
    state_->backend = std::move(backend);
    state_->host = dynamic_cast<HostBackend*>(state_->backend.get());
    if (auto* on_device = dynamic_cast<DeviceBackend*>(state_->backend.get()))
        state_->device = on_device->make_scene();
    state_->validate(input, state_->mode, state_->background_threads);
    state_->input = std::move(input);
    state_->use_environment();
    state_->resize_film();
    state_->stats.volume_bytes = state_->input.volume->bytes();
}

Session::~Session() = default;

void Session::set_volume(std::shared_ptr<const ScalarGrid> volume)
{
    SessionInput changed = state_->input;
    changed.volume = std::move(volume);
    state_->validate(changed, state_->mode, state_->background_threads);
    state_->input = std::move(changed);
    state_->stats.volume_bytes = state_->input.volume->bytes();
    state_->drop_sweep();
    state_->stale_bounds = state_->stale_majorants = state_->stale_joint = true;
    state_->restart_film();
}

void Session::prefetch(std::shared_ptr<const ScalarGrid> volume)
{
    require(volume != nullptr, "volume: is missing");
    if (!state_->device)
        return;
    state_->update_bounds(); // so that what was fetched before goes where it belongs first
    state_->device->prefetch(std::move(volume));
}

void Session::set_transfer_function(TransferFunction transfer_function)
{
    validate_extinction(*state_->input.volume, transfer_function);
    state_->input.transfer_function = std::move(transfer_function);
    state_->drop_sweep();
    state_->stale_majorants = true;
    state_->restart_film();
    state_->sweep_in_background();
}

void Session::set_environment(std::shared_ptr<const Environment> environment)
{
    require(environment != nullptr, "environment: is missing");
    SessionInput changed = state_->input;
    changed.environment = environment;
    state_->validate(changed, state_->mode, state_->background_threads);
    state_->input.environment = std::move(environment);
    state_->use_environment();
    state_->stale_joint = true;
    state_->restart_film();
}

void Session::set_camera(const Camera& camera)
{
    camera.validate();
    state_->input.camera = camera;
    state_->restart_film();
}

void Session::set_image(const ImageSettings& image)
{
    SessionInput changed = state_->input;
    changed.image = image;
    state_->validate(changed, state_->mode, state_->background_threads);
    state_->input.image = image;
    state_->resize_film();
}

void Session::set_render(const RenderSettings& render)
{
    render.validate();
    const Strategy before = state_->strategy();
    state_->input.render = render;
    state_->stale_joint = state_->stale_joint || state_->strategy() != before;
    state_->restart_film();
}

void Session::set_visibility(const VisibilitySettings& visibility)
{
    visibility.validate();
    VisibilitySettings with_old_epsilon = visibility;
    with_old_epsilon.epsilon = state_->input.visibility.epsilon;
    if (with_old_epsilon != state_->input.visibility) {
        SessionInput changed = state_->input;
        changed.visibility = visibility;
        state_->validate(changed, state_->mode, state_->background_threads);
        state_->drop_sweep();
    }
    state_->input.visibility = visibility;
    state_->use_environment();
    state_->stale_joint = true;
    state_->restart_film();
    state_->sweep_in_background();
}

void Session::set_sweep_mode(SweepMode mode, int background_threads)
{
    require(background_threads >= 0 && background_threads <= 4096,
            "background sweeps: {} threads (use 1 to 4096, or 0 for half of the machine's)", background_threads);
    const int threads = background_threads > 0 ? background_threads
                                               : std::max(static_cast<int>(std::thread::hardware_concurrency()) / 2, 1);
    if (mode == state_->mode && threads == state_->background_threads)
        return;
    state_->validate(state_->input, mode, threads);
    if (state_->sweeping)
        state_->drop_sweep();
    state_->mode = mode;
    state_->background_threads = threads;
    state_->sweep_in_background();
}

void Session::replace_visibility(VisibilityGrid grid)
{
    State& s = *state_;
    const Vec3i cells = VisibilityGrid::cells_of(s.input.volume->size(), s.input.visibility.cell);
    require(grid.cells() == cells && grid.directions_per_side() == s.input.visibility.directions,
            "visibility grid: {} × {} × {} cells of {}² directions do not fit this session", grid.cells().x,
            grid.cells().y, grid.cells().z, grid.directions_per_side());
    s.drop_sweep();
    s.use_visibility(std::move(grid));
    s.stale_visibility = false;
}

bool Session::prepare(const std::atomic<bool>* cancel)
{
    State& s = *state_;
    s.rethrow();
    s.update_majorants();
    if (!s.needs_joint())
        return true;
    if (s.stale_visibility && s.waits_for_sweeps()) {
        if (!s.sweep_now(cancel))
            return false;
    } else if (s.stale_visibility) {
        s.sweep_failed = false;
        s.sweep_in_background();
        if (!s.background.wait(cancel))
            return false;
    }
    return s.update_joint(cancel);
}

PassEnd Session::render_pass(const std::atomic<bool>* cancel)
{
    State& s = *state_;
    if (s.waits_for_sweeps()) {
        if (!prepare(cancel))
            return PassEnd::cancelled;
    } else {
        s.rethrow();
        s.update_majorants();
        if (s.needs_joint()) {
            s.sweep_in_background();
            if (!s.update_joint(cancel))
                return PassEnd::cancelled;
        }
    }
    if (is_cancelled(cancel))
        return PassEnd::cancelled;
    return s.render_pass(cancel);
}

void Session::wait_for_passes() { state_->wait_for_passes(); }

const Film& Session::film() const { return state_->film; }

void Session::restore_film(Film film)
{
    require(film.width() == state_->input.image.width && film.height() == state_->input.image.height,
            "checkpoint: its image is {} × {}, not {} × {}", film.width(), film.height(), state_->input.image.width,
            state_->input.image.height);
    film.set_draws(state_->film.draws());
    if (state_->device)
        state_->device->restore_film(film);
    state_->film = std::move(film);
}

const VisibilityGrid& Session::visibility() const
{
    static const VisibilityGrid none;
    if (state_->device)
        return state_->device->visibility();
    return state_->visibility ? state_->visibility->last_read() : none;
}

bool Session::sweeping() const { return state_->sweeping; }
const SessionInput& Session::input() const { return state_->input; }
const SessionStats& Session::stats() const
{
    if (state_->device)
        state_->stats.counts = state_->device->counts();
    return state_->stats;
}
const Backend& Session::backend() const { return *state_->backend; }

} // namespace lumisweep
