// Natural light: radiance over the sphere as an equal-area octahedral map, with its luminance quadtree.
//
// Texels lie in Morton order (math/morton.h), so that the four children of node m of one level are 4m … 4m+3 of the
// next. Every texel covers 4π/n² sr (equal-area octahedral map, Clarberg 2008; math/octahedral.h), and radiance is
// constant over it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/light/environment_view.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

class Environment {
public:
    /// Takes n × n texels of RGB radiance in Morton order. Throws Error unless n is a power of two in [1, 16384] and
    /// all radiance is between 0 and 1e30.
    Environment(int n, AlignedArray<float> radiance_rgb);
    Environment() : Environment(constant({1.0, 1.0, 1.0})) {}

    /// The same radiance from everywhere (n = 8).
    static Environment constant(const Vec3d& radiance);

    /// The same light on an n × n map, n a power of two ≥ resolution(): every texel becomes a square of equal ones.
    Environment refined(int n) const;

    int resolution() const { return n_; }
    std::size_t bytes() const { return radiance_.bytes() + luminance_.bytes(); }
    EnvironmentView view() const;
    /// Radiance from a direction in world space (towards the light).
    Vec3d radiance(const Vec3d& w_world) const;
    /// Mean luminance over the sphere.
    double mean_luminance() const { return luminance_[0]; }

private:
    int n_ = 0;
    AlignedArray<float> radiance_;
    AlignedArray<float> luminance_;
};

/// Rec. 709 luminance.
inline double luminance(double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; }

} // namespace lumisweep
