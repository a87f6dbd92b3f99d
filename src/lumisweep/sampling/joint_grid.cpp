#include "lumisweep/sampling/joint_grid.h"

#include <bit>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep {

namespace {

/// Nodes below the root in `levels` levels.
std::size_t nodes_of(int levels)
{
    std::size_t nodes = 0;
    for (int l = 0; l < levels; ++l)
        nodes = 4 * nodes + 4;
    return nodes;
}

} // namespace

std::size_t JointGrid::bytes_needed(std::size_t cell_count, int directions_per_side)
{
    return cell_count * sizeof(float) * (1 + nodes_of(std::countr_zero(static_cast<unsigned>(directions_per_side))));
}

JointGrid::JointGrid(const VisibilityGrid& visibility, Vec3i volume_size, const Environment& environment,
                     JointFactor factor, double epsilon)
    : cells_(visibility.cells()), cells_per_voxel_{static_cast<float>(cells_.x) / static_cast<float>(volume_size.x),
                                                   static_cast<float>(cells_.y) / static_cast<float>(volume_size.y),
                                                   static_cast<float>(cells_.z) / static_cast<float>(volume_size.z)},
      levels_(std::countr_zero(static_cast<unsigned>(visibility.directions_per_side()))),
      root_(visibility.cell_count()), nodes_(visibility.cell_count() * nodes_of(levels_))
{
    LUMISWEEP_EXPECT(epsilon > 0.0);
    LUMISWEEP_EXPECT(environment.resolution() >= visibility.directions_per_side());
    const EnvironmentView light = environment.view();
    const std::size_t directions = static_cast<std::size_t>(visibility.direction_count());
    std::vector<float> light_factor(directions, 1.0F);
    if (factor == JointFactor::visibility_times_light) {
        LUMISWEEP_EXPECT(environment.mean_luminance() > 0.0);
        const float* level = light.luminance + (directions - 1) / 3;
        for (std::size_t d = 0; d < directions; ++d)
            light_factor[d] = static_cast<float>(level[d] / environment.mean_luminance());
    }
    const std::size_t node_count = nodes_of(levels_);
    parallel_for(
        std::size_t{0}, visibility.cell_count(),
        [&](std::size_t cell) {
            if (levels_ == 0) {
                root_[cell] = (static_cast<float>(visibility.direction(0)[cell]) * (1.0F / 255.0F) +
                               static_cast<float>(epsilon)) *
                              light_factor[0];
                return;
            }
            float* nodes = nodes_.data() + cell * node_count;
            float* leaves = nodes + (directions - 4) / 3;
            for (std::size_t d = 0; d < directions; ++d) {
                const float v = static_cast<float>(visibility.direction(static_cast<int>(d))[cell]) * (1.0F / 255.0F);
                leaves[d] = (v + static_cast<float>(epsilon)) * light_factor[d];
            }
            for (float* children = leaves; children != nodes;) {
                const std::size_t child_count = static_cast<std::size_t>(children - nodes) * 3 + 4;
                float* parents = children - child_count / 4;
                for (std::size_t m = 0; m < child_count / 4; ++m)
                    parents[m] =
                        0.25F * ((children[4 * m] + children[4 * m + 1]) + (children[4 * m + 2] + children[4 * m + 3]));
                children = parents;
            }
            root_[cell] = 0.25F * ((nodes[0] + nodes[1]) + (nodes[2] + nodes[3]));
        },
        256);
}

JointView JointGrid::view() const
{
    return {root_.data(), nodes_.data(), static_cast<int>(nodes_of(levels_)), levels_, cells_, cells_per_voxel_};
}

} // namespace lumisweep
