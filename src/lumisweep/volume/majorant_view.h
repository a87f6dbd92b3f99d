// Majorants as kernels read them: a byte a block, and a byte a cell in blocks that need it.
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Voxels per majorant cell along each axis. Cell c spans c · majorant_cell − ½ to (c + 1) · majorant_cell − ½ in voxel
/// space: its sides pass through voxel centres, so interpolation within 2³ voxels of space depends on 3³ voxels.
inline constexpr int majorant_cell = 2;
/// Cells per block along each axis, and in a block.
inline constexpr int majorant_block = 4;
inline constexpr int majorant_block_cells = majorant_block * majorant_block * majorant_block;

/// Codes of cells and blocks from this one on are majorants, sixteen steps an octave. Of a block, 0 says that its cells
/// have codes of their own, and D from 1 to 31 that all blocks closer than D, itself included, are empty. Of a cell, 0
/// says that it is empty.
inline constexpr int first_majorant_code = 32;
inline constexpr int last_majorant_code = 255;
/// Of a block with nothing but empty ones around it, the farthest distance; of every empty one before any is measured.
inline constexpr std::uint8_t empty_block = first_majorant_code - 1;

/// Memory: blocks [bz][by][bx] of the volume's cells, x fastest; cells [bz][by][bx][z][y][x], 64 to a block, 0 beyond
/// the volume.
struct MajorantView {
    const std::uint8_t* blocks = nullptr;
    const std::uint8_t* cells = nullptr;
    Vec3i size{0, 0, 0};            ///< in cells
    int stride_y = 0, stride_z = 0; ///< in blocks
    int shift_y = 0, shift_z = 0;   ///< of cell coordinates packed into 32 bits
    float largest = 0.0F;           ///< majorant of the highest code, 1/world unit
    /// In thin media, else null, of every block: smallest · largest / 256 is at most the extinction anywhere in it.
    const std::uint8_t* smallest = nullptr;
};

template <class F>
struct CellXYZ {
    int_of<F> x, y, z;
};

template <class F>
LUMISWEEP_HD int_of<F> pack_cell(const MajorantView& majorants, const CellXYZ<F>& c)
{
    return c.x | shift_left(c.y, majorants.shift_y) | shift_left(c.z, majorants.shift_z);
}
template <class F>
LUMISWEEP_HD CellXYZ<F> unpack_cell(const MajorantView& majorants, const int_of<F>& cell)
{
    using I = int_of<F>;
    return {cell & I((1 << majorants.shift_y) - 1),
            shift_right(cell, majorants.shift_y) & I((1 << (majorants.shift_z - majorants.shift_y)) - 1),
            shift_right(cell, majorants.shift_z)};
}

/// The cell of a position, that of the nearest one in the volume beyond it.
template <class F>
LUMISWEEP_HD CellXYZ<F> cell_at(const MajorantView& majorants, const Vec3<F>& p_voxel)
{
    using I = int_of<F>;
    const auto axis = [](const F& p, int n) {
        constexpr float scale = 1.0F / majorant_cell;
        return min(max(to_int(fma(p, F(scale), F(0.5F * scale))), I(0)), I(n - 1));
    };
    return {axis(p_voxel.x, majorants.size.x), axis(p_voxel.y, majorants.size.y), axis(p_voxel.z, majorants.size.z)};
}

/// The majorant of a code, like a float of four bits of mantissa. 1/world unit.
template <class F>
LUMISWEEP_HD F majorant_of_code(const int_of<F>& code, float largest)
{
    using I = int_of<F>;
    return as_float(shift_left<19>(code) + I(0x3f800000 - (last_majorant_code << 19))) * F(largest);
}

template <class F>
LUMISWEEP_HD int_of<F> block_of_cell(const MajorantView& majorants, const CellXYZ<F>& c)
{
    using I = int_of<F>;
    return shift_right<2>(c.x) + shift_right<2>(c.y) * I(majorants.stride_y) +
           shift_right<2>(c.z) * I(majorants.stride_z);
}

/// What holds around a cell: in the cell itself, in its block, or in the blocks closer than a distance.
template <class F>
struct Majorant {
    F value;             ///< bounds extinction, 1/world unit; 0 where it is empty
    mask_of<F> in_block; ///< in the whole block
    int_of<F> distance;  ///< in blocks closer than this; 1 where it is not empty. Without meaning unless in_block
};

template <class F>
LUMISWEEP_HD Majorant<F> majorant_at(const MajorantView& majorants, const CellXYZ<F>& c)
{
    using I = int_of<F>;
    const I block = block_of_cell(majorants, c);
    I code = gather(majorants.blocks, block);
    const mask_of<F> in_block = code > I(0);
    const I distance = select(code < I(first_majorant_code), code, I(1));
    if (!all(in_block)) {
        const I within = (c.x & I(3)) | shift_left<2>(c.y & I(3)) | shift_left<4>(c.z & I(3));
        // Lanes that need none read the first.
        code = select(in_block, code, gather(majorants.cells, select(in_block, I(0), shift_left<6>(block) | within)));
    }
    const F value = majorant_of_code<F>(code, majorants.largest);
    return {select(code < I(first_majorant_code), F(0.0F), value), in_block, distance};
}

} // namespace lumisweep
