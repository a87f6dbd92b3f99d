#include "lumisweep/render/settings.h"

#include <cmath>

#include "lumisweep/base/error.h"
#include "lumisweep/render/camera.h"

namespace lumisweep {

namespace {

/// What single precision holds with room for products.
constexpr double far = 1e15;

bool usable(const Vec3d& v) { return std::fabs(v.x) <= far && std::fabs(v.y) <= far && std::fabs(v.z) <= far; }

} // namespace

void Camera::validate() const
{
    require(usable(position), "camera.position: is not finite or beyond {:g}", far);
    require(usable(target), "camera.target: is not finite or beyond {:g}", far);
    require(usable(up), "camera.up: is not finite or beyond {:g}", far);
    const double distance = length(target - position);
    require(std::isfinite(distance) && distance > 0.0, "camera.target: is the camera's position (move one of them)");
    const Vec3d side = cross(target - position, up);
    require(length(up) > 0.0 && length(side) > 1e-9 * distance * length(up),
            "camera.up: is zero or along the view direction (choose another up vector)");
    require(vertical_fov_deg > 0.0 && vertical_fov_deg < 180.0, "camera.vertical_fov_deg: {} is not between 0 and 180",
            vertical_fov_deg);
    require(std::isfinite(lens_radius) && lens_radius >= 0.0 && lens_radius <= far,
            "camera.lens_radius: {} is not between 0 and {:g}", lens_radius, far);
    require(std::isfinite(focus_distance) && focus_distance >= 0.0 && focus_distance <= far,
            "camera.focus_distance: {} is not between 0 and {:g}", focus_distance, far);
}

double Camera::focus() const { return focus_distance > 0.0 ? focus_distance : length(target - position); }

std::array<double, 16> Camera::camera_from_world() const
{
    const CameraFrame f = camera_frame(*this);
    return {f.right.x,   f.right.y,   f.right.z,   -dot(f.right, position),   //
            f.up.x,      f.up.y,      f.up.z,      -dot(f.up, position),      //
            f.forward.x, f.forward.y, f.forward.z, -dot(f.forward, position), //
            0.0,         0.0,         0.0,         1.0};
}

void ImageSettings::validate() const
{
    constexpr int max_side = 16384;
    require(width >= 1 && width <= max_side, "image.width: {} is not between 1 and {}", width, max_side);
    require(height >= 1 && height <= max_side, "image.height: {} is not between 1 and {}", height, max_side);
}

void RenderSettings::validate() const
{
    require(shadow_rays >= 0 && shadow_rays <= most_shadow_rays,
            "render.shadow_rays: {} is not 1 to {}, nor 0 for \"auto\"", shadow_rays, most_shadow_rays);
}

RenderSettings RenderSettings::resolved() const
{
    RenderSettings all = *this;
    const bool ours = strategy == Strategy::automatic;
    if (random_numbers == RandomNumbers::automatic)
        all.random_numbers = ours ? RandomNumbers::stratified : RandomNumbers::independent;
    if (shadow_rays == 0)
        all.shadow_rays = ours ? automatic_shadow_rays : 1;
    return all;
}

} // namespace lumisweep
