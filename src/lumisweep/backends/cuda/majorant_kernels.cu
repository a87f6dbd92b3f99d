#include "lumisweep/backends/cuda/majorant_kernels.h"

#include "lumisweep/backends/cuda/launch.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

/// A thread looks up a row of cells; those of a block meet in shared memory.
struct BlockCodes {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    static constexpr int own = threads / rows_of_block, pitch = rows_of_block + 1; // spreads over the banks
    struct Shared {
        std::uint32_t steps[own * pitch], largest[own * pitch]; // [block][row]
        std::uint32_t of_block[own];
    };
    BlocksAndCells blocks;
    ExtinctionCodesView codes;
    double block_side;
    FoundInBlocks* found;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        Shared& shared = *block.shared<Shared>();
        const std::size_t first = static_cast<std::size_t>(block.index.x) * own;
        const int here = static_cast<int>(blocks.count - first < own ? blocks.count - first : own);
        block.run([&](int thread) {
            const int of_block = thread / rows_of_block, row = thread % rows_of_block;
            const std::size_t at = first + static_cast<std::size_t>(of_block);
            std::uint32_t steps = 0, largest = 0;
            if (of_block < here && codes.largest_code(blocks.block_bounds[at]) != 0) {
                const std::size_t of_row = at * rows_of_block + static_cast<std::size_t>(row);
                const BoundsRow bounds = blocks.cell_bounds[of_row];
                CodeRow code;
                for (int i = 0; i < majorant_block; ++i) {
                    code.cell[i] = codes.largest_code(bounds.cell[i]);
                    steps += majorant_steps(code.cell[i]);
                    largest = code.cell[i] > largest ? code.cell[i] : largest;
                }
                blocks.cell_codes[of_row] = code;
            }
            shared.steps[of_block * pitch + row] = steps;
            shared.largest[of_block * pitch + row] = largest;
        });
        block.run([&](int thread) {
            if (thread >= here)
                return;
            std::uint32_t steps = 0, largest = 0;
            for (int i = thread * pitch; i < thread * pitch + rows_of_block; ++i) {
                steps += shared.steps[i];
                largest = shared.largest[i] > largest ? shared.largest[i] : largest;
            }
            shared.of_block[thread] = steps;
            blocks.block_codes[first + static_cast<std::size_t>(thread)] =
                largest == 0 ? empty_block
                             : code_of_block(static_cast<std::uint8_t>(largest), steps, found->largest(), block_side);
        });
        block.run([&](int thread) {
            if (thread != 0)
                return;
            std::uint64_t steps = 0, count = 0;
            for (int i = 0; i < here; ++i) {
                steps += shared.of_block[i];
                count += shared.of_block[i] > 0 ? 1 : 0;
            }
            if (count == 0)
                return;
            atomic_add(&found->steps, steps);
            atomic_add(&found->count, count);
        });
    }
};

enum class Axis { first, second, last };

/// The chessboard distance is the largest of three, and so the nearest block along one axis of those nearest along the
/// others: min over d of max(|d|, distance d further), axis after axis.
template <Axis axis>
struct EmptySpace {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    const std::uint8_t* from; ///< codes along the first axis, else distances so far
    std::uint8_t* to;         ///< codes along the last one
    int count;                ///< blocks
    int stride, side;         ///< of the axis, in blocks

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const int i = block.index.x * threads + thread;
            if (i >= count)
                return;
            const int position = i / stride % side;
            int nearest = distance(i);
            for (int d = 1; d < nearest; ++d) {
                if (position >= d)
                    nearest = min(nearest, max(d, distance(i - d * stride)));
                if (position + d < side)
                    nearest = min(nearest, max(d, distance(i + d * stride)));
            }
            if (axis != Axis::last || nearest > 0)
                to[i] = static_cast<std::uint8_t>(nearest);
        });
    }

private:
    LUMISWEEP_HD int distance(int i) const
    {
        const int stored = from[i];
        return axis == Axis::first && stored != empty_block ? 0 : stored;
    }
};

struct Smallest {
    static constexpr int threads = 256, blocks_a_multiprocessor = 2;
    const CellBounds* blocks;
    std::size_t count;
    BoundsScale scale;
    TransferPointsView transfer_function;
    float largest;
    std::uint8_t* smallest;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const std::size_t i = static_cast<std::size_t>(block.index.x) * threads + static_cast<std::size_t>(thread);
            if (i < count)
                smallest[i] = smallest_of_block(blocks[i], scale, transfer_function, largest);
        });
    }
};

Vec3i grid_for(std::size_t count, std::size_t of_block)
{
    return {static_cast<int>((count + of_block - 1) / of_block), 1, 1};
}

} // namespace

void find_block_codes(const BlocksAndCells& blocks, const ExtinctionCodesView& codes, double block_side,
                      FoundInBlocks* found, const Stream& stream)
{
    launch("majorants", stream, grid_for(blocks.count, BlockCodes::own), sizeof(BlockCodes::Shared),
           BlockCodes{blocks, codes, block_side, found});
}

void measure_empty_space(const Vec3i& block_grid, std::uint8_t* codes, std::uint8_t* between, std::uint8_t* between_too,
                         const Stream& stream)
{
    const int slice = block_grid.x * block_grid.y, count = slice * block_grid.z;
    const auto pass = [&](const auto& kernel) {
        launch("empty space", stream, grid_for(static_cast<std::size_t>(count), kernel.threads), 0, kernel);
    };
    pass(EmptySpace<Axis::first>{codes, between, count, 1, block_grid.x});
    pass(EmptySpace<Axis::second>{between, between_too, count, block_grid.x, block_grid.y});
    pass(EmptySpace<Axis::last>{between_too, codes, count, slice, block_grid.z});
}

void find_smallest(const CellBounds* blocks, std::size_t count, const BoundsScale& scale,
                   const TransferPointsView& transfer_function, float largest, std::uint8_t* smallest,
                   const Stream& stream)
{
    launch("lower bounds", stream, grid_for(count, Smallest::threads), 0,
           Smallest{blocks, count, scale, transfer_function, largest, smallest});
}

} // namespace lumisweep::LUMISWEEP_CUDA
