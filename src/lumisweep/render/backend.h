// What a backend does for a session: one sample of every pixel.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lumisweep/render/path_state.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep {

/// Counts of a pass, for --stats.
struct PassCounts {
    std::uint64_t paths = 0;        ///< camera rays
    std::uint64_t camera_steps = 0; ///< tentative collisions of camera segments
    std::uint64_t shadow_steps = 0; ///< tentative collisions of shadow segments

    PassCounts& operator+=(const PassCounts& other)
    {
        paths += other.paths;
        camera_steps += other.camera_steps;
        shadow_steps += other.shadow_steps;
        return *this;
    }
};

enum class PassEnd { complete, cancelled };

class Backend {
public:
    Backend() = default;
    Backend(const Backend&) = delete;
    Backend& operator=(const Backend&) = delete;
    virtual ~Backend() = default;

    virtual std::string device() const = 0; ///< "cpu"
    virtual std::string isa() const = 0;    ///< "baseline", "avx2", "avx512"

    /// Draws sample number `sample` of every pixel into `samples`, which must be all zeros. The result depends on the scene, its
    /// seed and the sample's number alone, not on threads. When *cancel becomes true the pass ends early, incomplete.
    virtual PassEnd render_pass(const SceneView& scene, const SampleView& samples, std::int64_t sample,
                                const std::atomic<bool>* cancel, PassCounts& counts) = 0;
};

} // namespace lumisweep
