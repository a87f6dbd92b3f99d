#include "session_handle.h"

#include <algorithm>
#include <chrono>

#include "lumisweep/render/backend.h"

namespace lumisweep::python {

namespace {

/// A borrowed array may have been written to since it was looked at.
void require_finite(const ScalarGrid& volume)
{
    require(volume.owns_voxels() || !any_infinite(volume),
            "session: the volume's array has infinite values by now (make a Volume of it again)");
}

} // namespace

SessionHandle::SessionHandle(std::shared_ptr<VolumeHandle> volume, std::shared_ptr<EnvironmentHandle> environment,
                             SessionInput input, StopCriterion stop, std::unique_ptr<tbb::task_arena> arena,
                             std::shared_ptr<Backend> backend)
    : volume_(std::move(volume)), environment_(std::move(environment)), stop_(stop), arena_(std::move(arena))
{
    input.volume = volume_->grid;
    input.environment = environment_->light;
    const py::gil_scoped_release release;
    arena_->execute([&] {
        require_finite(*input.volume);
        session_ = std::make_unique<Session>(std::move(input), std::move(backend));
    });
}

SessionHandle::~SessionHandle()
{
    const py::gil_scoped_release release;
    session_.reset();
}

SessionHandle::Busy::Busy(SessionHandle& handle) : handle_(handle)
{
    handle.require_free(Use::all);
    handle.free_for_ = Use::none;
}

void SessionHandle::require_free(Use wanted) const
{
    require(free_for_ == Use::all || (free_for_ == Use::reading && wanted == Use::reading),
            "session: is busy with another call (wait until that has returned)");
}

const Session& SessionHandle::session() const
{
    require_free(Use::reading);
    return *session_;
}

void SessionHandle::edit(const std::function<void(Session&)>& call)
{
    const Busy busy(*this);
    const py::gil_scoped_release release;
    arena_->execute([&] { call(*session_); });
    if (session_->film().samples() == 0)
        render_s_ = 0.0;
}

void SessionHandle::set_volume(std::shared_ptr<VolumeHandle> volume)
{
    require(volume != nullptr, "session: volume is None");
    edit([&](Session& s) {
        require_finite(*volume->grid);
        s.set_volume(volume->grid);
    });
    volume_ = std::move(volume);
    kept_visibility_.reset();
}

void SessionHandle::prefetch(const std::shared_ptr<VolumeHandle>& volume)
{
    require(volume != nullptr, "session: volume is None");
    edit([&](Session& s) {
        require_finite(*volume->grid);
        s.prefetch(volume->grid);
    });
}

void SessionHandle::set_environment(std::shared_ptr<EnvironmentHandle> environment)
{
    require(environment != nullptr, "session: environment is None");
    edit([&](Session& s) { s.set_environment(environment->light); });
    environment_ = std::move(environment);
}

void SessionHandle::set_transfer_function(const TransferFunction& transfer_function)
{
    edit([&](Session& s) { s.set_transfer_function(transfer_function); });
    kept_visibility_.reset();
}

void SessionHandle::set_visibility_settings(const VisibilitySettings& settings)
{
    VisibilitySettings before = input().visibility;
    edit([&](Session& s) { s.set_visibility(settings); });
    before.epsilon = settings.epsilon; // which V does not depend on
    if (before != settings)
        kept_visibility_.reset();
}

void SessionHandle::set_sweep_mode(SweepMode mode, int threads)
{
    // oneTBB complains on stderr when more are asked for than the machine has.
    edit([&](Session& s) { s.set_sweep_mode(mode, threads <= 4096 ? std::min(threads, all_threads()) : threads); });
    mode_ = mode;
}

void SessionHandle::prepare()
{
    const Busy busy(*this);
    run_interruptible(*arena_, [this](const std::atomic<bool>& cancel) { session_->prepare(&cancel); });
}

void SessionHandle::render(const StopCriterion& stop, const Progress& progress)
{
    const Busy busy(*this);
    run_interruptible(*arena_, [&](const std::atomic<bool>& cancel) {
        // Sweeps before passes are not rendering's time; a GPU knows no others.
        const bool waits = mode_ == SweepMode::before_pass || session_->backend().device() != "cpu";
        if (waits && !session_->prepare(&cancel))
            return;
        using Clock = std::chrono::steady_clock;
        Clock::time_point begin = Clock::now();
        const double before = render_s_;
        Stopping stopping(stop, session_->film());
        double elapsed_s = 0.0, told_s = -1.0;
        while (!stopping.met(elapsed_s) && session_->render_pass(&cancel) == PassEnd::complete) {
            const Clock::time_point end = Clock::now();
            elapsed_s = std::chrono::duration<double>(end - begin).count();
            render_s_ = before + elapsed_s;
            if (progress && elapsed_s - told_s >= 0.1) {
                told_s = elapsed_s;
                tell(progress, elapsed_s);
                begin += Clock::now() - end; // the callback's time is not rendering's
            }
        }
        session_->wait_for_passes();
        render_s_ = before + std::chrono::duration<double>(Clock::now() - begin).count();
    });
}

void SessionHandle::tell(const Progress& progress, double elapsed_s)
{
    if (interpreter_is_ending())
        return;
    const py::gil_scoped_acquire acquire;
    free_for_ = Use::reading;
    try {
        progress(session_->film().samples(), elapsed_s);
    } catch (...) {
        free_for_ = Use::none;
        throw;
    }
    free_for_ = Use::none;
}

ImageHandle SessionHandle::image() const
{
    require(session().film().samples() > 0, "session: no pass has been rendered (call render)");
    const Background background = input().image.show_environment ? Background::opaque : Background::transparent;
    return {annotated_image(*session_, render_s_), background};
}

std::shared_ptr<VisibilityHandle> SessionHandle::visibility()
{
    const Strategy strategy = input().render.strategy;
    if (strategy == Strategy::uniform || strategy == Strategy::environment ||
        !(input().environment->mean_luminance() > 0.0)) {
        if (!kept_visibility_) {
            const Busy busy(*this);
            const SessionInput& present = session_->input();
            kept_visibility_ = sweep(*present.volume, present.transfer_function, present.visibility, *arena_);
        }
        return kept_visibility_;
    }
    prepare();
    VisibilityGrid copy = copy_of(session().visibility(), input().volume->size(), input().visibility.cell);
    return std::make_shared<VisibilityHandle>(
        VisibilityHandle{std::make_shared<const VisibilityGrid>(std::move(copy)), {}});
}

void SessionHandle::set_visibility(const std::shared_ptr<VisibilityHandle>& visibility)
{
    require(visibility != nullptr, "session: visibility is None");
    VisibilityGrid grid = copy_of(*visibility->grid, input().volume->size(), input().visibility.cell);
    edit([&](Session& s) { s.replace_visibility(std::move(grid)); });
    kept_visibility_ = visibility;
}

SamplerHandle SessionHandle::sampler(const std::optional<std::string>& name)
{
    const Strategy strategy = name ? strategy_of(*name) : input().render.strategy;
    std::shared_ptr<VisibilityHandle> grid;
    if (strategy != Strategy::uniform && strategy != Strategy::environment)
        grid = visibility();
    const Busy busy(*this);
    const py::gil_scoped_release release;
    SamplerHandle made;
    arena_->execute([&] {
        const SessionInput& present = session_->input();
        made = make_sampler(strategy, present.volume, present.environment, grid ? grid->grid.get() : nullptr,
                            present.visibility.epsilon);
    });
    return made;
}

} // namespace lumisweep::python
