#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <type_traits>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "lumisweep/volume/majorant_grid.h"
#include "lumisweep/volume/raw_range.h"
#include "lumisweep/volume/whole_bounds.h"

namespace lumisweep {

namespace {

template <class Voxel>
struct Extremes {
    std::vector<Voxel> low, high;

    explicit Extremes(std::size_t n) : low(n), high(n) {}
    void clear()
    {
        using Limits = std::numeric_limits<Voxel>;
        std::fill(low.begin(), low.end(), Limits::has_infinity ? Limits::infinity() : Limits::max());
        std::fill(high.begin(), high.end(), Limits::has_infinity ? -Limits::infinity() : Limits::lowest());
    }
    /// Comparisons are false for NaN, which leaves it out.
    void take(const Voxel* from_low, const Voxel* from_high, std::size_t n)
    {
        Voxel* l = low.data();
        Voxel* h = high.data();
        for (std::size_t i = 0; i < n; ++i) {
            l[i] = from_low[i] < l[i] ? from_low[i] : l[i];
            h[i] = from_high[i] > h[i] ? from_high[i] : h[i];
        }
    }
};

/// Takes in other bounds.
void include(CellBounds& bounds, const CellBounds& other)
{
    if (!other.empty())
        bounds =
            bounds.empty() ? other : CellBounds{std::min(bounds.low, other.low), std::max(bounds.high, other.high)};
}

} // namespace

BoundsGrid::BoundsGrid(const ScalarGrid& volume)
{
    const Vec3i blocks = majorant_blocks(volume.size());
    blocks_ = AlignedArray<CellBounds>(static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) *
                                           static_cast<std::size_t>(blocks.z),
                                       Contents::uninitialised);
    cells_ = AlignedArray<CellBounds>(blocks_.size() * majorant_block_cells, Contents::uninitialised);
    whole_ = begin_bounds(volume, volume.type() == VoxelType::f32 ? raw_range(volume) : RawRange{});
    visit_voxels(volume, [&](const auto* voxels) { fill(volume.type(), voxels); });
}

std::uint64_t BoundsGrid::bytes_needed(const Vec3i& volume_size)
{
    const Vec3i blocks = majorant_blocks(volume_size);
    return static_cast<std::uint64_t>(blocks.x) * static_cast<std::uint64_t>(blocks.y) *
           static_cast<std::uint64_t>(blocks.z) * (1 + majorant_block_cells) * sizeof(CellBounds);
}

/// Extremes along z of whole slices, then along y, then along x.
template <class Voxel>
void BoundsGrid::fill(VoxelType type, const Voxel* voxels)
{
    const Vec3i size = whole_.volume_size, cells = majorant_cells(size), blocks = majorant_blocks(size);
    const auto nx = static_cast<std::size_t>(size.x), slice = nx * static_cast<std::size_t>(size.y);
    CellBounds range;
    std::mutex mutex;
    std::atomic<bool> gaps = false;
    parallel_for(0, blocks.z, [&](int bz) {
        const auto layer = static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y);
        const std::size_t first_block = static_cast<std::size_t>(bz) * layer;
        std::fill_n(cells_.data() + first_block * majorant_block_cells, layer * majorant_block_cells, CellBounds{});
        Extremes<Voxel> along_z(slice), along_y(nx);
        for (int cz = bz * majorant_block; cz < std::min((bz + 1) * majorant_block, cells.z); ++cz) {
            along_z.clear();
            const CellVoxels rz = voxels_of_cell(cz, size.z);
            for (int z = rz.begin; z < rz.end; ++z) {
                const Voxel* from = voxels + static_cast<std::size_t>(z) * slice;
                along_z.take(from, from, slice);
                if constexpr (std::is_floating_point_v<Voxel>)
                    if (!std::all_of(from, from + slice, [](Voxel v) { return std::isfinite(v); }))
                        gaps = true;
            }
            for (int cy = 0; cy < cells.y; ++cy) {
                along_y.clear();
                const CellVoxels ry = voxels_of_cell(cy, size.y);
                for (int y = ry.begin; y < ry.end; ++y) {
                    const std::size_t line = static_cast<std::size_t>(y) * nx;
                    along_y.take(along_z.low.data() + line, along_z.high.data() + line, nx);
                }
                const std::size_t row = first_block + static_cast<std::size_t>(cy / majorant_block * blocks.x);
                CellBounds* out = cells_.data() + row * majorant_block_cells +
                                  (cz % majorant_block * majorant_block + cy % majorant_block) * majorant_block;
                for (int cx = 0; cx < cells.x; ++cx) {
                    const CellVoxels rx = voxels_of_cell(cx, size.x);
                    auto x = static_cast<std::size_t>(rx.begin);
                    Voxel low = along_y.low[x], high = along_y.high[x];
                    for (++x; x < static_cast<std::size_t>(rx.end); ++x) {
                        low = along_y.low[x] < low ? along_y.low[x] : low;
                        high = along_y.high[x] > high ? along_y.high[x] : high;
                    }
                    out[cx / majorant_block * majorant_block_cells + cx % majorant_block] =
                        bounds_of(whole_.scale, low, high);
                }
            }
        }
        CellBounds all;
        for (std::size_t block = first_block; block < first_block + layer; ++block) {
            CellBounds of_block;
            for (int i = 0; i < majorant_block_cells; ++i)
                include(of_block, this->cells(block)[i]);
            blocks_[block] = of_block;
            include(all, of_block);
        }
        const std::lock_guard lock(mutex);
        include(range, all);
    });
    whole_ = end_bounds(whole_, type, range, gaps);
}

} // namespace lumisweep
