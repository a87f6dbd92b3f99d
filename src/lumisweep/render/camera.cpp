#include "lumisweep/render/camera.h"

#include <cmath>

namespace lumisweep {

CameraFrame camera_frame(const Camera& camera)
{
    const Vec3d forward = normalized(camera.target - camera.position);
    const Vec3d right = normalized(cross(forward, camera.up));
    return {right, cross(right, forward), forward};
}

CameraView camera_view(const Camera& camera, const ImageSettings& image, const ScalarGrid& volume)
{
    camera.validate();
    image.validate();
    const CameraFrame frame = camera_frame(camera);
    const Vec3d center_voxel = {0.5 * volume.size().x, 0.5 * volume.size().y, 0.5 * volume.size().z};
    const Vec3d center_world = volume.world_from_voxel().point(center_voxel);
    const double half_height = std::tan(camera.vertical_fov_deg * (pi / 360.0));
    const double half_width = half_height * image.width / image.height;

    CameraView view;
    view.position = to_float(camera.position - center_world);
    view.center_voxel = to_float(center_voxel);
    view.forward = to_float(frame.forward);
    view.right = to_float(frame.right * half_width);
    view.up = to_float(frame.up * half_height);
    view.lens_radius = static_cast<float>(camera.lens_radius);
    view.focus_distance = static_cast<float>(camera.focus());
    view.width = image.width;
    view.height = image.height;
    return view;
}

} // namespace lumisweep
