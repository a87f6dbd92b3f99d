// Automatic camera: what of the volume can be seen, and from where it fits the image.
#pragma once

#include "lumisweep/render/settings.h"
#include "lumisweep/scene/scene_description.h"
#include "lumisweep/scene/value_statistics.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// A box of voxels in p_voxel.
struct VoxelBox {
    Vec3d low, high;
};

/// The box of the voxels whose extinction is at least 2 % of the largest that occurs, less a thousandth of them at
/// either end of each axis (stray noise); the whole volume when nothing is visible.
VoxelBox visible_box(const ScalarGrid& volume, const TransferFunction& transfer_function,
                     const ValueStatistics& values);

/// Fills in what the description leaves open. The target is the box's centre; the position is seen from the target
/// anterior (−Y in LPS), a little above and to the patient's right, at the distance at which the box just fits.
Camera frame_camera(const CameraDescription& description, const ScalarGrid& volume, const VoxelBox& box,
                    const ImageSettings& image);

} // namespace lumisweep
