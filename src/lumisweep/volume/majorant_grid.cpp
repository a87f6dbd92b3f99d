#include "lumisweep/volume/majorant_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "lumisweep/volume/extinction_codes.h"

namespace lumisweep {

Vec3i majorant_cells(const Vec3i& volume_size)
{
    return {majorant_cells(volume_size.x), majorant_cells(volume_size.y), majorant_cells(volume_size.z)};
}

namespace {

std::size_t count(const Vec3i& n)
{
    return static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
}

Vec3i blocks_of(const Vec3i& cells)
{
    const auto blocks = [](int n) { return (n + majorant_block - 1) / majorant_block; };
    return {blocks(cells.x), blocks(cells.y), blocks(cells.z)};
}

} // namespace

MajorantGrid::MajorantGrid(const BoundsGrid& bounds, const TransferFunction& transfer_function, double diagonal_world)
    : cells_(bounds.cells()), blocks_(blocks_of(cells_)), codes_(bounds.size(), Contents::uninitialised),
      distance_(count(blocks_))
{
    fill(bounds, transfer_function);
    if (!bounds.has_gaps() && mean_majorant() * diagonal_world <= thin_medium) {
        const SmallestExtinctionCodes extinction(bounds, transfer_function, largest_);
        smallest_ = AlignedArray<std::uint8_t>(bounds.size(), Contents::uninitialised);
        parallel_for(
            std::size_t{0}, bounds.size(),
            [&](std::size_t cell) { smallest_[cell] = extinction.smallest_code(bounds.bounds(cell)); }, 1024);
    }
    measure_empty_space();
}

double MajorantGrid::mean_majorant() const
{
    // Rows are counted one by one, so that the sum does not depend on threads.
    std::vector<std::array<std::uint32_t, 256>> counts(static_cast<std::size_t>(cells_.z));
    const std::size_t slice = static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y);
    parallel_for(std::size_t{0}, counts.size(), [&](std::size_t z) {
        for (std::size_t i = z * slice; i < (z + 1) * slice; ++i)
            ++counts[z][codes_[i]];
    });
    double sum = 0.0, filled = 0.0;
    for (int code = first_majorant_code; code <= last_majorant_code; ++code)
        for (const auto& of_slice : counts) {
            const double n = of_slice[static_cast<std::size_t>(code)];
            sum += n * static_cast<double>(majorant_of_code<float>(code, largest_));
            filled += n;
        }
    return filled > 0.0 ? sum / filled : 0.0;
}

std::uint64_t MajorantGrid::bytes_needed(const Vec3i& volume_size)
{
    const Vec3i cells = majorant_cells(volume_size);
    return 2 * count(cells) + count(blocks_of(cells));
}

MajorantView MajorantGrid::view() const
{
    // Sides of n voxels take floor(log2 n) bits, so volumes of less than 2³¹ voxels fit.
    const auto bits = [](int n) { return static_cast<int>(std::bit_width(static_cast<unsigned>(n - 1))); };
    return {codes_.data(), cells_.x,        cells_.y, cells_.z, bits(cells_.x), bits(cells_.x) + bits(cells_.y),
            largest_,      smallest_.data()};
}

/// Codes of all cells, and the blocks that hold anything.
void MajorantGrid::fill(const BoundsGrid& bounds, const TransferFunction& transfer_function)
{
    const ExtinctionCodes extinction(bounds, transfer_function);
    largest_ = extinction.largest();
    const auto nx = static_cast<std::size_t>(cells_.x);
    parallel_for(0, blocks_.y * blocks_.z, [&](int row_of_blocks) {
        const int by = row_of_blocks % blocks_.y, bz = row_of_blocks / blocks_.y;
        std::uint8_t* block =
            distance_.data() + static_cast<std::size_t>(row_of_blocks) * static_cast<std::size_t>(blocks_.x);
        std::fill_n(block, blocks_.x, farthest);
        for (int z = bz * majorant_block; z < std::min((bz + 1) * majorant_block, cells_.z); ++z) {
            for (int y = by * majorant_block; y < std::min((by + 1) * majorant_block, cells_.y); ++y) {
                const std::size_t row =
                    (static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_.y) + static_cast<std::size_t>(y)) *
                    nx;
                for (std::size_t x = 0; x < nx; ++x) {
                    const std::uint8_t code = extinction.largest_code(bounds.bounds(row + x));
                    codes_[row + x] = code;
                    if (code != 0)
                        block[x / majorant_block] = 0;
                }
            }
        }
    });
}

/// Chessboard distances of blocks by two passes over half of the 26 neighbours each, which is exact for this metric
/// (Rosenfeld and Pfaltz 1968); then empty cells take over the distance of their block.
void MajorantGrid::measure_empty_space()
{
    const std::ptrdiff_t nx = blocks_.x, ny = blocks_.y, nz = blocks_.z;
    std::uint8_t* d = distance_.data();
    std::vector<std::uint8_t> nearest(static_cast<std::size_t>(nx) + 2, farthest); // of the rows before, one to a side
    const auto pass = [&](std::ptrdiff_t direction) {
        for (std::ptrdiff_t i = 0; i < nz * ny; ++i) {
            const std::ptrdiff_t row = direction > 0 ? i : nz * ny - 1 - i, y = row % ny, z = row / ny;
            std::fill(nearest.begin(), nearest.end(), farthest);
            const auto take = [&](std::ptrdiff_t dy, std::ptrdiff_t dz) {
                if (y + dy < 0 || y + dy >= ny || z + dz < 0 || z + dz >= nz)
                    return;
                const std::uint8_t* other = d + (row + dy + dz * ny) * nx;
                for (std::ptrdiff_t x = 0; x < nx; ++x)
                    nearest[static_cast<std::size_t>(x + 1)] =
                        std::min(nearest[static_cast<std::size_t>(x + 1)], other[x]);
            };
            take(-1, -direction), take(0, -direction), take(1, -direction), take(-direction, 0);
            std::uint8_t* line = d + row * nx;
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
    parallel_for(0, cells_.y * cells_.z, [&](int row) {
        const int y = row % cells_.y, z = row / cells_.y;
        const std::uint8_t* distance =
            d + (static_cast<std::ptrdiff_t>(z / majorant_block) * ny + y / majorant_block) * nx;
        std::uint8_t* codes = codes_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(cells_.x);
        for (int x = 0; x < cells_.x; x += majorant_block)
            if (distance[x / majorant_block] != 0)
                std::memset(codes + x, distance[x / majorant_block],
                            static_cast<std::size_t>(std::min(majorant_block, cells_.x - x)));
    });
}

} // namespace lumisweep
