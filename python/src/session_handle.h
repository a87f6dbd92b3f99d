// A session as Python holds it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tbb/task_arena.h>

#include "bindings.h"
#include "sampler.h"

namespace lumisweep::python {

using Progress = std::function<py::object(std::int64_t samples, double seconds)>;

/// A session with the Python objects that it was made from. Everything that may wait for a background sweep is done
/// without the interpreter: that thread may let go of an array. Meanwhile signal handlers and other Python threads may
/// run, and find the session busy; while a progress callback runs the film and the settings can be read.
class SessionHandle {
public:
    SessionHandle(std::shared_ptr<VolumeHandle> volume, std::shared_ptr<EnvironmentHandle> environment,
                  SessionInput input, StopCriterion stop, std::unique_ptr<tbb::task_arena> arena,
                  std::shared_ptr<Backend> backend);
    ~SessionHandle();
    SessionHandle(const SessionHandle&) = delete;
    SessionHandle& operator=(const SessionHandle&) = delete;

    // Throw Error while the session is busy.
    const Session& session() const;
    const SessionInput& input() const { return session().input(); }

    const std::shared_ptr<VolumeHandle>& volume() const { return volume_; }
    const std::shared_ptr<EnvironmentHandle>& environment() const { return environment_; }
    const StopCriterion& stop() const { return stop_; }
    int threads() const { return arena_->max_concurrency(); }

    /// A call of a setter.
    void edit(const std::function<void(Session&)>& call);
    void prefetch(const std::shared_ptr<VolumeHandle>& volume);
    void set_volume(std::shared_ptr<VolumeHandle> volume);
    void set_environment(std::shared_ptr<EnvironmentHandle> environment);
    void set_transfer_function(const TransferFunction& transfer_function);
    void set_visibility_settings(const VisibilitySettings& settings);
    void set_sweep_mode(SweepMode mode, int threads);

    void prepare();
    void render(const StopCriterion& stop, const Progress& progress);
    ImageHandle image() const;

    /// The grid that directions are drawn by. Where the strategy draws by none: the one that was set, or swept before.
    std::shared_ptr<VisibilityHandle> visibility();
    void set_visibility(const std::shared_ptr<VisibilityHandle>& visibility);
    SamplerHandle sampler(const std::optional<std::string>& name);

    std::vector<std::string> notes, warnings;

private:
    enum class Use { none, reading, all };
    /// Begins and ends with the interpreter's lock held, which is what guards free_for_.
    class Busy {
    public:
        explicit Busy(SessionHandle& handle);
        ~Busy() { handle_.free_for_ = Use::all; }
        Busy(const Busy&) = delete;
        Busy& operator=(const Busy&) = delete;

    private:
        SessionHandle& handle_;
    };
    void require_free(Use wanted) const;
    void tell(const Progress& progress, double elapsed_s);

    std::shared_ptr<VolumeHandle> volume_;
    std::shared_ptr<EnvironmentHandle> environment_;
    std::shared_ptr<VisibilityHandle>
        kept_visibility_; // of the present volume, transfer function and settings, or null
    StopCriterion stop_;
    SweepMode mode_ = SweepMode::before_pass;
    double render_s_ = 0.0; // of the passes in the film
    Use free_for_ = Use::all;
    std::unique_ptr<tbb::task_arena> arena_;
    std::unique_ptr<Session> session_;
};

} // namespace lumisweep::python
