// What a render is told: plain structs with the scene file's names and defaults.
#pragma once

#include <array>
#include <cstdint>

#include "lumisweep/math/vec.h"
#include "lumisweep/sampling/strategy.h"

namespace lumisweep {

/// A thin-lens camera; lengths in world units.
struct Camera {
    Vec3d position{0.0, -500.0, 0.0};
    Vec3d target{0.0, 0.0, 0.0};
    Vec3d up{0.0, 0.0, 1.0};
    double vertical_fov_deg = 35.0; ///< spans the image's height; (0, 180)
    double lens_radius = 0.0;       ///< 0 is a pinhole
    double focus_distance = 0.0;    ///< along the view axis; 0 takes the target's distance

    /// Throws Error naming the entry ("camera.up") that is impossible.
    void validate() const;
    /// The focus distance with the default filled in.
    double focus() const;
    /// World to camera space, rigid: x to the right, y up, z along the view (OpenEXR's left-handed
    /// convention); row-major 4 × 4, for column vectors.
    std::array<double, 16> camera_from_world() const;
};

struct ImageSettings {
    int width = 512, height = 512; ///< 1 … 16384
    bool show_environment = true;  ///< false: the background is black, and transparent by alpha
    void validate() const;
};

struct RenderSettings {
    Strategy strategy = Strategy::two_step;
    std::uint64_t seed = 0;
};

} // namespace lumisweep
