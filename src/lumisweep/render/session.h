// A session: the graph volume → majorants, sweeps, joint grid → film, its versions, and progressive rendering.
//
// Setters may be called between passes in any order; each marks only what depends on it (docs/architecture.md), and the
// next pass redoes exactly that. Not thread-safe, except for `cancel`.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "lumisweep/light/environment.h"
#include "lumisweep/render/film.h"
#include "lumisweep/render/pass.h"
#include "lumisweep/render/settings.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/visibility_grid.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

class Backend; // render/backend.h

/// Wall-clock seconds of the stages, accumulated over the session, and what they hold.
struct SessionStats {
    double bounds_s = 0.0, majorants_s = 0.0, classify_s = 0.0, sweep_s = 0.0, joint_s = 0.0, render_s = 0.0;
    PassCounts counts;
    SweepStats last_sweep;
    std::uint64_t volume_bytes = 0, visibility_bytes = 0, joint_bytes = 0, environment_bytes = 0, film_bytes = 0,
                  majorant_bytes = 0;
};

/// What set_* calls describe, in one struct: enough to start a session with one call.
struct SessionInput {
    std::shared_ptr<const ScalarGrid> volume;
    TransferFunction transfer_function;
    std::shared_ptr<const Environment> environment;
    Camera camera;
    ImageSettings image;
    RenderSettings render;
    VisibilitySettings visibility;
};

class Session {
public:
    /// `backend` from make_cpu_backend() (backends/cpu/cpu_backend.h). Throws Error for invalid input, and when the
    /// memory that rendering will need is not there.
    Session(SessionInput input, std::shared_ptr<Backend> backend);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    void set_volume(std::shared_ptr<const ScalarGrid> volume); ///< e.g. the next frame of a time series
    void set_transfer_function(TransferFunction transfer_function);
    void set_environment(std::shared_ptr<const Environment> environment);
    void set_camera(const Camera& camera);
    void set_image(const ImageSettings& image);
    void set_render(const RenderSettings& render);
    void set_visibility(const VisibilitySettings& visibility);
    /// Replaces the visibility grid by one of the same shape; the mean image does not depend on it (the poisoned-cache
    /// test).
    void replace_visibility(VisibilityGrid grid);

    /// Brings everything but the film up to date: majorants, sweeps, joint grid. render_pass() does it by itself.
    void prepare(const std::atomic<bool>* cancel = nullptr);
    /// Adds one sample to every pixel. Returns cancelled, with the film as it was before, when *cancel became true.
    PassEnd render_pass(const std::atomic<bool>* cancel = nullptr);

    const Film& film() const;
    /// For resuming from a checkpoint: puts the film's sums and sample count back. Sizes must match.
    void restore_film(Film film);
    const VisibilityGrid& visibility() const;
    const SessionInput& input() const;
    const SessionStats& stats() const;
    const Backend& backend() const;

    /// Bytes that preparing, rendering and writing the image will take beyond the volume and the environment
    /// themselves.
    static std::uint64_t memory_needed(const Vec3i& volume_size, const ImageSettings& image, Strategy strategy,
                                       const VisibilitySettings& visibility);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace lumisweep
