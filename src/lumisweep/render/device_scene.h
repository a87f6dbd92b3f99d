// A session's scene on a device that keeps it in memory of its own and runs all stages of the graph there: what a
// session with such a backend asks for in place of doing it itself. When, the session decides.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "lumisweep/render/film.h"
#include "lumisweep/render/scene_view.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

struct SessionInput; // render/session.h
struct SessionStats; // render/session.h

/// Stages may return before the device is done; each waits for those that it needs. All throw Error when the device's
/// memory is short or the device fails.
class DeviceScene : public FilmSource {
public:
    /// Throws Error unless the device's memory is enough for all that this input needs. May give back what is kept for
    /// later.
    virtual void require_memory(const SessionInput& input) = 0;
    /// Copies the voxels and finds their bounds, unless they are the ones that prefetch() was called with.
    virtual void set_volume(std::shared_ptr<const ScalarGrid> volume) = 0;
    /// Begins to copy the voxels of the volume to come, while the device renders the present one.
    virtual void prefetch(std::shared_ptr<const ScalarGrid> volume) = 0;
    /// Majorants of the volume under a transfer function; sweeps are of this one, too.
    virtual void set_transfer_function(const TransferFunction& transfer_function) = 0;
    virtual void set_environment(std::shared_ptr<const Environment> environment) = 0;

    /// Classifies and sweeps into the visibility grid. False when *cancel became true; then what the grid holds is of
    /// no use.
    virtual bool sweep(const VisibilitySettings& settings, const std::atomic<bool>* cancel, SessionStats& stats) = 0;
    /// The product of the visibility grid with the light, or the grid alone.
    virtual void build_joint(JointFactor factor, double epsilon) = 0;
    /// For looking at: a copy, good until the next call of anything else. Empty before the first sweep.
    virtual const VisibilityGrid& visibility() = 0;
    virtual void set_visibility(VisibilityGrid grid) = 0;

    /// An empty film; passes that are not yet in its sums are given up. Does not fail: memory is taken with the next
    /// pass.
    virtual void clear_film(int width, int height) = 0;
    virtual void restore_film(const Film& film) = 0;
    /// Begins to draw sample number `sample` of every pixel; passes are added in their order, each wholly or not at
    /// all. `scene` has everything but what is in the device's memory, and must not change before clear_film(). May
    /// wait for earlier passes.
    virtual PassEnd render_pass(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel) = 0;
    /// Of all passes since the scene was made, for which it waits.
    virtual PassCounts counts() = 0;

    struct Bytes {
        std::uint64_t volume = 0, visibility = 0, joint = 0, environment = 0, film = 0, majorants = 0;
    };
    virtual Bytes bytes() const = 0;
};

} // namespace lumisweep
