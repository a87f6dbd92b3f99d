#include "lumisweep/backends/cuda/bounds_kernels.h"

#include <limits>
#include <type_traits>

#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/reduce.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

/// A thread looks at `looks` voxels, as many apart as a block has threads.
struct FiniteRange {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4, looks = 16;
    static constexpr float largest = std::numeric_limits<float>::max();
    struct Range {
        std::uint32_t low, high, non_finite;
    };
    const float* voxels;
    std::size_t count;
    FoundInVoxels* found;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        Range* ranges = block.shared<Range>();
        const std::size_t first = static_cast<std::size_t>(block.index.x) * (threads * looks);
        block.run([&](int thread) {
            Range range{0xffffffffU, 0, 0};
            for (int k = 0; k < looks; ++k) {
                const std::size_t i = first + static_cast<std::size_t>(k * threads + thread);
                if (i >= count)
                    break;
                const bool is_finite = std::fabs(voxels[i]) <= largest;
                const std::uint32_t number = in_order(voxels[i]);
                range.low = is_finite && number < range.low ? number : range.low;
                range.high = is_finite && number > range.high ? number : range.high;
                range.non_finite |= is_finite ? 0U : 1U;
            }
            ranges[thread] = range;
        });
        reduce(block, ranges, [](const Range& a, const Range& b) {
            return Range{a.low < b.low ? a.low : b.low, a.high > b.high ? a.high : b.high, a.non_finite | b.non_finite};
        });
        block.run([&](int thread) {
            if (thread != 0)
                return;
            atomic_min(&found->finite_low, ranges[0].low);
            atomic_max(&found->finite_high, ranges[0].high);
            if (ranges[0].non_finite != 0)
                atomic_or(&found->non_finite, 1U);
        });
    }
};

/// Of numbers as they are in registers. Comparisons are false for NaN, which leaves it out.
template <class Voxel>
struct Extremes {
    using Number = std::conditional_t<std::is_integral_v<Voxel>, int, Voxel>;
    using Limits = std::numeric_limits<Number>;
    static constexpr Number least = Limits::has_infinity ? -Limits::infinity() : Limits::lowest();
    static constexpr Number most = Limits::has_infinity ? Limits::infinity() : Limits::max();
    Number low = most, high = least;

    LUMISWEEP_HD void take(Number from_low, Number from_high)
    {
        low = from_low < low ? from_low : low;
        high = from_high > high ? from_high : high;
    }
};

/// Along an axis the cells of one or several blocks depend on these positions of voxels, k = 0, 1, …: cell i on 2 i to
/// 2 i + 2, and on 2 i − 1 where it is the last one and reaches one voxel further back (see voxels_of_cell). Beyond the
/// volume positions repeat its last voxel, which changes no extreme.
LUMISWEEP_HD int position_of(int first_cell, int k, int voxels)
{
    const int last = k == 0 ? voxels - 2 : voxels - 1;
    return max(min(first_cell * majorant_cell - 1 + k, last), 0);
}
LUMISWEEP_HD bool reaches_back(int first_cell, int i, int voxels)
{
    return i > 0 && (first_cell + i) * majorant_cell == voxels;
}

/// Blocks of cells in a row along x: extremes along z in registers, then along y, then along x.
template <class Voxel>
struct CellExtremes {
    static constexpr int threads = 320, blocks_a_multiprocessor = 3;
    static constexpr int row_blocks = 8, row_cells = row_blocks * majorant_block;
    static constexpr int positions = majorant_block * majorant_cell + 1, columns = row_cells * majorant_cell + 1;
    struct Shared {
        Voxel low_z[majorant_block][positions][columns], high_z[majorant_block][positions][columns];
        Voxel low_y[rows_of_block][columns], high_y[rows_of_block][columns]; ///< [z][y] of cells
        std::uint32_t low[row_blocks], high[row_blocks];                     ///< bounds of blocks
    };
    const Voxel* voxels;
    Vec3i size, block_grid;
    BoundsScale scale;
    BoundsRow* cells;
    CellBounds* blocks;
    FoundInVoxels* found;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        Shared& shared = *block.template shared<Shared>();
        const Vec3i first{block.index.x * row_cells, block.index.y * majorant_block, block.index.z * majorant_block};
        const int blocks_here = min(block_grid.x - block.index.x * row_blocks, row_blocks);
        const std::size_t first_block =
            (static_cast<std::size_t>(block.index.z) * static_cast<std::size_t>(block_grid.y) +
             static_cast<std::size_t>(block.index.y)) *
                static_cast<std::size_t>(block_grid.x) +
            static_cast<std::size_t>(block.index.x * row_blocks);
        block.run([&](int thread) {
            if (thread < row_blocks) {
                shared.low[thread] = 0xffffffffU;
                shared.high[thread] = 0;
            }
            for (int i = thread; i < positions * columns; i += threads)
                extremes_along_z(shared, first, i / columns, i % columns);
        });
        block.run([&](int thread) {
            for (int i = thread; i < rows_of_block * columns; i += threads)
                extremes_along_y(shared, first, i / columns, i % columns);
        });
        block.run([&](int thread) {
            for (int i = thread; i < blocks_here * majorant_block_cells; i += threads)
                bounds_along_x(shared, first, first_block, i);
        });
        block.run([&](int thread) {
            if (thread < blocks_here)
                blocks[first_block + static_cast<std::size_t>(thread)] =
                    shared.low[thread] <= shared.high[thread]
                        ? CellBounds{static_cast<std::uint16_t>(shared.low[thread]),
                                     static_cast<std::uint16_t>(shared.high[thread])}
                        : CellBounds{};
            if (thread != 0)
                return;
            std::uint32_t low = 0xffffffffU, high = 0;
            for (int i = 0; i < blocks_here; ++i) {
                low = shared.low[i] < low ? shared.low[i] : low;
                high = shared.high[i] > high ? shared.high[i] : high;
            }
            atomic_min(&found->low, low);
            atomic_max(&found->high, high);
        });
    }

