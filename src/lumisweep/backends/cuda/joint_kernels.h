// The kernel of the joint grid: what it takes, and its launch.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"

namespace lumisweep::LUMISWEEP_CUDA {

struct DeviceJointWork {
    const std::uint8_t* visibility; ///< [direction][stride]
    std::size_t stride;             ///< a multiple of 4
    int cell_count;
    int levels;
    const float* light; ///< [direction] factor
    float epsilon;
    float* root;  ///< as in JointView
    float* nodes; ///< as in JointView
};

void launch_joint(const DeviceJointWork& work, const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
