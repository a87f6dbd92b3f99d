#include "lumisweep/visibility/extinction_grid.h"

#include <algorithm>
#include <vector>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/visibility/classify_block.h"
#include "lumisweep/visibility/classify_setup.h"
#include "lumisweep/visibility/dither.h"

namespace lumisweep {
namespace {

std::size_t count(Vec3i size)
{
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

/// Sets job.table (which `memory` owns): steps of every raw value that occurs.
void make_table(ClassifyJob& job, std::vector<std::int32_t>& memory, const ScalarGrid& volume, const RawRange& range,
                const TransferFunction& tf, double scale)
{
    constexpr int offset = 1 << 15; // the lowest raw value of all types is −offset, the highest 2 · offset − 1
    memory.assign(3 * offset, 0);
    std::int32_t* table = memory.data() + offset;
    const TransferPointsView points = tf.points_view();
    const int first = static_cast<int>(range.low), end = static_cast<int>(range.high) + 1;
    parallel_for(
        first, end, [&](int raw) { table[raw] = steps_of_raw(points, volume.slope(), volume.intercept(), scale, raw); },
        1024);
    job.table = table;
    // The longest run of zeros.
    job.empty_first = first;
    job.empty_last = first - 1;
    for (int raw = first, run = first; raw < end; ++raw)
        if (table[raw] != 0) {
            run = raw + 1;
        } else if (raw - run > job.empty_last - job.empty_first) {
            job.empty_first = run;
            job.empty_last = raw;
        }
}

/// Blocks of a slice.
int blocks_of(Vec3i size) { return (size.y + classify_block_rows - 1) / classify_block_rows; }

bool classify_blocks(ClassifyBlock block, const ClassifyJob& job, const std::atomic<bool>* cancel)
{
    // A row of finest voxels in whole vectors or in whole level voxels (halved twice at most).
    const int row = std::max((job.volume_size.x + 15) / 16 * 16, job.size.x << std::min(job.mip_level, 2));
    const int blocks = blocks_of(job.size);
    parallel_for(0, job.size.z * blocks, [&](int task) {
        if (is_cancelled(cancel))
            return;
        AlignedArray<std::int32_t> steps(2 * static_cast<std::size_t>(row));
        AlignedArray<std::uint64_t> sums(static_cast<std::size_t>(job.size.x));
        AlignedArray<std::uint8_t> lines(64 * scratch_line, Contents::uninitialised);
        block(job, task / blocks, task % blocks * classify_block_rows, {steps.data(), sums.data(), lines.data()});
    });
    return !is_cancelled(cancel);
}

/// Joins what the blocks of a slice found along y, [block][line], to [line].
void join_blocks(std::vector<ExtinctionGrid::Filled>& filled, std::size_t lines)
{
    for (std::size_t i = lines; i < filled.size(); ++i) {
        ExtinctionGrid::Filled& joined = filled[i % lines];
        if (joined.first >= joined.last)
            joined = filled[i];
        else if (filled[i].first < filled[i].last)
            joined.last = filled[i].last;
    }
    filled.resize(lines);
}

/// Of that size, in the memory of before where it fits. An empty grid is all zeros, any other is written as a whole.
void fit(AlignedArray<std::uint8_t>& array, std::size_t size, float scale)
{
    if (array.size() != size) {
        array = AlignedArray<std::uint8_t>(); // so that not both are there at once
        array = AlignedArray<std::uint8_t>(size, scale > 0.0F ? Contents::uninitialised : Contents::zeros);
    } else if (!(scale > 0.0F)) {
        std::fill(array.begin(), array.end(), std::uint8_t{0});
    }
}

} // namespace

std::uint64_t ExtinctionGrid::bytes_needed(Vec3i size)
{
    const std::size_t lines =
        count({1, size.y, size.z}) + count({size.x, 1, size.z}) * static_cast<std::size_t>(blocks_of(size));
    return 2 * count(size) + lines * sizeof(Filled);
}

ExtinctionGrid classify(const ScalarGrid& volume, const RawRange& range, const TransferFunction& transfer_function,
                        int mip_level, ExtinctionLayouts layouts, const std::atomic<bool>* cancel)
{
    ExtinctionGrid grid;
    classify_into(grid, volume, range, transfer_function, mip_level, layouts, cancel);
    return grid;
}

bool classify_into(ExtinctionGrid& grid, const ScalarGrid& volume, const RawRange& range,
                   const TransferFunction& transfer_function, int mip_level, ExtinctionLayouts layouts,
                   const std::atomic<bool>* cancel)
{
    return classify_with(widest_classify_block(), grid, volume, range, transfer_function, mip_level, layouts, cancel);
}

bool classify_with(ClassifyBlock block, ExtinctionGrid& grid, const ScalarGrid& volume, const RawRange& range,
                   const TransferFunction& transfer_function, int mip_level, ExtinctionLayouts layouts,
                   const std::atomic<bool>* cancel)
{
    grid.size = level_size(volume.size(), mip_level);
    const double scale = extinction_of_step(volume, range, transfer_function);
    const bool transposed = layouts == ExtinctionLayouts::with_transposed;
    grid.volume_size = volume.size();
    grid.world_from_voxel = volume.world_from_voxel();
    grid.mip_level = mip_level;
    grid.scale = static_cast<float>(scale);
    fit(grid.stored, count(grid.size), grid.scale);
    fit(grid.transposed, transposed ? count(grid.size) : 0, grid.scale);
    grid.filled.clear();
    grid.filled_transposed.clear();
    if (!(grid.scale > 0.0F))
        return true;

    std::vector<std::int32_t> table;
    ClassifyJob job{};
    job.voxels = volume.data();
    job.type = volume.type();
    job.volume_size = volume.size();
    job.mip_level = mip_level;
    if (volume.type() == VoxelType::f32)
        job.floats = classification_of_floats(volume, transfer_function, scale);
    else
        make_table(job, table, volume, range, transfer_function, scale);
    job.dither = dither_numbers();
    job.size = grid.size;
    job.stored = grid.stored.data();
    job.transposed = transposed ? grid.transposed.data() : nullptr;
    const std::size_t x_lines = count({1, grid.size.y, grid.size.z}), y_lines = count({grid.size.x, 1, grid.size.z});
    grid.filled.resize(x_lines);
    job.filled = grid.filled.data();
    if (transposed) {
        grid.filled_transposed.resize(y_lines * static_cast<std::size_t>(blocks_of(job.size)));
        job.filled_transposed = grid.filled_transposed.data();
    }
    if (!classify_blocks(block, job, cancel))
        return false;
    if (transposed)
        join_blocks(grid.filled_transposed, y_lines);
    return true;
}

} // namespace lumisweep
