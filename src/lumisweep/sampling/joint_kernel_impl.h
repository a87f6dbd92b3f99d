// The body of joint_kernel.h, included by one file per instruction set, which defines `Cells` first: the lanes that
// hold one value for `Cells::width` neighbouring cells. Everything is local to the file: the linker must not mix
// instruction sets.
#include "lumisweep/sampling/joint_kernel.h"
#include "lumisweep/sampling/joint_values.h"

namespace lumisweep {
namespace {

using Float = Cells::Float;

/// What a block needs besides its output, in the first-level cache for 8 × 8 directions.
struct Block {
    alignas(64) float parents[1024 / 4][joint_block];
    alignas(64) float staged[joint_block * 1364]; ///< nodes of the block, as JointView has them
};

/// Four siblings of `Cells::width` cells go into their cells' nodes; their mean goes up a level.
inline __attribute__((always_inline)) Float place(float* nodes, int node_count, Float a, Float b, Float c, Float d)
{
    Cells::store_transposed(nodes, node_count, a, b, c, d);
    return joint_mean(a, b, c, d);
}

/// Fills block.staged and root[joint_block] from the cells that begin at visibility[direction] + offset.
inline __attribute__((always_inline)) void fill(Block& block, float* root, const JointWork& work,
                                                const std::uint8_t* const* visibility, std::size_t offset)
{
    constexpr int width = Cells::width;
    int count = work.directions;
    int node = (count - 4) / 3; // of the leaves
    for (int d = 0; d < count; d += 4) {
        // A cache line holds four blocks' cells: each block fetches the next four's lines of a quarter of the
        // directions.
        if ((static_cast<std::size_t>(d) / 4 + offset / joint_block) % 4 == 0)
            for (int i = d; i < d + 4; ++i)
                __builtin_prefetch(visibility[i] + offset + 64);
        for (int cell = 0; cell < static_cast<int>(joint_block); cell += width) {
            const auto leaf = [&](int direction) __attribute__((always_inline))
            {
                return joint_leaf(Cells::load(visibility[direction] + offset + cell), work.epsilon,
                                  work.light[direction]);
            };
            const Float mean = place(block.staged + cell * work.node_count + node + d, work.node_count, leaf(d),
                                     leaf(d + 1), leaf(d + 2), leaf(d + 3));
            Cells::store(block.parents[d / 4] + cell, mean);
        }
    }
    while ((count /= 4) > 1) {
        node -= count;
        for (int m = 0; m < count; m += 4)
            for (int cell = 0; cell < static_cast<int>(joint_block); cell += width) {
                const auto parent = [&](int i) __attribute__((always_inline))
                {
                    return Cells::load(block.parents[i] + cell);
                };
                const Float mean = place(block.staged + cell * work.node_count + node + m, work.node_count, parent(m),
                                         parent(m + 1), parent(m + 2), parent(m + 3));
                Cells::store(block.parents[m / 4] + cell, mean);
            }
    }
    __builtin_memcpy(root, block.parents[0], sizeof block.parents[0]);
}

void build(const JointWork& work, std::size_t first, std::size_t last)
{
    Block block;
    const auto node_count = static_cast<std::size_t>(work.node_count);
    std::size_t cell = first;
    for (; cell + joint_block <= last; cell += joint_block) {
        fill(block, work.root + cell, work, work.visibility, cell);
        float* nodes = work.nodes + cell * node_count;
        if (work.stores == JointStores::streaming)
            Cells::stream(nodes, block.staged, joint_block * node_count);
        else
            __builtin_memcpy(nodes, block.staged, joint_block * node_count * sizeof(float));
    }
    if (cell < last) {
        std::uint8_t tail[1024][joint_block] = {};
        const std::uint8_t* tails[1024];
        for (int d = 0; d < work.directions; ++d) {
            __builtin_memcpy(tail[d], work.visibility[d] + cell, last - cell);
            tails[d] = tail[d];
        }
        alignas(64) float root[joint_block];
        fill(block, root, work, tails, 0);
        __builtin_memcpy(work.root + cell, root, (last - cell) * sizeof(float));
        __builtin_memcpy(work.nodes + cell * node_count, block.staged, (last - cell) * node_count * sizeof(float));
    }
    Cells::end_of_stream();
}

} // namespace
} // namespace lumisweep
