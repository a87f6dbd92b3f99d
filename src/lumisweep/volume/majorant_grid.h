// Bounds of the data per small cell, built once a volume; majorants of extinction and the extent of empty space, built
// once a transfer function.
//
// Cells have their sides through voxel centres: interpolation within 2³ voxels of space then depends on 3³ voxels, not
// on 4³, and majorants are as tight as cells of half the size would be on voxel boundaries.
#pragma once

#include <cstdint>
#include <limits>

#include "lumisweep/base/aligned.h"
#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// Voxels per majorant cell along each axis. Cell c spans c · majorant_cell − ½ to (c + 1) · majorant_cell − ½ in voxel
/// space.
inline constexpr int majorant_cell = 2;
/// Cells per block along each axis; empty space is skipped in boxes of blocks.
inline constexpr int majorant_block = 4;

/// Cells along an axis of n voxels.
constexpr int majorant_cells(int n) { return n / majorant_cell + 1; }
Vec3i majorant_cells(const Vec3i& volume_size);

/// The smallest and largest finite value that trilinear interpolation can take within each cell, in 16 bits: voxels of
/// 8 and 16 bits as they are, single precision rounded outwards to 65536 steps of the volume's range.
class BoundsGrid {
public:
    struct Bounds {
        std::uint16_t low, high; ///< low > high where nothing is finite
    };

    BoundsGrid() = default;
    explicit BoundsGrid(const ScalarGrid& volume);

    const Vec3i& cells() const { return cells_; }
    std::size_t size() const { return bounds_.size(); }
    Bounds bounds(std::size_t cell) const { return bounds_[cell]; }
    /// The smallest low and the largest high.
    Bounds range() const { return range_; }
    /// Some voxel is not finite, so extinction may be 0 within the bounds of any cell.
    bool has_gaps() const { return has_gaps_; }
    /// Data units of a bound, or between two.
    double value(double bound) const { return slope_ * (first_ + step_ * bound) + intercept_; }
    /// How far interpolation in single precision may leave the range from `low` to `high` (data units) by rounding.
    double slack(double low, double high) const;
    std::size_t bytes() const { return bounds_.bytes(); }
    static std::uint64_t bytes_needed(const Vec3i& volume_size);

private:
    template <class Voxel>
    void fill(const Vec3i& size, const Voxel* voxels);

    Vec3i cells_{0, 0, 0};
    AlignedArray<Bounds> bounds_;
    Bounds range_{1, 0};
    bool has_gaps_ = false;
    double first_ = 0.0, step_ = 1.0; // raw = first + step · bound
    double slope_ = 1.0, intercept_ = 0.0;
};

/// Memory: codes [nz][ny][nx], x fastest. Codes below first_majorant_code are empty cells: 0 one in a block that holds
/// others, D > 0 one around whose block all blocks closer than D are empty, too. Higher codes are majorants.
struct MajorantView {
    const std::uint8_t* codes = nullptr;
    int nx = 0, ny = 0, nz = 0;
    int shift_y = 0, shift_z = 0; ///< of cell coordinates packed into 32 bits
    float largest = 0.0F;         ///< majorant of the highest code, 1/world unit
    /// In thin media, else null, [nz][ny][nx]: smallest · largest / 256 is at most the extinction anywhere in the cell.
    const std::uint8_t* smallest = nullptr;
};

/// Optical depth along the volume's diagonal, at the mean majorant of the cells that are not empty, up to which a
/// medium is thin: transmittance is then estimated by residual ratio tracking. In others that brings nothing
/// (docs/results/transmittance.md).
inline constexpr double thin_medium = 32.0;

inline constexpr int first_majorant_code = 32;
inline constexpr int last_majorant_code = 255;

/// The majorant of a code: sixteen steps an octave, like a float of four bits of mantissa. 1/world unit.
template <class F>
LUMISWEEP_HD F majorant_of_code(const int_of<F>& code, float largest)
{
    using I = int_of<F>;
    return as_float(shift_left<19>(code) + I(0x3f800000 - (last_majorant_code << 19))) * F(largest);
}

/// A strict upper bound of extinction within each cell, and where there is none; in thin media a lower bound as well.
class MajorantGrid {
public:
    MajorantGrid() = default;
    /// `diagonal_world` is the length of the volume's diagonal; infinity where the medium shall not count as thin.
    MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function,
                 double diagonal_world = std::numeric_limits<double>::infinity());

    MajorantView view() const;
    std::size_t bytes() const { return codes_.bytes() + smallest_.bytes(); }
    static std::uint64_t bytes_needed(const Vec3i& volume_size);

private:
    static constexpr std::uint8_t farthest = first_majorant_code - 1;

    void fill(const BoundsGrid& bounds, const TransferFunction& transfer_function);
    /// Of the cells that are not empty.
    double mean_majorant() const;
    void measure_empty_space();

    Vec3i cells_{0, 0, 0}, blocks_{0, 0, 0};
    AlignedArray<std::uint8_t> codes_;
    AlignedArray<std::uint8_t> smallest_; // empty unless the medium is thin
    AlignedArray<std::uint8_t> distance_; // of blocks, to the nearest that is not empty
    float largest_ = 0.0F;
};

} // namespace lumisweep
