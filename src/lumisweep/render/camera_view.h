// The thin-lens camera as kernels read it.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/trigonometry.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Positions are relative to the centre of the volume's box, in world units, so that single precision does not lose a
/// volume that lies far from the origin.
struct CameraView {
    Vec3f position{0.0F, 0.0F, 0.0F};
    Vec3f center_voxel{0.0F, 0.0F, 0.0F}; ///< the box's centre in voxels
    Vec3f forward{0.0F, 1.0F, 0.0F};      ///< unit
    Vec3f right{1.0F, 0.0F, 0.0F};        ///< half the image's width at distance 1
    Vec3f up{0.0F, 0.0F, 1.0F};           ///< half the image's height at distance 1
    float lens_radius = 0.0F, focus_distance = 1.0F;
    int width = 1, height = 1;
};

template <class F>
struct Ray {
    Vec3<F> origin;    ///< relative to the centre of the volume's box, world units
    Vec3<F> direction; ///< unit, world
};

/// A point of the unit disc, uniform by area.
template <class F>
LUMISWEEP_HD Vec3<F> uniform_disc(const F& u0, const F& u1)
{
    using I = int_of<F>;
    // A quarter of the circle by polynomial, then turned by the quarter's number; the start of the angle does not
    // matter.
    const F turn = u1 * F(4.0F);
    const I quarter = min(to_int(turn), I(3));
    const SinCos<F> sc = sincos_eighth((turn - to_float(quarter) - F(0.5F)) * F(pi / 2));
    const auto swap = (quarter & I(1)) == I(1);
    const auto negative = quarter > I(1);
    const F x = select(swap, F(0.0F) - sc.sin, sc.cos), y = select(swap, sc.cos, sc.sin);
    const F r = sqrt(u0);
    const F sign = select(negative, F(-1.0F), F(1.0F));
    return {x * r * sign, y * r * sign, F(0.0F)};
}

/// The ray through image position (x, y) in pixels, x to the right, y down from the top edge; lens_u picks the lens
/// point.
template <class F>
LUMISWEEP_HD Ray<F> camera_ray(const CameraView& camera, const F& x, const F& y, const F& lens_u0, const F& lens_u1)
{
    const auto broadcast = [](const Vec3f& v) { return Vec3<F>{F(v.x), F(v.y), F(v.z)}; };
    const F sx = fma(x, F(2.0F / static_cast<float>(camera.width)), F(-1.0F));
    const F sy = fma(y, F(-2.0F / static_cast<float>(camera.height)), F(1.0F));
    const Vec3<F> right = broadcast(camera.right), up = broadcast(camera.up);
    Vec3<F> direction = broadcast(camera.forward) + right * sx + up * sy;
    Vec3<F> origin = broadcast(camera.position);
    if (camera.lens_radius > 0.0F) {
        // right and up are scaled to the image's half sides: the lens needs unit vectors.
        const float unit_right = camera.lens_radius / std::sqrt(dot(camera.right, camera.right));
        const float unit_up = camera.lens_radius / std::sqrt(dot(camera.up, camera.up));
        const Vec3<F> disc = uniform_disc(lens_u0, lens_u1);
        const Vec3<F> offset = right * (disc.x * F(unit_right)) + up * (disc.y * F(unit_up));
        origin = origin + offset;
        direction = direction * F(camera.focus_distance) - offset;
    }
    const F inverse_length = F(1.0F) / sqrt(dot(direction, direction));
    return {origin, direction * inverse_length};
}

} // namespace lumisweep
