// The steps of a sweep on the device, each one launch for a batch of lines; in their order.
#pragma once

#include "lumisweep/backends/cuda/device_extinction.h"
#include "lumisweep/backends/cuda/sweep_scratch.h"

namespace lumisweep::LUMISWEEP_CUDA {

struct SweepBatch {
    LinesView lines;
    SweepScratch scratch;
    int first_line, line_count;
    int most_tiles_u, most_tiles_v; ///< over all lines

    LUMISWEEP_HD const LineView& line(int index) const { return lines.lines[first_line + index]; }
};

/// The level's voxels in both layouts.
struct VoxelsView {
    RowsView along_x, along_y;
    Vec3i size;
};

/// Fills what the scratch holds for slices and cells. tan_beta is the filter's (filter_angle), 0 for none.
void place_cells(const SweepBatch& batch, double extinction_of_one, double tan_beta, const Stream& stream);
/// Marches all rays: fills tau and totals.
void march_rays(const SweepBatch& batch, const VoxelsView& voxels, const Stream& stream);
/// From optical depths to V, filtered along u.
void make_visible(const SweepBatch& batch, const Stream& stream);
/// Filters along v and stores in 8 bits: lines along x to `turned`, others to the target.
void store_visible(const SweepBatch& batch, const SweepTarget& target, const Stream& stream);
/// Lines along x from `turned` to the target.
void turn_visible(const SweepBatch& batch, const SweepTarget& target, Vec3i cells, const Stream& stream);

/// The part that a batch is of its texels' lines: all of them, or some of one texel's.
struct AveragedLines {
    int lines_a_texel;  ///< 4 or 16
    int lines_here;     ///< of each texel in this batch
    bool begins, ends;  ///< whether they are the texel's first, its last
    std::uint8_t* grid; ///< to which the averages go
    std::size_t stride;
};
void average_lines(const SweepBatch& batch, const AveragedLines& averaged, const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
