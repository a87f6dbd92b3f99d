// The march: several directions of one sweep axis and one sense of shear together through the marched level.
//
// Voxel rows go by in strips, in the order of the shear, each strip through all slices before the next; so the rays'
// sums and the strip's pairs of voxel rows stay in the second-level cache. A ray row leaves its strip for the next one
// when it passes the strip's end, which lies between two rows of cells: the two ray rows of a lookup are never apart.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {

/// The marched level and the cells on it.
struct MarchedLevel {
    Vec3i size;
    const std::uint8_t* voxels;                               ///< x fastest, then y, then z
    const std::uint8_t* transposed;                           ///< y fastest, then z, then x; only for sweeps along x
    const ExtinctionGrid::Filled *filled, *filled_transposed; ///< of the rows of either
    Affine3d level_from_world;
    Vec3d voxel_sides_world;  ///< of the level's voxels
    double extinction_of_one; ///< 1/world unit per stored step
    Vec3i cells;
    Vec3d cell_sides; ///< level voxels
};

/// Where the cells of a line look up, for each slice of cells.
struct CellPlaces {
    int step = 0;                  ///< between the rays of neighbouring cells, if it and the fraction are constant
    std::vector<std::int32_t> ray; ///< [slice][cell] less first_ray
    std::vector<float> fraction;   ///< [slice][cell] towards the next ray
    std::vector<double> depths;    ///< [slice]
    int cells = 0;

    void place(const SweepAxis& axis, int cell_count, double cell_side, std::span<const double> lookup_depths);
    const std::int32_t* rays_of(int slice) const { return ray.data() + static_cast<std::ptrdiff_t>(slice) * cells; }
    const float* fractions_of(int slice) const { return fraction.data() + static_cast<std::ptrdiff_t>(slice) * cells; }
};

/// All rays of a direction and its opposite.
class RayPlane {
public:
    /// Keeps the memory of the direction before.
    void start(const MarchedLevel& level, const Vec3d& w_world);

    const SweepGeometry& geometry() const { return *geometry_; }
    const CellPlaces& places_u() const { return u_; }
    const CellPlaces& places_v() const { return v_; }
    /// Optical depth in units of 1/127 stored step × slice, from the start face to the cells: [w][v][u].
    const float* tau_of(int slice, int row) const
    {
        return tau_.data() + (static_cast<std::ptrdiff_t>(slice) * v_.cells + row) * u_.cells;
    }
    float* tau_of(int slice, int row)
    {
        return const_cast<float*>(static_cast<const RayPlane*>(this)->tau_of(slice, row));
    }
    /// Interpolates what the rays hold now at a row of cells.
    void look_up(const SweepKernels& kernels, int slice, int row, float* tau);

    std::int32_t* row(int ray_row);
    int half_row() const { return half_row_; }
    /// Pieces of slices up to lookup `slab`, and for slab = slices of cells the rest behind the last.
    std::span<const SweepPiece> slab(int slab) const;

private:
    /// Stored rays between those of neighbouring cells, even and odd ones being apart; 0 where that varies and for
    /// steps that the kernels have no loop for.
    int row_step() const { return u_.step == 2 || u_.step == 4 || u_.step == 8 ? u_.step / 2 : 0; }

    std::unique_ptr<SweepGeometry> geometry_;
    CellPlaces u_, v_;
    std::vector<SweepPiece> pieces_;
    std::vector<int> slab_begin_;
    int half_row_ = 0;                       ///< rays of one parity in a row
    AlignedArray<std::int32_t> rays_;        ///< [ray row][parity][ray / 2]
    std::vector<std::uint8_t> started_;      ///< [ray row] has been set to zero
    std::vector<std::int32_t> index_, next_; ///< [cell] where its two rays are stored in a row …
    int indexed_slice_ = -1;                 ///< … for the lookups of this slice
    AlignedArray<float> tau_;
};

/// Working memory of one thread.
class GroupMarch {
public:
    GroupMarch(const MarchedLevel& level, const SweepKernels& kernels, const std::atomic<bool>* cancel);

    /// Marches all and fills tau_of. All of one axis and of one sign of geometry().v.slope. False when cancelled.
    bool run(std::span<RayPlane> planes, SweepStats& stats);

private:
    bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }
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
