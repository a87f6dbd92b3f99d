// Bounds of the data per small cell, built once a volume; majorants of extinction and the extent of empty space, built
// once a transfer function.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/volume/cell_bounds.h"
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
    BoundsGrid() = default;
    explicit BoundsGrid(const ScalarGrid& volume);

    const WholeBounds& whole() const { return whole_; }
    std::size_t blocks() const { return blocks_.size(); }
    const CellBounds& block(std::size_t i) const { return blocks_[i]; }
    /// Of its cells, in the order of MajorantView's.
    const CellBounds* cells(std::size_t block) const { return cells_.data() + block * majorant_block_cells; }
    std::size_t bytes() const { return cells_.bytes() + blocks_.bytes(); }
    static std::uint64_t bytes_needed(const Vec3i& volume_size);

private:
    template <class Voxel>
    void fill(VoxelType type, const Voxel* voxels);

    AlignedArray<CellBounds> cells_, blocks_;
    WholeBounds whole_;
};

/// Optical depth along the volume's diagonal, at the mean majorant of the blocks that are not empty, up to which a
/// medium is thin: transmittance is then estimated by residual ratio tracking. In others that brings nothing
/// (docs/results/transmittance.md).
inline constexpr double thin_medium = 32.0;

/// Sums over the blocks that are not empty.
struct FilledBlocks {
    std::uint64_t steps = 0; ///< of their cells' majorant_steps()
    std::uint64_t count = 0;
};
/// Whether a medium has lower bounds of extinction as well as majorants.
bool is_thin(const WholeBounds& bounds, const FilledBlocks& filled, float largest);

/// A view of majorants for a volume of that size, but for their memory and the largest one.
MajorantView majorant_layout(const Vec3i& volume_size);

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
