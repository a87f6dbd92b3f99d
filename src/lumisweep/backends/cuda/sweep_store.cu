// The filter along v, V in 8 bits, and its way into the grid: lines along x are turned, lines of one texel averaged.
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"
#include "lumisweep/backends/cuda/sweep_words.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// A thread takes two neighbouring columns of one slice of cells down all rows, with a sum that slides.
struct StoreVisible {
    static constexpr int threads = 128, blocks_a_multiprocessor = 8;
    SweepBatch batch;
    SweepTarget target;

    struct Column {
        const std::uint32_t* words; ///< of row 0
        int pitch, height;          ///< words from row to row, rows
        int shift;

        /// 0 beyond the ends.
        LUMISWEEP_HD std::uint32_t operator()(int row) const
        {
            return row >= 0 && row < height
                       ? shifted_pair(words[static_cast<std::size_t>(row) * static_cast<std::size_t>(pitch)], shift)
                       : 0U;
        }
    };
    struct Output {
        std::uint8_t* bytes;
        std::size_t row_stride;
        bool both; ///< columns, or only the first

        LUMISWEEP_HD void store(int row, std::uint32_t pair) const
        {
            std::uint8_t* to = bytes + static_cast<std::size_t>(row) * row_stride;
            to[0] = stored_visibility(static_cast<std::uint16_t>(pair));
            if (both)
                to[1] = stored_visibility(static_cast<std::uint16_t>(pair >> 16));
        }
    };

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const int line = block.index.z, side = block.index.y;
        const LineView& view = batch.line(line);
        if (view.direction[side] < 0)
            return;
        block.run_apart([&](int thread) {
            const int pairs = (view.u.cells + 1) / 2, index = block.index.x * threads + thread;
            const int w = index / pairs, cell = index % pairs * 2;
            if (w < view.cells)
                store(view, line, side, w, cell);
        });
    }

private:
    LUMISWEEP_HD void store(const LineView& view, int line, int side, int w, int cell) const
    {
        const SweepScratch& scratch = batch.scratch;
        const BoxView box = scratch.slices[scratch.slice(line, w)].box[1][side];
        const Column column{reinterpret_cast<const std::uint32_t*>(scratch.visibility_row(view, line, w, 0, side)) +
                                cell / 2,
                            SweepScratch::tau_pitch(view.u.cells), view.v.cells, box.shift};
        const Output output = output_of(view, line, side, w, cell);
        if (box.reach < 0)
            for (int row = 0; row < view.v.cells; ++row)
                output.store(row, column(row));
        else
            slide(column, output, box, scratch.scales_of(line, w, 1, side));
    }

    LUMISWEEP_HD Output output_of(const LineView& view, int line, int side, int w, int cell) const
    {
        const std::size_t u = static_cast<std::size_t>(view.u.cells), v = static_cast<std::size_t>(view.v.cells);
        const std::size_t slices = static_cast<std::size_t>(view.cells);
        std::uint8_t* bytes = view.axis == 0 ? batch.scratch.of_line(batch.scratch.turned, line, side)
                                             : target.of(batch.scratch, view, line, side);
        // Along x: [x][z][y]; along y: u is x and v is z; along z: u is x and v is y.
        const std::size_t slice_stride = view.axis == 1 ? u : u * v, row_stride = view.axis == 1 ? u * slices : u;
        return {bytes + static_cast<std::size_t>(w) * slice_stride + cell, row_stride, cell + 1 < view.u.cells};
    }

    LUMISWEEP_HD static void slide(const Column& column, const Output& output, const BoxView& box,
                                   const BoxScales* scales)
    {
        constexpr int rows_at_once = 4; // loads on their way at a time
        std::uint32_t sums = 0;
        for (int row = 0; row < box.reach && row < column.height; ++row)
            sums += column(row);
        std::uint32_t entering = column(box.reach);
        for (int first = 0; first < column.height; first += rows_at_once) {
            std::uint32_t next[rows_at_once], leaving[rows_at_once];
            LUMISWEEP_UNROLL
            for (int i = 0; i < rows_at_once; ++i) {
                next[i] = column(first + i + box.reach + 1);
                leaving[i] = column(first + i - box.reach - 1);
            }
            LUMISWEEP_UNROLL
            for (int i = 0; i < rows_at_once; ++i) {
                const int row = first + i;
                if (row >= column.height)
                    break;
                sums = sums - leaving[i] + entering;
                entering = next[i];
                output.store(row, mean_of_pair(sums, leaving[i] + next[i], scales[row], box.shift));
            }
        }
    }
};

