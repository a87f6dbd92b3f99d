// Bounds of the data per small cell, built once a volume; majorants of extinction and the extent of empty space, built
// once a transfer function.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/volume/majorant_view.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// Cells, and blocks of cells, that cover a volume.
Vec3i majorant_cells(const Vec3i& volume_size);
Vec3i majorant_blocks(const Vec3i& volume_size);

/// The smallest and largest finite value that trilinear interpolation can take within each cell and each block, in 16
/// bits: voxels of 8 and 16 bits as they are, single precision rounded outwards to 65536 steps of the volume's range
/// without fill values.
class BoundsGrid {
public:
    struct Bounds {
        std::uint16_t low = 1, high = 0; ///< low > high where nothing is finite

        bool empty() const { return low > high; }
        void include(const Bounds& other);
    };

    BoundsGrid() = default;
    explicit BoundsGrid(const ScalarGrid& volume);

    const Vec3i& volume_size() const { return volume_size_; }
    std::size_t blocks() const { return blocks_.size(); }
    const Bounds& block(std::size_t i) const { return blocks_[i]; }
    /// Of its cells, in the order of MajorantView's.
    const Bounds* cells(std::size_t block) const { return cells_.data() + block * majorant_block_cells; }
    /// Of the whole volume.
    const Bounds& range() const { return range_; }
    struct Values {
        double low, high; ///< data units
    };
    /// All that lookups in single precision can find between two bounds; of a bound and itself, among equal voxels.
    Values values(double low, double high) const;
    /// The side of a block in world units, the geometric mean of its three; the diagonal of the volume.
    double block_side() const { return block_side_; }
    double diagonal() const { return diagonal_; }
    /// Some voxel is not finite, so extinction may be 0 within any bounds.
    bool has_gaps() const { return has_gaps_; }
    std::size_t bytes() const { return cells_.bytes() + blocks_.bytes(); }
    static std::uint64_t bytes_needed(const Vec3i& volume_size);

private:
    template <class Voxel>
    void fill(const Voxel* voxels);

    Vec3i volume_size_{0, 0, 0};
    AlignedArray<Bounds> cells_, blocks_;
    Bounds range_;
    double raw(double bound) const;
    double first_ = 0.0, step_ = 1.0, first_bound_ = 0.0; // raw = first + step · (bound − first bound), but for
    double low_end_ = 0.0, high_end_ = 0.0;               // bounds 0 and 65535, the smallest and the largest value
    double near_ = 0.0, far_ = 0.0; // sizes of numbers by which lookups round: within the steps, and at the ends
    double slope_ = 1.0, intercept_ = 0.0, block_side_ = 1.0, diagonal_ = 0.0;
    bool has_gaps_ = false;
};

/// Optical depth along the volume's diagonal, at the mean majorant of the blocks that are not empty, up to which a
/// medium is thin: transmittance is then estimated by residual ratio tracking. In others that brings nothing
/// (docs/results/transmittance.md).
inline constexpr double thin_medium = 32.0;

/// A strict upper bound of extinction within each cell, and where there is none; in thin media a lower bound as well.
class MajorantGrid {
public:
    MajorantGrid() = default;
    MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function);

    MajorantView view() const;
    std::size_t bytes() const { return cells_.bytes() + blocks_.bytes() + smallest_.bytes(); }
    static std::uint64_t bytes_needed(const Vec3i& volume_size);

private:
    void fill(const BoundsGrid& bounds, const TransferFunction& transfer_function);
    void fill_smallest(const BoundsGrid& bounds, const TransferFunction& transfer_function);
    void measure_empty_space();

    Vec3i volume_size_{0, 0, 0};
    AlignedArray<std::uint8_t> cells_, blocks_;
    AlignedArray<std::uint8_t> smallest_; // of blocks; empty unless the medium is thin
    float largest_ = 0.0F;
};

} // namespace lumisweep
