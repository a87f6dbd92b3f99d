// The joint grid. A block takes some cells: visibility comes in words of four cells, nodes are put in their order in
// shared memory, from where they leave in one piece.
#include "lumisweep/backends/cuda/joint_kernels.h"

#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/words.h"
#include "lumisweep/sampling/joint_values.h"
#include "lumisweep/sampling/joint_view.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

struct BuildJoint {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    DeviceJointWork work;
    int log_cells;  ///< of a block
    int node_count; ///< of a cell

    struct alignas(16) Siblings {
        float a, b, c, d;
        LUMISWEEP_HD float mean() const { return joint_mean(a, b, c, d); }
    };

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        auto* nodes = block.shared<float>(); // [cell][node_count]
        const int first_cell = block.index.x << log_cells;
        const int left = work.cell_count - first_cell, cells = left < 1 << log_cells ? left : 1 << log_cells;
        block.run([&](int thread) { place_leaves(nodes, first_cell, cells, thread); });
        for (int level = work.levels - 1; level > 1; --level)
            block.run([&](int thread) { place_parents(nodes, level, cells, thread); });
        block.run_apart([&](int thread) {
            for (int cell = thread; cell < cells; cell += threads)
                work.root[first_cell + cell] = siblings(nodes, cell, 1, 0)->mean();
            const auto* from = reinterpret_cast<const Siblings*>(nodes);
            auto* to = reinterpret_cast<Siblings*>(work.nodes + static_cast<std::size_t>(first_cell) *
                                                                    static_cast<std::size_t>(node_count));
            for (int i = thread; i < cells * (node_count / 4); i += threads)
                to[i] = from[i];
        });
    }

private:
    /// Of level `level`, with the same parent m.
    LUMISWEEP_HD Siblings* siblings(float* nodes, int cell, int level, int m) const
    {
        return reinterpret_cast<Siblings*>(nodes + cell * node_count + joint_level(1 << (2 * level)) + 4 * m);
    }
    LUMISWEEP_HD void place_parent(float* nodes, int cell, int level, int m, const Siblings& children) const
    {
        nodes[cell * node_count + joint_level(1 << (2 * level - 2)) + m] = children.mean();
    }

    /// J of all directions, and their parents.
    LUMISWEEP_HD void place_leaves(float* nodes, int first_cell, int cells, int thread) const
    {
        // Neighbouring threads take up to eight neighbouring parents, whose stores share no bank, then groups of four
        // cells.
        const int log_parents = 2 * (work.levels - 1), log_near = log_parents < 3 ? log_parents : 3;
        const int log_groups = log_cells - 2;
        for (int i = thread; i < 1 << (log_parents + log_groups); i += threads) {
            const int group = i >> log_near & ((1 << log_groups) - 1);
            const int m = (i & ((1 << log_near) - 1)) | i >> (log_near + log_groups) << log_near;
            if (4 * group < cells)
                place_leaves_of(nodes, first_cell, 4 * group, m);
        }
    }
    /// With parent m, of four cells.
    LUMISWEEP_HD void place_leaves_of(float* nodes, int first_cell, int cell, int m) const
    {
        const std::uint8_t* visibility =
            work.visibility + static_cast<std::size_t>(4 * m) * work.stride + (first_cell + cell);
        Words<4> stored; // [direction]
        LUMISWEEP_UNROLL
        for (int d = 0; d < 4; ++d)
            stored.word[d] =
                *reinterpret_cast<const std::uint32_t*>(visibility + static_cast<std::size_t>(d) * work.stride);
        const Siblings light = reinterpret_cast<const Siblings*>(work.light)[m];
        LUMISWEEP_UNROLL
        for (int c = 0; c < 4; ++c) {
            const auto leaf = [&](int d, float factor) {
                return joint_leaf(static_cast<float>(stored.word[d] >> (8 * c) & 255U), work.epsilon, factor);
            };
            const Siblings leaves{leaf(0, light.a), leaf(1, light.b), leaf(2, light.c), leaf(3, light.d)};
            *siblings(nodes, cell + c, work.levels, m) = leaves;
            if (work.levels > 1)
                place_parent(nodes, cell + c, work.levels, m, leaves);
        }
    }

    /// The parents of the nodes of a level.
    LUMISWEEP_HD void place_parents(float* nodes, int level, int cells, int thread) const
    {
        const int log_parents = 2 * (level - 1);
        for (int i = thread; i < cells << log_parents; i += threads) {
            const int cell = i >> log_parents, m = i & ((1 << log_parents) - 1);
            place_parent(nodes, cell, level, m, *siblings(nodes, cell, level, m));
        }
    }
};

/// A single direction: there are no nodes.
struct BuildRoots {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    DeviceJointWork work;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const int cell = block.index.x * threads + thread;
            if (cell < work.cell_count)
                work.root[cell] = joint_leaf(static_cast<float>(work.visibility[cell]), work.epsilon, work.light[0]);
        });
    }
};

LUMISWEEP_HD int pieces(int count, int of) { return (count + of - 1) / of; }

} // namespace

void launch_joint(const DeviceJointWork& work, const Stream& stream)
{
    if (work.levels == 0) {
        launch("the joint grid", stream, {pieces(work.cell_count, BuildRoots::threads), 1, 1}, 0, BuildRoots{work});
        return;
    }
    // As many cells as have up to 43 KB of nodes, and no more than keep all threads busy.
    constexpr int log_cells[] = {0, 9, 8, 6, 5, 3};
    const int log_count = log_cells[work.levels], node_count = joint_level(4 << (2 * work.levels));
    launch("the joint grid", stream, {pieces(work.cell_count, 1 << log_count), 1, 1},
           (node_count << log_count) * static_cast<int>(sizeof(float)), BuildJoint{work, log_count, node_count});
}

} // namespace lumisweep::LUMISWEEP_CUDA