/// [x][z][y] to [z][y][x], 32 × 32 cells of one z at a time.
struct TurnVisible {
    static constexpr int threads = 128, blocks_a_multiprocessor = 8, side_of_tile = 32;
    static constexpr int tile_stride = side_of_tile + 1;
    SweepBatch batch;
    SweepTarget target;
    Vec3i cells;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const int line = block.index.z / 2, side = block.index.z % 2;
        const LineView& view = batch.line(line);
        if (view.axis != 0 || view.direction[side] < 0)
            return;
        const int tiles_x = (cells.x + side_of_tile - 1) / side_of_tile;
        const int first_x = block.index.x % tiles_x * side_of_tile, first_y = block.index.x / tiles_x * side_of_tile;
        const std::size_t cx = static_cast<std::size_t>(cells.x), cy = static_cast<std::size_t>(cells.y);
        const std::size_t cz = static_cast<std::size_t>(cells.z), z = static_cast<std::size_t>(block.index.y);
        const std::uint8_t* from = batch.scratch.of_line(batch.scratch.turned, line, side) + z * cy;
        std::uint8_t* to = target.of(batch.scratch, view, line, side) + z * cy * cx;
        std::uint8_t* tile = block.shared<std::uint8_t>();
        block.run([&](int thread) {
            const int y = thread % side_of_tile;
            for (int x = thread / side_of_tile; x < side_of_tile; x += threads / side_of_tile)
                if (first_x + x < cells.x && first_y + y < cells.y)
                    tile[x * tile_stride + y] =
                        from[static_cast<std::size_t>(first_x + x) * cz * cy + static_cast<std::size_t>(first_y + y)];
        });
        block.run_apart([&](int thread) {
            const int x = thread % side_of_tile;
            for (int y = thread / side_of_tile; y < side_of_tile; y += threads / side_of_tile)
                if (first_x + x < cells.x && first_y + y < cells.y)
                    to[static_cast<std::size_t>(first_y + y) * cx + static_cast<std::size_t>(first_x + x)] =
                        tile[x * tile_stride + y];
        });
    }
};

/// A thread takes four cells of one direction, whose bytes are the even and the odd ones of a word.
struct AverageLines {
    static constexpr int threads = 128, blocks_a_multiprocessor = 8;
    static constexpr std::uint32_t even_bytes = 0x00ff00ffU;
    SweepBatch batch;
    AveragedLines averaged;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const int first_line = block.index.z * averaged.lines_here, slot = block.index.y;
        const LineView& view = batch.line(first_line);
        const int direction = view.slot[0] == slot ? view.direction[0] : view.slot[1] == slot ? view.direction[1] : -1;
        if (direction < 0)
            return;
        const SweepScratch& scratch = batch.scratch;
        const std::size_t words = scratch.cell_stride / 4;
        // Where all lines of a texel come at once, nothing is kept between batches.
        std::uint32_t* sums =
            averaged.begins && averaged.ends ? nullptr : scratch.sums + static_cast<std::size_t>(slot) * 2 * words;
        std::uint32_t* out =
            reinterpret_cast<std::uint32_t*>(averaged.grid + static_cast<std::size_t>(direction) * averaged.stride);
        block.run_apart([&](int thread) {
            const std::size_t i = static_cast<std::size_t>(block.index.x) * threads + static_cast<std::size_t>(thread);
            if (i >= words)
                return;
            std::uint32_t even = averaged.begins ? 0U : sums[i], odd = averaged.begins ? 0U : sums[words + i];
            for (int line = 0; line < averaged.lines_here; ++line) {
                const std::uint8_t* bytes = scratch.of_line(scratch.averaged, first_line + line, slot);
                const std::uint32_t four = reinterpret_cast<const std::uint32_t*>(bytes)[i];
                even += four & even_bytes;
                odd += four >> 8 & even_bytes;
            }
            if (averaged.ends) {
                out[i] = mean(even) | mean(odd) << 8;
            } else {
                sums[i] = even;
                sums[words + i] = odd;
            }
        });
    }

private:
    LUMISWEEP_HD std::uint32_t mean(std::uint32_t sums) const
    {
        const int bits = averaged.lines_a_texel == 4 ? 2 : 4;
        return (sums + (0x10001U << (bits - 1))) >> bits & even_bytes;
    }
};

} // namespace

void store_visible(const SweepBatch& batch, const SweepTarget& target, const Stream& stream)
{
    const int cells = batch.scratch.most_cells;
    const int blocks = ((cells + 1) / 2 * cells + StoreVisible::threads - 1) / StoreVisible::threads;
    launch("storing visibility", stream, {blocks, 2, batch.line_count}, 0, StoreVisible{batch, target});
}

void turn_visible(const SweepBatch& batch, const SweepTarget& target, Vec3i cells, const Stream& stream)
{
    constexpr int side = TurnVisible::side_of_tile;
    const int tiles = ((cells.x + side - 1) / side) * ((cells.y + side - 1) / side);
    launch("turning visibility", stream, {tiles, cells.z, 2 * batch.line_count}, side * TurnVisible::tile_stride,
           TurnVisible{batch, target, cells});
}

void average_lines(const SweepBatch& batch, const AveragedLines& averaged, const Stream& stream)
{
    const int words = static_cast<int>(batch.scratch.cell_stride / 4);
    launch("averaging lines", stream,
           {(words + AverageLines::threads - 1) / AverageLines::threads, 2, batch.line_count / averaged.lines_here}, 0,
           AverageLines{batch, averaged});
}

} // namespace lumisweep::LUMISWEEP_CUDA
