#include "lumisweep/sampling/joint_grid.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/sampling/joint_values.h"

namespace lumisweep {

namespace {

/// Nodes of this many bytes are more than caches hold: they are stored past them.
constexpr std::size_t streamed_bytes = std::size_t{16} << 20;
/// Cells that a thread takes at a time.
constexpr std::size_t cells_a_piece = 64 * joint_block;

} // namespace

std::vector<float> light_factors(const Environment& environment, JointFactor factor, std::size_t directions)
{
    std::vector<float> factors(directions, 1.0F);
    if (factor == JointFactor::visibility_times_light) {
        LUMISWEEP_EXPECT(environment.mean_luminance() > 0.0);
        const float* level = environment.view().luminance + (directions - 1) / 3;
        for (std::size_t d = 0; d < directions; ++d)
            factors[d] = static_cast<float>(level[d] / environment.mean_luminance());
    }
    return factors;
}

JointView joint_shape(Vec3i cells, Vec3i volume_size, int directions_per_side)
{
    JointView shape;
    shape.levels = std::countr_zero(static_cast<unsigned>(directions_per_side));
    shape.node_count = joint_level(4 * directions_per_side * directions_per_side);
    shape.cells = cells;
    shape.cells_per_voxel = {static_cast<float>(cells.x) / static_cast<float>(volume_size.x),
                             static_cast<float>(cells.y) / static_cast<float>(volume_size.y),
                             static_cast<float>(cells.z) / static_cast<float>(volume_size.z)};
    return shape;
}

std::size_t JointGrid::bytes_needed(std::size_t cell_count, int directions_per_side)
{
    const int node_count = joint_level(4 * directions_per_side * directions_per_side);
    return cell_count * sizeof(float) * (1 + static_cast<std::size_t>(node_count));
}

void JointGrid::require_indexable(std::size_t cell_count, int directions_per_side)
{
    constexpr std::uint64_t max_entries = std::numeric_limits<std::int32_t>::max();
    require(bytes_needed(cell_count, directions_per_side) / sizeof(float) <= max_entries,
            "visibility: {} cells of {} × {} directions are too many (raise visibility.cell or lower "
            "visibility.directions)",
            cell_count, directions_per_side, directions_per_side);
}

bool JointGrid::build(const VisibilityGrid& visibility, Vec3i volume_size, const Environment& environment,
                      JointFactor factor, double epsilon, const std::atomic<bool>* cancel, const JointKernel& kernel)
{
    LUMISWEEP_EXPECT(epsilon > 0.0);
    LUMISWEEP_EXPECT(environment.resolution() >= visibility.directions_per_side());
    const std::size_t cell_count = visibility.cell_count();
    require_indexable(cell_count, visibility.directions_per_side());
    const JointView shape = joint_shape(visibility.cells(), volume_size, visibility.directions_per_side());
    const auto node_count = static_cast<std::size_t>(shape.node_count);
    if (root_.size() != cell_count || nodes_.size() != cell_count * node_count) {
        *this = JointGrid(); // the old one first: each may be as large as the volume
        AlignedArray<float> root(cell_count, Contents::uninitialised);
        nodes_ = AlignedArray<float>(cell_count * node_count, Contents::uninitialised);
        root_ = std::move(root);
    }
    shape_ = shape;

    const std::vector<float> light =
        light_factors(environment, factor, static_cast<std::size_t>(visibility.direction_count()));
    if (shape.levels == 0) {
        for (std::size_t cell = 0; cell < cell_count; ++cell)
            root_[cell] =
                joint_leaf(static_cast<float>(visibility.direction(0)[cell]), static_cast<float>(epsilon), light[0]);
        return true;
    }
    std::vector<const std::uint8_t*> directions;
    directions.reserve(static_cast<std::size_t>(visibility.direction_count()));
    for (int d = 0; d < visibility.direction_count(); ++d)
        directions.push_back(visibility.direction(d));
    JointWork work;
    work.visibility = directions.data();
    work.light = light.data();
    work.epsilon = static_cast<float>(epsilon);
    work.directions = visibility.direction_count();
    work.node_count = shape.node_count;
    work.nodes = nodes_.data();
    work.root = root_.data();
    work.stores = nodes_.bytes() > streamed_bytes ? JointStores::streaming : JointStores::cached;
    parallel_for(std::size_t{0}, (cell_count + cells_a_piece - 1) / cells_a_piece, [&](std::size_t piece) {
        if (!is_cancelled(cancel))
            kernel.build(work, piece * cells_a_piece, std::min((piece + 1) * cells_a_piece, cell_count));
    });
    return !is_cancelled(cancel);
}

JointView JointGrid::view() const
{
    JointView view = shape_;
    view.root = root_.data();
    view.nodes = nodes_.data();
    return view;
}

} // namespace lumisweep
