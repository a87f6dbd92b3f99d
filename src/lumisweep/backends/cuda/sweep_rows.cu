// From optical depths at cells to V of a line's two directions, and the filter along u.
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"
#include "lumisweep/backends/cuda/sweep_words.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// A row of cells as all of its cells see it.
struct alignas(16) RowView {
    std::int32_t totals;  ///< where in the line's totals the row of rays on its low side begins
    float fraction;       ///< towards the next
    std::int32_t at_side; ///< whether it sees the sides of v
    RowSides sides;
};

/// A block takes 2 · row_pairs rows of one slice of cells. V of two rows lies in one word of shared memory, so that a
/// box is summed for both at once; where the row's optical depths were, the two directions' V takes their place.
struct MakeVisible {
    static constexpr int threads = 128, blocks_a_multiprocessor = 8;
    SweepBatch batch;
    int row_pairs;

    /// Rows, then the words of both directions.
    static int shared_bytes(int row_pairs, int width)
    {
        return 2 * row_pairs * (width * 4 + static_cast<int>(sizeof(RowView)));
    }

    /// A thread's cells: every `columns`-th of a row, in every `groups`-th pair of rows.
    struct Share {
        int column, columns, group, groups;

        LUMISWEEP_HD Share(int thread, int width)
        {
            const int bits = width > 64 ? 7 : width > 32 ? 6 : 5;
            columns = 1 << bits;
            groups = threads >> bits;
            column = thread & (columns - 1);
            group = thread >> bits;
        }
    };
    struct Place {
        const LineView& view;
        int line, w, first_row;
    };

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const Place at{batch.line(block.index.z), block.index.z, block.index.y, block.index.x * 2 * row_pairs};
        if (at.w >= at.view.cells || at.first_row >= at.view.v.cells)
            return;
        const SliceView slice = batch.scratch.slices[batch.scratch.slice(at.line, at.w)];
        block.run([&](int thread) {
            for (int r = thread; r < 2 * row_pairs && at.first_row + r < at.view.v.cells; r += threads)
                block.shared<RowView>()[r] = row_view(at, at.first_row + r);
        });
        block.run([&](int thread) {
            const Share share(thread, at.view.u.cells);
            for (int cell = share.column; cell < at.view.u.cells; cell += share.columns)
                make_column(block, at, slice, cell, share);
        });
        block.run_apart([&](int thread) {
            const Share share(thread, at.view.u.cells);
            for (int side = 0; side < 2; ++side)
                if (at.view.direction[side] >= 0)
                    filter(block, at, slice.box[0][side], side, share);
        });
    }

