// Levels from 2 on: a block sums the finest voxels of a few neighbours along x, or of one level voxel.
#include "lumisweep/backends/cuda/device_steps.h"
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/words.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

template <class T>
struct ClassifyCoarse {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    static constexpr int columns = 32, rows_at_a_time = threads / columns; // a thread's voxels are four along x
    static constexpr int voxels_at_a_time = 4 * columns;                   // along x
    using Voxels = Words<static_cast<int>(sizeof(T))>;

    ClassifyWork work;
    int level_voxels; ///< of a block
    bool aligned;     ///< all rows of finest voxels, as Voxels

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        auto* sums = block.template shared<std::uint64_t>(); // [rows_at_a_time][columns]
        block.run([&](int thread) { sums[thread] = sum_of(block.index, thread); });
        block.run([&](int thread) {
            const int i = block.index.x * level_voxels + thread;
            if (thread >= level_voxels || i >= work.size.x)
                return;
            const int of_voxel = columns / level_voxels;
            std::uint64_t sum = 0;
            for (int r = 0; r < rows_at_a_time; ++r)
                for (int c = 0; c < of_voxel; ++c)
                    sum += sums[r * columns + thread * of_voxel + c];
            store(block.index, i, rounded_mean(sum, 3 * work.mip_level));
        });
    }

private:
    /// Of the thread's share of the block's finest voxels, all in one level voxel.
    LUMISWEEP_HD std::uint64_t sum_of(const Vec3i& block, int thread) const
    {
        const int level = work.mip_level;
        const Vec3i n = work.volume_size;
        const int first_x = block.x * (level_voxels << level), end_x = min(first_x + (level_voxels << level), n.x);
        const int first_y = block.y << level, height = min(1 << level, n.y - first_y);
        const int first_z = block.z << level, depth = min(1 << level, n.z - first_z);
        std::uint64_t sum = 0;
        for (int r = thread / columns; r < height * depth; r += rows_at_a_time) {
            const T* row = finest_row<T>(work, first_y + r % height, first_z + r / height);
            for (int x = first_x + 4 * (thread % columns); x < end_x; x += voxels_at_a_time)
                sum += sum_of_four(row + x, end_x - x);
        }
        return sum;
    }
    /// Of the first `count` of them.
    LUMISWEEP_HD std::uint32_t sum_of_four(const T* raw, int count) const
    {
        std::int32_t sum = 0;
        if (count >= 4) {
            const Voxels voxels = aligned ? load_aligned_words<sizeof(T)>(raw) : load_words<sizeof(T)>(raw);
            LUMISWEEP_UNROLL
            for (int i = 0; i < 4; ++i)
                sum += steps_of(work, number_in<T>(voxels, i));
        } else {
            for (int i = 0; i < count; ++i)
                sum += steps_of(work, raw[i]);
        }
        return static_cast<std::uint32_t>(sum);
    }

    LUMISWEEP_HD void store(const Vec3i& block, int i, std::int32_t steps) const
    {
        const int row = block.z * work.size.y + block.y;
        const std::uint8_t stored = dithered(steps, *dither_of(work, row, i));
        std::uint8_t* bytes = stored_row(work, row);
        const int first = i == 0 ? 0 : row_margin + i;
        const int last = i == work.size.x - 1 ? work.pitch - 1 : row_margin + i;
        for (int b = first; b <= last; ++b)
            bytes[b] = stored;
    }
};

template <class T>
void launch_coarse(const ClassifyWork& work, const Stream& stream)
{
    using Kernel = ClassifyCoarse<T>;
    const int level_voxels =
        (1 << work.mip_level) < Kernel::voxels_at_a_time ? Kernel::voxels_at_a_time >> work.mip_level : 1;
    launch("classification", stream, {(work.size.x + level_voxels - 1) / level_voxels, work.size.y, work.size.z},
           Kernel::threads * static_cast<int>(sizeof(std::uint64_t)),
           Kernel{work, level_voxels, rows_aligned<T>(work, alignof(typename Kernel::Voxels))});
}

} // namespace

void launch_classify_coarse(const ClassifyWork& work, const Stream& stream)
{
    visit_voxels(work, [&]<class T>(const T*) { launch_coarse<T>(work, stream); });
}

} // namespace lumisweep::LUMISWEEP_CUDA
