// The arithmetic of the joint grid's nodes, for the host's kernels (joint_kernel_impl.h) and for devices. Value: a
// float or a vector of them; every operation is rounded by itself.
#pragma once

#include "lumisweep/base/host_device.h"

namespace lumisweep {

/// J = (V + ε) · L̄ / mean L̄ of one direction, from V · 255.
template <class Value>
LUMISWEEP_HD Value joint_leaf(Value stored, float epsilon, float light)
{
    return (stored * (1.0F / 255.0F) + epsilon) * light;
}

/// The parent of four siblings.
template <class Value>
LUMISWEEP_HD Value joint_mean(Value a, Value b, Value c, Value d)
{
    return ((a + b) + (c + d)) * 0.25F;
}

} // namespace lumisweep
