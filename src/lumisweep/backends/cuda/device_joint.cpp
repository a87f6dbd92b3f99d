#include "lumisweep/backends/cuda/device_joint.h"

#include <vector>

#include "lumisweep/backends/cuda/joint_kernels.h"
#include "lumisweep/base/error.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceJoint::build(const DeviceVisibility& visibility, Vec3i volume_size, const Environment& environment,
                        JointFactor factor, double epsilon, const Stream& stream)
{
    LUMISWEEP_EXPECT(epsilon > 0.0);
    LUMISWEEP_EXPECT(environment.resolution() >= visibility.directions_per_side);
    JointGrid::require_indexable(visibility.cell_count, visibility.directions_per_side);
    view_ = joint_shape(visibility.cells, volume_size, visibility.directions_per_side);
    root_.resize(visibility.cell_count, "the joint grid");
    nodes_.resize(visibility.cell_count * static_cast<std::size_t>(view_.node_count), "the joint grid");
    view_.root = root_.data();
    view_.nodes = nodes_.data();
    light_.upload(light_factors(environment, factor, static_cast<std::size_t>(visibility.direction_count())),
                  "the joint grid", stream);
    launch_joint({visibility.direction(0), visibility.stride, static_cast<int>(visibility.cell_count), view_.levels,
                  light_.data(), static_cast<float>(epsilon), root_.data(), nodes_.data()},
                 stream);
}

} // namespace lumisweep::LUMISWEEP_CUDA