private:
    LUMISWEEP_HD void extremes_along_z(Shared& shared, const Vec3i& first, int row, int column) const
    {
        // Indices of voxels fit into 31 bits.
        const int first_voxel = position_of(first.y, row, size.y) * size.x + position_of(first.x, column, size.x);
        typename Extremes<Voxel>::Number v[positions];
        for (int k = 0; k < positions; ++k)
            v[k] = voxels[first_voxel + position_of(first.z, k, size.z) * (size.x * size.y)];
        for (int i = 0; i < majorant_block; ++i) {
            Extremes<Voxel> extremes;
            for (int k = 0; k <= majorant_cell; ++k)
                extremes.take(v[i * majorant_cell + k], v[i * majorant_cell + k]);
            if (reaches_back(first.z, i, size.z))
                extremes.take(v[max(i * majorant_cell - 1, 0)], v[max(i * majorant_cell - 1, 0)]);
            shared.low_z[i][row][column] = static_cast<Voxel>(extremes.low);
            shared.high_z[i][row][column] = static_cast<Voxel>(extremes.high);
        }
    }
    LUMISWEEP_HD void extremes_along_y(Shared& shared, const Vec3i& first, int row, int column) const
    {
        const int z = row / majorant_block, y = row % majorant_block;
        Extremes<Voxel> extremes;
        for (int k = reaches_back(first.y, y, size.y) ? -1 : 0; k <= majorant_cell; ++k)
            extremes.take(shared.low_z[z][y * majorant_cell + k][column],
                          shared.high_z[z][y * majorant_cell + k][column]);
        shared.low_y[row][column] = static_cast<Voxel>(extremes.low);
        shared.high_y[row][column] = static_cast<Voxel>(extremes.high);
    }
    /// Of cell i, counted in the order of memory.
    LUMISWEEP_HD void bounds_along_x(Shared& shared, const Vec3i& first, std::size_t first_block, int i) const
    {
        const int block = i / majorant_block_cells, row = i % majorant_block_cells / majorant_block;
        const int within = i % majorant_block, x = block * majorant_block + within;
        CellBounds& cell =
            cells[(first_block + static_cast<std::size_t>(block)) * rows_of_block + static_cast<std::size_t>(row)]
                .cell[within];
        const auto is_inside = [](int c, int n) { return c <= n / majorant_cell; };
        if (!is_inside(first.x + x, size.x) || !is_inside(first.y + row % majorant_block, size.y) ||
            !is_inside(first.z + row / majorant_block, size.z)) {
            cell = CellBounds{};
            return;
        }
        Extremes<Voxel> extremes;
        for (int k = reaches_back(first.x, x, size.x) ? -1 : 0; k <= majorant_cell; ++k)
            extremes.take(shared.low_y[row][x * majorant_cell + k], shared.high_y[row][x * majorant_cell + k]);
        const CellBounds bounds = bounds_of(scale, static_cast<Voxel>(extremes.low), static_cast<Voxel>(extremes.high));
        cell = bounds;
        if (bounds.empty())
            return;
        atomic_min(&shared.low[block], static_cast<std::uint32_t>(bounds.low));
        atomic_max(&shared.high[block], static_cast<std::uint32_t>(bounds.high));
    }
};

template <class Voxel>
void find_bounds_of(const void* voxels, const WholeBounds& bounds, const Vec3i& block_grid, BoundsRow* cells,
                    CellBounds* blocks, FoundInVoxels* found, const Stream& stream)
{
    using Kernel = CellExtremes<Voxel>;
    const Vec3i grid{(block_grid.x + Kernel::row_blocks - 1) / Kernel::row_blocks, block_grid.y, block_grid.z};
    launch(
        "bounds of cells", stream, grid, static_cast<int>(sizeof(typename Kernel::Shared)),
        Kernel{static_cast<const Voxel*>(voxels), bounds.volume_size, block_grid, bounds.scale, cells, blocks, found});
}

} // namespace

void find_finite_range(const float* voxels, std::size_t count, FoundInVoxels* found, const Stream& stream)
{
    constexpr std::size_t of_block = FiniteRange::threads * FiniteRange::looks;
    launch("range of voxels", stream, {static_cast<int>((count + of_block - 1) / of_block), 1, 1},
           FiniteRange::threads * sizeof(FiniteRange::Range), FiniteRange{voxels, count, found});
}

void find_cell_bounds(VoxelType type, const void* voxels, const WholeBounds& bounds, const Vec3i& block_grid,
                      BoundsRow* cells, CellBounds* blocks, FoundInVoxels* found, const Stream& stream)
{
    switch (type) {
    case VoxelType::u8: return find_bounds_of<std::uint8_t>(voxels, bounds, block_grid, cells, blocks, found, stream);
    case VoxelType::u16: return find_bounds_of<std::uint16_t>(voxels, bounds, block_grid, cells, blocks, found, stream);
    case VoxelType::i16: return find_bounds_of<std::int16_t>(voxels, bounds, block_grid, cells, blocks, found, stream);
    default: return find_bounds_of<float>(voxels, bounds, block_grid, cells, blocks, found, stream);
    }
}

} // namespace lumisweep::LUMISWEEP_CUDA
