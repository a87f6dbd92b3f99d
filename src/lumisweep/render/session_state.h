// What a session holds, and what each stage of the graph makes of it.
#pragma once

#include <cstdint>
#include <memory>

#include "lumisweep/render/backend.h"
#include "lumisweep/render/background_task.h"
#include "lumisweep/render/device_scene.h"
#include "lumisweep/render/scene_view.h"
#include "lumisweep/render/session.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/visibility/live_sweep.h"
#include "lumisweep/visibility/live_visibility.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/raw_range.h"

namespace lumisweep {

struct Session::State {
    SessionInput input;
    std::shared_ptr<Backend> backend;
    HostBackend* host = nullptr;         // the backend, or null where a device has the scene:
    std::unique_ptr<DeviceScene> device; // bounds to sample_features are not used then, nor is the background
    SessionStats stats;

    BoundsGrid bounds;
    RawRange raw_range;
    MajorantGrid majorants;
    std::unique_ptr<LiveVisibility> visibility; // null before the first sweep
    JointGrid joint;
    std::shared_ptr<const Environment> light; // input.environment, with at least as many texels a side as directions
    Film film;
    AlignedArray<float> sample_color, sample_features;

    // What is out of date; each implies the work of the stages below it that use it.
    bool stale_bounds = true, stale_majorants = true, stale_visibility = true, stale_joint = true;
    bool stale_light = true; // on the device

    SweepMode mode = SweepMode::before_pass;
    int background_threads = 1;
    bool sweeping = false;     // a background sweep of the present input runs, or has ended and is not yet taken up
    bool sweep_failed = false; // and the caller knows: not tried again before the next edit or prepare()
    std::shared_ptr<LiveSweepStats> sweeping_stats;
    std::uint64_t published_in_joint = 0;            // directions that the joint grid knows
    double joint_build_s = 0.0, since_build_s = 0.0; // of the last build, and rendering since then
    BackgroundTask background;                       // last: it uses the others

    /// Whose density directions are drawn from: one of the papers' five.
    Strategy strategy() const;
    bool needs_joint() const;

    /// Whether passes wait for sweeps. On a device they take milliseconds and always do.
    bool waits_for_sweeps() const { return device != nullptr || mode == SweepMode::before_pass; }

    /// Of the visibility and the joint grid.
    std::uint64_t grid_bytes() const;
    /// Checks the input and that the host's memory is enough for it.
    void validate(const SessionInput& changed, SweepMode sweep_mode, int sweep_threads) const;

    void resize_film();
    /// Empties the film.
    void restart_film();
    void use_environment();
    SceneView view() const;

    /// Of a volume that has not been taken up.
    void update_bounds();
    /// What the image's mean depends on: bounds, majorants, and the light.
    void update_majorants();
    /// Classifies and sweeps in this thread's arena; false when cancelled.
    bool sweep_now(const std::atomic<bool>* cancel);
    /// Has the sweep done in the background, unless it is under way or not needed.
    void sweep_in_background();
    /// The input of sweeps has changed: what runs is of no use any more.
    void drop_sweep();
    /// Brings the joint grid up to date with what is published. When nothing but published directions has changed, at
    /// most a quarter of the time goes into that, until all are there. When cancelled it is left stale.
    /// False when *cancel became true.
    bool update_joint(const std::atomic<bool>* cancel);
    /// Takes a grid of the input's shape in place of the present one.
    void use_visibility(VisibilityGrid grid);
    /// Throws what the background sweep has thrown, once.
    void rethrow();
    PassEnd render_pass(const std::atomic<bool>* cancel);
    void wait_for_passes();

private:
    void fit_visibility();
    PassEnd render_on_host(const std::atomic<bool>* cancel);
    void update_device_stats();
};

} // namespace lumisweep
