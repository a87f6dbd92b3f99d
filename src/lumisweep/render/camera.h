// From the camera's settings to what kernels read.
#pragma once

#include "lumisweep/render/camera_view.h"
#include "lumisweep/render/settings.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep {

/// The camera's orthonormal axes in world space.
struct CameraFrame {
    Vec3d right, up, forward;
};

CameraFrame camera_frame(const Camera& camera);

/// Throws Error (Camera::validate) for impossible settings.
CameraView camera_view(const Camera& camera, const ImageSettings& image, const ScalarGrid& volume);

} // namespace lumisweep
