// Kernels that make majorants of bounds and a transfer function, as the host launches them.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/bounds_kernels.h"
#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/volume/extinction_code_steps.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// What all blocks of threads find together, in the device's memory; begins as zeros.
struct FoundInBlocks {
    std::uint64_t steps = 0, count = 0; ///< as in FilledBlocks
    std::uint32_t largest_entry = 0;    ///< of the table's extinctions, 1/world unit: the bits of a float

    LUMISWEEP_HD float largest() const { return largest_majorant(as_float(static_cast<std::int32_t>(largest_entry))); }
};

/// Extinction of every entry of the table, and the largest of them. Memory: extinction [code_entries()].
void find_extinctions(const WholeBounds& bounds, const TransferPointsView& transfer_function, double* extinction,
                      FoundInBlocks* found, const Stream& stream);

/// The table that ExtinctionCodesView describes, of `levels` levels: bits_of(entries).
void fill_codes(const double* extinction, std::uint32_t entries, int levels, const FoundInBlocks* found,
                std::uint8_t* maxima, const Stream& stream);

/// Codes of a row of cells along x, written at once.
struct alignas(4) CodeRow {
    std::uint8_t cell[majorant_block];
};

struct BlocksAndCells {
    std::size_t count = 0; ///< blocks
    const CellBounds* block_bounds = nullptr;
    const BoundsRow* cell_bounds = nullptr; ///< [block][z][y]
    std::uint8_t* block_codes = nullptr;
    CodeRow* cell_codes = nullptr; ///< as the bounds; not written in blocks that are empty
};
/// Codes of blocks and cells, empty blocks left at `empty_block`, and the sums over those that are not.
void find_block_codes(const BlocksAndCells& blocks, const ExtinctionCodesView& codes, double block_side,
                      FoundInBlocks* found, const Stream& stream);

/// Distances of empty blocks in place of their codes, by way of two arrays as large as `codes`.
void measure_empty_space(const Vec3i& block_grid, std::uint8_t* codes, std::uint8_t* between, std::uint8_t* between_too,
                         const Stream& stream);

/// MajorantView::smallest of `count` blocks.
void find_smallest(const CellBounds* blocks, std::size_t count, const BoundsScale& scale,
                   const TransferPointsView& transfer_function, float largest, std::uint8_t* smallest,
                   const Stream& stream);

} // namespace lumisweep::LUMISWEEP_CUDA
