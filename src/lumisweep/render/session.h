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
    /// How often each was begun: an edit of the light, of the strategy or of epsilon shall not classify or sweep.
    int classifications = 0, sweeps = 0, joint_builds = 0;
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

/// When the sweeps of an edit are done. V only chooses directions, so the image's mean is right in both.
enum class SweepMode {
    /// The next pass waits for them. Images are the same to the bit, whatever the threads.
    before_pass,
    /// Passes go on at once, with the visibility that is there (all visible at first), while a thread beside them
    /// classifies and sweeps; every few passes take up the directions that have been published. An edit cancels the
    /// sweep that runs. Single images depend on the timing, within their noise. On a device, where sweeps take
    /// milliseconds, the same as before_pass.
    in_background,
};

class Session {
public:
    /// `backend` from make_backend() (backends/make_backend.h). Throws Error for invalid input, and when the
    /// memory that rendering will need is not there.
    Session(SessionInput input, std::shared_ptr<Backend> backend);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    void set_volume(std::shared_ptr<const ScalarGrid> volume); ///< e.g. the next frame of a time series
    /// The volume that set_volume() will be called with next: a device begins to copy it while passes go on. After a
    /// set_volume() that has not yet been followed by a pass it takes that volume up first.
    void prefetch(std::shared_ptr<const ScalarGrid> volume);
    void set_transfer_function(TransferFunction transfer_function);
    void set_environment(std::shared_ptr<const Environment> environment);
    void set_camera(const Camera& camera);
    void set_image(const ImageSettings& image);
    void set_render(const RenderSettings& render);
    void set_visibility(const VisibilitySettings& visibility);
    /// `background_threads` is the concurrency of the task arena that background sweeps have of their own; 0 takes half
    /// of the machine's. Throws Error when the memory for it is not there. What a background sweep throws reaches the
    /// caller of the next render_pass() or prepare(), unless an edit has made that sweep useless; then passes go on
    /// with the visibility that is there, and the next edit or prepare() tries again.
    void set_sweep_mode(SweepMode mode, int background_threads = 0);
    /// Replaces the visibility grid by one of the same shape; the mean image does not depend on it (the poisoned-cache
    /// test).
    void replace_visibility(VisibilityGrid grid);

    /// Brings everything but the film up to date: majorants, sweeps, joint grid; waits for a background sweep. Passes
    /// do it by themselves before they begin (before_pass), or bit by bit. When *cancel becomes true it returns early.
    /// False when *cancel became true before all was done.
    bool prepare(const std::atomic<bool>* cancel = nullptr);
    /// Adds one sample to every pixel. Returns cancelled, with the film as it was before, when *cancel became true. On
    /// a device passes are begun here and run on; looking at the film's sums, or beginning many more, waits for them.
    PassEnd render_pass(const std::atomic<bool>* cancel = nullptr);

    /// Waits until all passes that were begun are in the film's sums; only a device has passes under way.
    void wait_for_passes();

    const Film& film() const;
    /// For resuming from a checkpoint: puts the film's sums and sample count back. Sizes must match.
    void restore_film(Film film);
    /// What the joint grid was last made from; good until the next call of anything but a getter, and while no
    /// background sweep runs (after prepare()). Empty before the first sweep.
    const VisibilityGrid& visibility() const;
    /// A background sweep is under way or about to be taken up.
    bool sweeping() const;
    const SessionInput& input() const;
    const SessionStats& stats() const;
    const Backend& backend() const;

    /// Bytes that preparing, rendering and writing the image will take beyond the volume and the environment
    /// themselves; sweeps with the present arena's threads, or `background_threads` beside rendering.
    static std::uint64_t memory_needed(const Vec3i& volume_size, const ImageSettings& image, Strategy strategy,
                                       const VisibilitySettings& visibility, SweepMode mode = SweepMode::before_pass,
                                       int background_threads = 1);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace lumisweep
