// What a render is told: plain structs with the scene file's names and defaults.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "lumisweep/math/vec.h"
#include "lumisweep/render/pass.h"
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

/// How the random numbers of a pixel's samples relate: drawn independently, or spread evenly over pixel, lens, depth
/// and direction (math/stratified.h), 16 samples at a time. The mean is the same.
enum class RandomNumbers { automatic, independent, stratified };
/// In the order of the enumerators.
inline constexpr std::array<std::string_view, 3> random_numbers_names{"auto", "independent", "stratified"};

struct RenderSettings {
    Strategy strategy = Strategy::automatic;
    std::uint64_t seed = 0;
    /// Automatic: stratified with Strategy::automatic; independent, as in the papers, with the papers' strategies.
    RandomNumbers random_numbers = RandomNumbers::automatic;
    /// Collisions that are drawn along each camera ray, evenly spread over its opacity, each with a shadow ray; 1 … 64.
    /// 0 is automatic: automatic_shadow_rays with Strategy::automatic, 1 with the papers' strategies.
    int shadow_rays = 0;

    /// Throws Error naming the entry that is out of range.
    void validate() const;
    /// With what automatic settings stand for filled in.
    RenderSettings resolved() const;
};

inline constexpr int automatic_shadow_rays = 3;

} // namespace lumisweep
