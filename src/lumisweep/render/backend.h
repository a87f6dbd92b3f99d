// What a backend does for a session: one sample of every pixel.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lumisweep/render/pass.h"

namespace lumisweep {

struct SceneView; // render/scene_view.h

class Backend {
public:
    Backend() = default;
    Backend(const Backend&) = delete;
    Backend& operator=(const Backend&) = delete;
    virtual ~Backend() = default;

    virtual std::string device() const = 0; ///< "cpu"
    virtual std::string isa() const = 0;    ///< "baseline", "avx2", "avx512"

    /// Draws sample number `sample` of every pixel into `samples`, which must be all zeros. The result depends on the
    /// scene, its seed and the sample's number alone, not on threads. When *cancel becomes true the pass ends early,
    /// incomplete.
    virtual PassEnd render_pass(const SceneView& scene, const SampleView& samples, std::int64_t sample,
                                const std::atomic<bool>* cancel, PassCounts& counts) = 0;
};

} // namespace lumisweep
