#include "lumisweep/volume/majorant_grid.h"

#include <algorithm>
#include <array>
#include <bit>
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

constexpr std::uint8_t farthest = first_majorant_code - 1;

/// A block is crossed at once where that costs no more than this many tentative collisions more than cell by cell:
/// about what the steps from cell to cell take.
constexpr double spare_collisions = 1.0;

std::size_t count(const Vec3i& n)
{
    return static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
}

} // namespace

MajorantGrid::MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function)
    : volume_size_(bounds.volume_size()), cells_(bounds.blocks() * majorant_block_cells, Contents::uninitialised),
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
    // A side of n voxels takes floor(log2 n) bits, so volumes of less than 2³¹ voxels fit.
    const auto bits = [](int n) { return static_cast<int>(std::bit_width(static_cast<unsigned>(n - 1))); };
    const Vec3i cells = majorant_cells(volume_size_), blocks = majorant_blocks(volume_size_);
    return {blocks_.data(),
            cells_.data(),
            cells,
            blocks.x,
            blocks.x * blocks.y,
            bits(cells.x),
            bits(cells.x) + bits(cells.y),
            largest_,
            smallest_.data()};
}

/// Codes of cells and blocks; empty blocks are left at `farthest`.
void MajorantGrid::fill(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    const ExtinctionCodes extinction(bounds, transfer_function);
    largest_ = extinction.largest();
    std::array<float, last_majorant_code + 1> majorant{};
    for (int code = first_majorant_code; code <= last_majorant_code; ++code)
        majorant[static_cast<std::size_t>(code)] = majorant_of_code<float>(code, largest_);
    const auto spare = static_cast<float>(majorant_block_cells * spare_collisions / bounds.block_side());
    std::vector<float> sums(bounds.blocks());
    parallel_for(
        std::size_t{0}, bounds.blocks(),
        [&](std::size_t block) {
            std::uint8_t& code = blocks_[block];
            code = farthest;
            if (extinction.largest_code(bounds.block(block)) == 0)
                return;
            std::uint8_t* cells = cells_.data() + block * majorant_block_cells;
            const BoundsGrid::Bounds* of_cells = bounds.cells(block);
            std::uint8_t largest = 0;
            float sum = 0.0F;
            for (int i = 0; i < majorant_block_cells; ++i) {
                cells[i] = extinction.largest_code(of_cells[i]);
                largest = std::max(largest, cells[i]);
                sum += majorant[cells[i]];
            }
            sums[block] = sum;
            if (largest != 0)
                code = majorant[largest] * majorant_block_cells - sum <= spare ? largest : std::uint8_t{0};
        },
        64);
    double sum = 0.0, filled = 0.0;
    for (const float of_block : sums) {
        sum += static_cast<double>(of_block);
        filled += of_block > 0.0F ? majorant_block_cells : 0.0;
    }
    if (filled > 0.0 && sum * bounds.diagonal() <= thin_medium * filled && !bounds.has_gaps())
        fill_smallest(bounds, transfer_function);
}

void MajorantGrid::fill_smallest(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    smallest_ = AlignedArray<std::uint8_t>(bounds.blocks());
    const double codes_per_extinction = 256.0 / static_cast<double>(largest_) * (1.0 - 1e-5); // lookups round
    parallel_for(
        std::size_t{0}, bounds.blocks(),
        [&](std::size_t block) {
            const BoundsGrid::Bounds& b = bounds.block(block);
            if (b.empty())
                return;
            const BoundsGrid::Values values = bounds.values(b.low, b.high);
            const double smallest = transfer_function.min_extinction(values.low, values.high) -
                                    transfer_function.lookup_error(values.low) -
                                    1e-6 * static_cast<double>(largest_); // flanks from within the values
            smallest_[block] = static_cast<std::uint8_t>(std::clamp(smallest * codes_per_extinction, 0.0, 255.0));
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
                   [](std::uint8_t code) { return code == farthest ? farthest : std::uint8_t{0}; });
    std::vector<std::uint8_t> nearest(static_cast<std::size_t>(nx) + 2); // of the rows before, one to a side
    const auto pass = [&](std::ptrdiff_t direction) {
        for (std::ptrdiff_t i = 0; i < rows; ++i) {
            const std::ptrdiff_t row = direction > 0 ? i : rows - 1 - i, y = row % ny, z = row / ny;
            std::fill(nearest.begin(), nearest.end(), farthest);
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
            std::uint8_t before = farthest;
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
        if (blocks_[i] == farthest)
            blocks_[i] = distance[i];
}

} // namespace lumisweep
