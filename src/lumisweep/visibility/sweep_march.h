// The march: several directions of one sweep axis and one sense of shear together through the marched level.
//
// Voxel rows go by in strips, in the order of the shear, each strip through all slices before the next; so the rays'
// sums and the strip's pairs of voxel rows stay in the second-level cache. A ray row leaves its strip for the next one
// when it passes the strip's end, which lies between two rows of cells: the two ray rows of a lookup are never apart.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/visibility/ray_plane.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {

/// Working memory of one thread.
class GroupMarch {
public:
    GroupMarch(const MarchedLevel& level, const SweepKernels& kernels, const std::atomic<bool>* cancel);

    /// Marches all and fills tau_of. All of one axis and of one sign of geometry().v.slope. False when cancelled.
    bool run(std::span<RayPlane> planes, SweepStats& stats);

private:
    struct Strip {
        int first_cell, last_cell; ///< rows of cells
        bool lowest, highest;
    };
    struct Span {
        int first, last;
    };
    /// A plane's part in the strip and slab under way.
    struct Part {
        std::span<const SweepPiece> pieces;   ///< at most march_slices of the slab
        Span rows;                            ///< ray rows of the strip
        int voxel_row;                        ///< of ray row 0, in the last piece
        std::vector<Span> counted;            ///< [piece] ray rows that count it
        std::vector<int> edge;                ///< as in MarchBlocks
        std::vector<std::uint32_t> edge_rays; ///< [piece][edge block]
        MarchBlocks blocks;
    };
    bool march_strips(std::span<RayPlane> planes, SweepStats& stats);
    Span ray_rows(const RayPlane& plane, const Strip& strip, int slab) const;
    void place(const RayPlane& plane, const Strip& strip, int slab, std::size_t first_piece, Part& part) const;
    static void place_blocks(const SweepAxis& u, Part& part);
    void make_pairs(std::span<RayPlane> planes, SweepStats& stats);
    void march(std::span<RayPlane> planes, SweepStats& stats);
    void march_row(RayPlane& plane, const Part& part, int ray_row);

    const MarchedLevel& level_;
    const SweepKernels& kernels_;
    const std::atomic<bool>* cancel_;
    std::vector<Part> parts_;          // [plane]
    int first_slice_ = 0;              // of the parts
    std::vector<Span> pair_rows_;      // [slice] pairs (v, v + 1) that are there
    std::vector<std::size_t> pair_at_; // [slice] where they begin
    std::size_t pair_stride_ = 0;
    std::vector<Span> pair_extent_; // [pair row] from the first to behind the last voxel that is not empty
    AlignedArray<std::uint8_t> pairs_;
    std::vector<float> tau_; // of a row of cells
};

} // namespace lumisweep
