// What a backend does for a session: add samples to a film.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "lumisweep/render/film.h"

namespace lumisweep {

struct SceneView;

/// Counts of one pass, for --stats.
struct PassCounts {
    std::uint64_t paths = 0;        ///< camera rays
    std::uint64_t camera_steps = 0; ///< tentative collisions of camera segments
    std::uint64_t shadow_steps = 0; ///< tentative collisions of shadow segments
};

enum class PassEnd { complete, cancelled };

class Backend {
public:
    virtual ~Backend() = default;
    virtual std::string device() const = 0; ///< "cpu"
    virtual std::string isa() const = 0;    ///< "baseline", "avx2", "avx512"

    /// Adds sample number `sample` of every pixel. The result depends on the scene, the seed and the sample's number alone,
    /// not on threads. When *cancel becomes true the pass ends early, and the film then holds an incomplete pass.
    virtual PassEnd render_pass(const SceneView& scene, const FilmView& film, std::int64_t sample,
                                const std::atomic<bool>* cancel, PassCounts& counts) = 0;
};

} // namespace lumisweep
