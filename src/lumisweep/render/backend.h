// What a backend does for a session: it draws samples of every pixel of the session's scene, or it keeps the scene
// itself.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "lumisweep/render/pass.h"

namespace lumisweep {

class DeviceScene; // render/device_scene.h
struct SceneView;  // render/scene_view.h

/// A HostBackend or a DeviceBackend.
class Backend {
public:
    Backend() = default;
    Backend(const Backend&) = delete;
    Backend& operator=(const Backend&) = delete;
    virtual ~Backend() = default;

    virtual std::string device() const = 0;          ///< "cpu", "cuda"
    virtual std::string isa() const = 0;             ///< "baseline", "avx2", "avx512"; of CUDA "sm_90" and the like
    virtual std::string model() const { return ""; } ///< of a GPU, as it calls itself
};

/// Draws from what the session has in the host's memory.
class HostBackend : public Backend {
public:
    /// Draws sample number `sample` of every pixel into `samples`, which must be all zeros. The result depends on the
    /// scene, its seed and the sample's number alone, not on threads. When *cancel becomes true the pass ends early,
    /// incomplete.
    virtual PassEnd render_pass(const SceneView& scene, const SampleView& samples, std::int64_t sample,
                                const std::atomic<bool>* cancel, PassCounts& counts) = 0;
};

/// Keeps sessions' scenes in a device's memory.
class DeviceBackend : public Backend {
public:
    virtual std::unique_ptr<DeviceScene> make_scene() = 0;
};

} // namespace lumisweep
