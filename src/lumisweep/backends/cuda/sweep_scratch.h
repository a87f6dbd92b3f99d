// Working memory of a batch of lines, as kernels see it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/sweep_line.h"
#include "lumisweep/visibility/sweep_box.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// The filter's box in one slice of cells along one axis; reach −1: nothing to filter.
struct alignas(8) BoxView {
    std::int32_t reach, shift;
};

/// What is the same for a whole slice of cells.
struct SliceView {
    float depth, weight, scale; ///< as in side_factors_of()
    BoxView box[2][2];          ///< [u, v][towards the low, the high side]
};

/// Lines are numbered from the batch's first. Memory, for each line: [w], for u and then v [cell].
struct SweepScratch {
    int most_cells; ///< along any axis
    int most_tiles; ///< along u or v of any line
    SliceView* slices;
    CellPlace* places;
    CellSides* sides;
    BoxScales* scales;         ///< likewise, but for either side [cell]
    std::int32_t* tile_begin;  ///< for u and v [tile + 1]: a tile's first cell
    float* tau;                ///< [line][w][v][pitch]: as RayPlane::tau_of
    std::size_t tau_stride;    ///< from line to line
    std::int32_t* totals;      ///< [line][ray row][ray]: what the rays hold at their ends
    std::size_t totals_stride; ///< from line to line
    std::uint8_t* turned;      ///< [line][side][x][z][y]: V of lines along x
    std::uint8_t* averaged;    ///< [line][slot][z][y][x]: V of lines to be averaged
    std::uint32_t* sums;       ///< [slot][even, odd bytes][word]: of a texel's lines before this batch, 16 bits each
    std::size_t cell_stride;   ///< of turned and averaged in bytes, a multiple of 64

    LUMISWEEP_HD std::size_t slice(int line, int w) const
    {
        return static_cast<std::size_t>(line) * static_cast<std::size_t>(most_cells) + static_cast<std::size_t>(w);
    }
    LUMISWEEP_HD std::size_t cells(int line, int w, int plane_axis) const
    {
        return (2 * slice(line, w) + static_cast<std::size_t>(plane_axis)) * static_cast<std::size_t>(most_cells);
    }
    LUMISWEEP_HD BoxScales* scales_of(int line, int w, int plane_axis, int side) const
    {
        return scales + 2 * cells(line, w, plane_axis) + static_cast<std::size_t>(side * most_cells);
    }
    LUMISWEEP_HD std::int32_t* tiles(int line, int w, int plane_axis) const
    {
        return tile_begin +
               (2 * slice(line, w) + static_cast<std::size_t>(plane_axis)) * static_cast<std::size_t>(most_tiles + 1);
    }
    /// Cells of a row of tau, for rows that begin on 32 bytes.
    LUMISWEEP_HD static int tau_pitch(int cells_u) { return (cells_u + 7) / 8 * 8; }
    LUMISWEEP_HD float* tau_row(const LineView& view, int line, int w, int v) const
    {
        const std::size_t row =
            static_cast<std::size_t>(w) * static_cast<std::size_t>(view.v.cells) + static_cast<std::size_t>(v);
        return tau + static_cast<std::size_t>(line) * tau_stride +
               row * static_cast<std::size_t>(tau_pitch(view.u.cells));
    }
    /// V filtered along u in fixed point, where the row's optical depths were: [side][pitch].
    LUMISWEEP_HD std::uint16_t* visibility_row(const LineView& view, int line, int w, int v, int side) const
    {
        return reinterpret_cast<std::uint16_t*>(tau_row(view, line, w, v)) + side * tau_pitch(view.u.cells);
    }
    LUMISWEEP_HD std::int32_t* totals_row(const LineView& view, int line, int ray_row) const
    {
        return totals + static_cast<std::size_t>(line) * totals_stride +
               static_cast<std::size_t>(ray_row) * static_cast<std::size_t>(view.u.ray_count);
    }
    /// `turned` by side, `averaged` by slot.
    LUMISWEEP_HD std::uint8_t* of_line(std::uint8_t* memory, int line, int which) const
    {
        return memory + static_cast<std::size_t>(2 * line + which) * cell_stride;
    }
};

/// Where V of a batch's lines goes: to its direction in the grid, or to SweepScratch::averaged.
struct SweepTarget {
    std::uint8_t* grid; ///< null when lines are averaged
    std::size_t grid_stride;

    LUMISWEEP_HD std::uint8_t* of(const SweepScratch& scratch, const LineView& view, int line, int side) const
    {
        return grid != nullptr ? grid + static_cast<std::size_t>(view.direction[side]) * grid_stride
                               : scratch.of_line(scratch.averaged, line, view.slot[side]);
    }
};

} // namespace lumisweep::LUMISWEEP_CUDA