private:
    LUMISWEEP_HD std::uint32_t* words_of(const Block<threads>& block, const Place& at, int side) const
    {
        return block.shared<std::uint32_t>(2 * row_pairs * static_cast<int>(sizeof(RowView))) +
               side * row_pairs * at.view.u.cells;
    }

    LUMISWEEP_HD float whole(const Place& at) const { return static_cast<float>(at.view.slices * slice_weight); }

    LUMISWEEP_HD RowView row_view(const Place& at, int row) const
    {
        const std::size_t index = batch.scratch.cells(at.line, at.w, 1) + static_cast<std::size_t>(row);
        const CellPlace place = batch.scratch.places[index];
        const CellSides sides = batch.scratch.sides[index];
        const float slices = static_cast<float>(at.view.slices);
        return {place.ray * at.view.u.ray_count, place.fraction, sees_sides(sides, whole(at), slices) ? 1 : 0,
                row_sides(sides, slices, place.fraction)};
    }

    /// V of a column of cells in all rows.
    LUMISWEEP_HD void make_column(const Block<threads>& block, const Place& at, const SliceView& slice, int cell,
                                  const Share& share) const
    {
        const SweepScratch& scratch = batch.scratch;
        const std::size_t index = scratch.cells(at.line, at.w, 0) + static_cast<std::size_t>(cell);
        const CellPlace place = scratch.places[index];
        const CellSides sides = scratch.sides[index];
        const auto factors_of = [&](const RowSides& row) {
            return side_factors_of(sides.begin_low, sides.begin_high, sides.end_low, sides.end_high, sides.enter,
                                   sides.leave, place.fraction, row, slice.depth, slice.weight, slice.scale);
        };
        const SideFactors inside = factors_of(no_row_sides(whole(at), static_cast<float>(at.view.slices)));
        const int width = at.view.u.cells, pitch = SweepScratch::tau_pitch(width);
        const float* tau = scratch.tau_row(at.view, at.line, at.w, at.first_row) + cell;
        const std::int32_t* totals = scratch.totals_row(at.view, at.line, 0) + place.ray;
        for (int pair = share.group; pair < row_pairs; pair += share.groups) {
            std::uint32_t low = 0, high = 0;
            for (int odd = 0; odd < 2; ++odd) {
                const int r = 2 * pair + odd;
                if (at.first_row + r >= at.view.v.cells)
                    break;
                const RowView row = block.shared<RowView>()[r];
                const SideFactors factors = row.at_side != 0 ? factors_of(row.sides) : inside;
                const float until = tau[r * pitch];
                if (at.view.direction[0] >= 0)
                    low |= std::uint32_t{fixed_visibility(until * factors.forwards, most_depth)} << (16 * odd);
                if (at.view.direction[1] >= 0) {
                    const std::int32_t* below = totals + row.totals;
                    const std::int32_t* above = below + at.view.u.ray_count;
                    const float total =
                        between_rays(below[0], below[1], above[0], above[1], place.fraction, row.fraction);
                    high |= std::uint32_t{fixed_visibility((total - until) * factors.backwards, most_depth)}
                            << (16 * odd);
                }
            }
            words_of(block, at, 0)[pair * width + cell] = shifted_pair(low, slice.box[0][0].shift);
            words_of(block, at, 1)[pair * width + cell] = shifted_pair(high, slice.box[0][1].shift);
        }
    }

    LUMISWEEP_HD void filter(const Block<threads>& block, const Place& at, const BoxView& box, int side,
                             const Share& share) const
    {
        const int width = at.view.u.cells, height = at.view.v.cells, pitch = 2 * SweepScratch::tau_pitch(width);
        const BoxScales* scales = batch.scratch.scales_of(at.line, at.w, 0, side);
        std::uint16_t* visibility = batch.scratch.visibility_row(at.view, at.line, at.w, 0, side);
        for (int cell = share.column; cell < width; cell += share.columns)
            for (int pair = share.group; pair < row_pairs; pair += share.groups) {
                const std::uint32_t* row = words_of(block, at, side) + pair * width;
                const std::uint32_t mean = box.reach < 0 ? row[cell] : mean_at(row, width, cell, box, scales[cell]);
                for (int odd = 0; odd < 2; ++odd) {
                    const int v = at.first_row + 2 * pair + odd;
                    if (v < height)
                        visibility[v * pitch + cell] = static_cast<std::uint16_t>(mean >> (16 * odd));
                }
            }
    }
    LUMISWEEP_HD static std::uint32_t mean_at(const std::uint32_t* row, int width, int cell, const BoxView& box,
                                              const BoxScales& scales)
    {
        const int before = cell - box.reach - 1, behind = cell + box.reach + 1;
        const int last = behind < width ? behind : width;
        std::uint32_t sum = 0;
        for (int i = before < 0 ? 0 : before + 1; i < last; ++i)
            sum += row[i];
        const std::uint32_t ends = (before >= 0 ? row[before] : 0U) + (behind < width ? row[behind] : 0U);
        return mean_of_pair(sum, ends, scales, box.shift);
    }
};

} // namespace

void make_visible(const SweepBatch& batch, const Stream& stream)
{
    constexpr int shared_aim = 24 * 1024, most_pairs = 8;
    const int cells = batch.scratch.most_cells;
    int pairs = most_pairs;
    while (pairs > 1 && MakeVisible::shared_bytes(pairs, cells) > shared_aim)
        pairs /= 2;
    launch("making cells visible", stream, {(cells + 2 * pairs - 1) / (2 * pairs), cells, batch.line_count},
           MakeVisible::shared_bytes(pairs, cells), MakeVisible{batch, pairs});
}

} // namespace lumisweep::LUMISWEEP_CUDA
