// The joint grid as kernels read it.
#pragma once

#include "lumisweep/base/host_device.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Cells as in VisibilityGrid; `levels` = log2 of the directions per side.
/// Memory: root [cells] float: the mean over directions of J = (V + ε) · L̄ / mean L̄. nodes [cells][node_count] float:
/// the averages of J at level l = 1 … levels, Morton order, level l from (4^l − 4)/3 on; the last level is J itself.
/// Dividing by root gives a density per unit octahedral square.
struct JointView {
    const float* root = nullptr;
    const float* nodes = nullptr;
    int node_count = 0;
    int levels = 0;
    Vec3i cells{0, 0, 0};
    Vec3f cells_per_voxel{0.0F, 0.0F, 0.0F};
};

/// Where in a cell's nodes the level of 4^l = `nodes` of them begins; of 4 · directions it is node_count.
LUMISWEEP_HD constexpr int joint_level(int nodes) { return (nodes - 4) / 3; }

} // namespace lumisweep
