// The joint grid (sampling/joint_grid.h) on the device.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device_visibility.h"
#include "lumisweep/backends/cuda/staged_array.h"
#include "lumisweep/sampling/joint_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

class DeviceJoint {
public:
    /// Replaces the whole product, as JointGrid::build() does to the bit and under its conditions. `volume_size` in
    /// voxels.
    void build(const DeviceVisibility& visibility, Vec3i volume_size, const Environment& environment,
               JointFactor factor, double epsilon, const Stream& stream);
    JointView view() const { return view_; }
    std::uint64_t bytes() const { return root_.bytes() + nodes_.bytes() + light_.bytes(); }

private:
    JointView view_;
    DeviceArray<float> root_, nodes_;
    StagedArray<float> light_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
