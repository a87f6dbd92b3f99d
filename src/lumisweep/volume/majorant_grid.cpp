#include "lumisweep/volume/majorant_grid.h"

#include <algorithm>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "lumisweep/volume/extinction_codes.h"

namespace lumisweep {

Vec3i majorant_cells(const Vec3i& volume_size)
{
    const auto cells = [](int n) { return n / majorant_cell + 1; };
    return {cells(volume_size.x), cells(volume_size.y), cells(volume_size.z)};
}

Vec3i majorant_blocks(const Vec3i& volume_size)
{
    const auto blocks = [](int n) { return (n + majorant_block - 1) / majorant_block; };
    const Vec3i cells = majorant_cells(volume_size);
    return {blocks(cells.x), blocks(cells.y), blocks(cells.z)};
}

namespace {

std::size_t count(const Vec3i& n)
{
    return static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
}

} // namespace

bool is_thin(const WholeBounds& bounds, const FilledBlocks& filled, float largest)
{
    const double mean = static_cast<double>(filled.steps) * majorant_step * static_cast<double>(largest) /
                        (static_cast<double>(filled.count) * majorant_block_cells);
    return filled.count > 0 && mean * bounds.diagonal <= thin_medium && !bounds.has_gaps;
}

MajorantView majorant_layout(const Vec3i& volume_size)
{
    // A side of n voxels takes floor(log2 n) bits, so volumes of less than 2³¹ voxels fit.
    const auto bits = [](int n) { return bits_of(static_cast<std::uint32_t>(n - 1)); };
    const Vec3i blocks = majorant_blocks(volume_size);
    MajorantView view;
    view.size = majorant_cells(volume_size);
    view.stride_y = blocks.x;
    view.stride_z = blocks.x * blocks.y;
    view.shift_y = bits(view.size.x);
    view.shift_z = bits(view.size.x) + bits(view.size.y);
    return view;
}

MajorantGrid::MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function)
    : volume_size_(bounds.whole().volume_size), cells_(bounds.blocks() * majorant_block_cells, Contents::uninitialised),
      blocks_(bounds.blocks(), Contents::uninitialised)
{
    fill(bounds, transfer_function);
    measure_empty_space();
}

std::uint64_t MajorantGrid::bytes_needed(const Vec3i& volume_size)
{
    return count(majorant_blocks(volume_size)) * (2 + majorant_block_cells);
}

MajorantView MajorantGrid::view() const
{
    MajorantView view = majorant_layout(volume_size_);
    view.blocks = blocks_.data();
    view.cells = cells_.data();
    view.largest = largest_;
    view.smallest = smallest_.data();
    return view;
}

/// Codes of cells and blocks; empty blocks are left at `empty_block`.
void MajorantGrid::fill(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    const ExtinctionCodes extinction(bounds.whole(), transfer_function);
    const ExtinctionCodesView codes = extinction.view();
    largest_ = extinction.largest();
    std::vector<std::uint32_t> sums(bounds.blocks());
    parallel_for(
        std::size_t{0}, bounds.blocks(),
        [&](std::size_t block) {
            std::uint8_t& code = blocks_[block];
            code = empty_block;
            if (codes.largest_code(bounds.block(block)) == 0)
                return;
            std::uint8_t* cells = cells_.data() + block * majorant_block_cells;
            const CellBounds* of_cells = bounds.cells(block);
            std::uint8_t largest = 0;
            std::uint32_t sum = 0;
            for (int i = 0; i < majorant_block_cells; ++i) {
                cells[i] = codes.largest_code(of_cells[i]);
                largest = std::max(largest, cells[i]);
                sum += majorant_steps(cells[i]);
            }
            sums[block] = sum;
            if (largest != 0)
                code = code_of_block(largest, sum, largest_, bounds.whole().block_side);
        },
        64);
    FilledBlocks filled;
    for (const std::uint32_t of_block : sums) {
        filled.steps += of_block;
        filled.count += of_block > 0 ? 1 : 0;
    }
    if (is_thin(bounds.whole(), filled, largest_))
        fill_smallest(bounds, transfer_function);
}

void MajorantGrid::fill_smallest(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    smallest_ = AlignedArray<std::uint8_t>(bounds.blocks());
    const TransferPointsView points = transfer_function.points_view();
    parallel_for(
        std::size_t{0}, bounds.blocks(),
        [&](std::size_t block) {
            smallest_[block] = smallest_of_block(bounds.block(block), bounds.whole().scale, points, largest_);
        },
        256);
}

/// Chessboard distances of empty blocks by two passes over half of the 26 neighbours each, which is exact for this
/// metric (Rosenfeld and Pfaltz 1968).
void MajorantGrid::measure_empty_space()
{
    const Vec3i blocks = majorant_blocks(volume_size_);
    const std::ptrdiff_t nx = blocks.x, ny = blocks.y, rows = static_cast<std::ptrdiff_t>(blocks.z) * ny;
    std::vector<std::uint8_t> distance(blocks_.size());
    std::transform(blocks_.begin(), blocks_.end(), distance.begin(),
                   [](std::uint8_t code) { return code == empty_block ? empty_block : std::uint8_t{0}; });
    std::vector<std::uint8_t> nearest(static_cast<std::size_t>(nx) + 2); // of the rows before, one to a side
    const auto pass = [&](std::ptrdiff_t direction) {
        for (std::ptrdiff_t i = 0; i < rows; ++i) {
            const std::ptrdiff_t row = direction > 0 ? i : rows - 1 - i, y = row % ny, z = row / ny;
            std::fill(nearest.begin(), nearest.end(), empty_block);
            const auto take = [&](std::ptrdiff_t dy, std::ptrdiff_t dz) {
                if (y + dy < 0 || y + dy >= ny || z + dz < 0 || z + dz >= blocks.z)
                    return;
                const std::uint8_t* other = distance.data() + (row + dy + dz * ny) * nx;
                std::uint8_t* to = nearest.data() + 1;
                for (std::ptrdiff_t x = 0; x < nx; ++x)
                    to[x] = std::min(to[x], other[x]);
            };
            take(-1, -direction), take(0, -direction), take(1, -direction), take(-direction, 0);
            std::uint8_t* line = distance.data() + row * nx;
            std::uint8_t before = empty_block;
            for (std::ptrdiff_t k = 0; k < nx; ++k) {
                const std::ptrdiff_t x = direction > 0 ? k : nx - 1 - k;
                const std::uint8_t* around = nearest.data() + x;
                const int least = std::min({before, around[0], around[1], around[2]});
                before = line[x] = static_cast<std::uint8_t>(std::min<int>(line[x], least + 1));
            }
        }
    };
    pass(1);
    pass(-1);
    for (std::size_t i = 0; i < blocks_.size(); ++i)
        if (blocks_[i] == empty_block)
            blocks_[i] = distance[i];
}

} // namespace lumisweep
