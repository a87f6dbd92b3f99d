// The inner loops of a sweep, compiled once per instruction set (sweep_kernel_*.cpp) and chosen at start-up.
//
// The march is in integers; lookups are in single precision with nothing contracted or reassociated; so every
// instruction set gives the same bits as the plain loops of sweep_kernel_baseline.cpp.
//
// Rays of a row are stored apart by parity: even[k] is ray 2k, odd[k] ray 2k + 1. Voxel rows are stored in pairs: byte
// 2u of pair row v is voxel (v, u), byte 2u + 1 is voxel (v + 1, u). The four voxels around a ray are then four
// neighbouring bytes, those of the next ray of its parity the next four, and one dot-product instruction takes 16 rays
// one slice further.
#pragma once

#include <cstdint>

#include "lumisweep/visibility/sweep_optics.h"

namespace lumisweep {

/// Rays are marched in blocks of this many; rows of rays are padded to whole blocks.
inline constexpr int ray_block = 32;
/// Bytes that must be readable before and after a pair row: rays of a block that do not count, and slices that have no
/// ray in it because they are up to 8 voxels of shear away.
inline constexpr int pair_row_margin = 2 * ray_block + 2 + 16;
/// Slices that one pass of the march takes at most; more are marched in several.
inline constexpr int march_slices = 8;
/// Voxels repeated beyond each end of a pair row.
inline constexpr int edge_voxels = 2;

/// What one slice adds to a row of rays.
struct MarchRow {
    const std::uint8_t* pairs; ///< the four voxels of ray k begin at pairs + 2 k
    std::int8_t weight[4];
    const std::uint32_t* counted; ///< [edge block] which rays count this slice: even ones in the low 16 bits
};

/// The blocks of rays that some slices march through: all rays of [first, last) count all slices; in the edge blocks
/// each slice has its own.
struct MarchBlocks {
    int first, last;
    const int* edge;
    int edge_count;
};

/// LookupRow::step of cells that lie on neighbouring rays, of alternating parity, with one fraction for all.
inline constexpr int neighbouring_rays = -1;

/// A row of cells on two rows of rays.
struct LookupRow {
    const std::int32_t *low, *high;   ///< the rows of rays below and above
    const std::int32_t *index, *next; ///< [cell] where the two rays beside it are stored in each row
    const float* fraction;            ///< [cell] towards the second
    float fraction_rows;              ///< towards the row above
    int step;                         ///< index[c + 1] − index[c], if one step and fraction hold for all (then only
                                      ///< index[0] and next[0] are read), or neighbouring_rays; else 0
    int count;                        ///< cells
};

/// What the sides of the box do to a row of cells. Weights count as in sweep_geometry.h, 127 a slice.
struct SideRow {
    const float *begin_low, *begin_high; ///< [cell] weight at which the two rays' columns begin to count …
    const float *end_low, *end_high;     ///< … and end
    const float *enter, *leave;          ///< [cell] depth at which its own column passes the sides
    const float* fraction;               ///< [cell] between the two columns
    RowSides row;
    float depth;  ///< slices
    float weight; ///< of a ray from the start face at this depth
    float scale;  ///< natural optical depth × log2 e of one stored step over one slice
    int count;    ///< cells
};

struct SweepKernels {
    const char* name;
    /// pairs[2u] = low[u], pairs[2u + 1] = high[u], with edge_voxels repeated at either end (pairs[−4] … ).
    void (*make_pairs)(std::uint8_t* pairs, const std::uint8_t* low, const std::uint8_t* high, int count);
    /// tau[ray] += Σ over the slices that count the ray of weight · voxels.
    void (*march)(std::int32_t* even, std::int32_t* odd, const MarchRow* rows, int row_count,
                  const MarchBlocks& blocks);
    /// tau[cell]: bilinear between four rays.
    void (*look_up)(float* tau, const LookupRow& row);
    /// SideFactors of each cell.
    void (*side_factors)(float* forwards, float* backwards, const SideRow& row);
    /// visibility[i] = 2^(−factor[i] · tau[i]), at most 1.
    void (*to_visibility)(std::uint16_t* visibility, const float* tau, const float* factor, int count);
    /// Likewise of total[i] − tau[i].
    void (*to_visibility_of_rest)(std::uint16_t* visibility, const float* total, const float* tau, const float* factor,
                                  int count);
    /// out[i] = a[i] + b[i], mod 2^16.
    void (*add)(std::uint16_t* out, const std::uint16_t* a, const std::uint16_t* b, int count);
    /// sums[i] += entering[i] / 2^shift − leaving[i] / 2^shift, each rounded to nearest, mod 2^16.
    void (*slide)(std::uint16_t* sums, const std::uint16_t* entering, const std::uint16_t* leaving, int shift,
                  int count);
    /// out[i] = (whole[i] · scale_whole[i] + (low[i] + high[i]) · scale_ends[i]) / 65536, each product rounded down.
    void (*box_mean)(std::uint16_t* out, const std::uint16_t* whole, const std::uint16_t* low,
                     const std::uint16_t* high, const std::uint16_t* scale_whole, const std::uint16_t* scale_ends,
                     int count);
    /// Likewise with one scale for all, and low and high divided by 2^shift and rounded to nearest first.
    void (*box_mean_row)(std::uint16_t* out, const std::uint16_t* whole, const std::uint16_t* low,
                         const std::uint16_t* high, int shift, std::uint16_t scale_whole, std::uint16_t scale_ends,
                         int count);
    /// out[i] = in[i] in 8 bits, rounded. Other threads see it after finish_stores.
    void (*store)(std::uint8_t* out, const std::uint16_t* in, int count);
    /// out[i] = in[i], for what is next used when the caches have long forgotten it; finish_stores here, too.
    void (*stream)(float* out, const float* in, int count);
    void (*finish_stores)();
};

extern const SweepKernels sweep_kernels_baseline;
#if defined(__x86_64__)
extern const SweepKernels sweep_kernels_avx2;
extern const SweepKernels sweep_kernels_avx512;
#endif

/// The widest instruction set of this machine.
const SweepKernels& sweep_kernels();

} // namespace lumisweep
