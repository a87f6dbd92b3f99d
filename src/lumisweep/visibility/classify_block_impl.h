// Body of classify_block.h over the lane type F, included by one file per instruction set. That file gives
// ClassifyLanes<F> and the way to find segments.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/visibility/classify_steps.h"
#include "lumisweep/visibility/dither.h"
#include "lumisweep/visibility/transpose_block.h"

namespace lumisweep {
namespace {

enum class Sum { first, further };

/// Takes whole vectors: reads less than a vector of voxels behind the row's end (the row behind it, or padding).
template <class F, Sum sum, class Steps, class T>
LUMISWEEP_HD void add_row(const Steps& steps_of, const T* raw, int count, std::int32_t* steps)
{
    // Far enough for the memory's latency; the processor's own prefetching stops at every page of 4 KB.
    constexpr int bytes_ahead = 4096, line = 64 / static_cast<int>(sizeof(T));
    for (int i = 0; i < count; i += lane_width<F>) {
        if (i % line == 0)
            __builtin_prefetch(reinterpret_cast<const char*>(raw + i) + bytes_ahead);
        const auto v = steps_of.load_raw(raw + i);
        if (steps_of.empty(v)) {
            if constexpr (sum == Sum::first)
                store(steps + i, int_of<F>(0));
        } else if constexpr (sum == Sum::first) {
            store(steps + i, steps_of(v));
        } else {
            store(steps + i, steps_of(v) + load<F>(steps + i));
        }
    }
}

LUMISWEEP_HD int smaller(int a, int b) { return a < b ? a : b; }

LUMISWEEP_HD void dither_row(const ClassifyJob& job, std::size_t row, const std::int32_t* __restrict steps)
{
    std::uint8_t* __restrict stored = job.stored + row * static_cast<std::size_t>(job.size.x);
    for (int first = 0; first < job.size.x; first += dither_run) {
        const std::uint16_t* __restrict random =
            job.dither + dither_start(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(first / dither_run));
        const auto dither = [&](int count) {
            for (int i = 0; i < count; ++i)
                stored[first + i] = dithered(steps[first + i], random[i]);
        };
        if (first + dither_run <= job.size.x)
            dither(dither_run);
        else
            dither(job.size.x - first);
    }
}

/// Looks from both ends, a line of 64 at a time.
template <class F>
LUMISWEEP_HD ExtinctionGrid::Filled filled_of(const std::uint8_t* voxels, int count)
{
    constexpr int line = 64;
    int first = 0, last = count / line * line;
    std::uint8_t rest = 0;
    for (int i = last; i < count; ++i)
        rest = static_cast<std::uint8_t>(rest | voxels[i]);
    if (rest != 0) {
        last = count;
    } else {
        while (last > 0 && !ClassifyLanes<F>::any_of_64(voxels + last - line))
            last -= line;
        if (last == 0)
            return {0, 0};
    }
    while (first + line <= last && !ClassifyLanes<F>::any_of_64(voxels + first))
        first += line;
    return {first, last};
}

/// Sums rows of finest voxels into one of level voxels' means.
template <class F, class Steps, class T>
class MeanRow {
public:
    MeanRow(const ClassifyJob& job, const Steps& steps_of, const T* voxels, const ClassifyScratch& scratch)
        : job_(job), steps_of_(steps_of), voxels_(voxels), scratch_(scratch)
    {
    }

    /// The means, in 16.16 fixed point.
    const std::int32_t* operator()(int slice, int row)
    {
        const int level = job_.mip_level;
        const int end_z = smaller((slice + 1) << level, job_.volume_size.z);
        const int end_y = smaller((row + 1) << level, job_.volume_size.y);
        for (int i = 0; level > 2 && i < job_.size.x; ++i)
            scratch_.sums[i] = 0;
        int rows = 0;
        for (int z = slice << level; z < end_z; ++z)
            for (int y = row << level; y < end_y; ++y) {
                add(z, y, rows == 0);
                // 128 rows of less than 2^24 fit into 32 bits with a sign.
                if (++rows == 128) {
                    widen();
                    rows = 0;
                }
            }
        if (level <= 2)
            return narrow_mean(level);
        if (rows > 0)
            widen();
        return wide_mean(3 * level);
    }

private:
    void add(int z, int y, bool first)
    {
        const T* raw = voxels_ + (static_cast<std::size_t>(z) * static_cast<std::size_t>(job_.volume_size.y) +
                                  static_cast<std::size_t>(y)) *
                                     static_cast<std::size_t>(job_.volume_size.x);
        if (first)
            add_row<F, Sum::first>(steps_of_, raw, job_.volume_size.x, scratch_.steps);
        else
            add_row<F, Sum::further>(steps_of_, raw, job_.volume_size.x, scratch_.steps);
    }

    /// Halves the row `level` times; sums of 4³ voxels fit into 32 bits.
    const std::int32_t* narrow_mean(int level)
    {
        int count = job_.size.x << level;
        for (int x = job_.volume_size.x; x < count; ++x)
            scratch_.steps[x] = 0;
        const std::int32_t* from = scratch_.steps;
        std::int32_t* to = scratch_.steps + count;
        for (int halved = 1; halved < level; ++halved) {
            count /= 2;
            add_pairs(from, to, count);
            from = to;
            to += count;
        }
        mean_of_pairs(from, to, count / 2, 3 * level);
        return to;
    }

    static void add_pairs(const std::int32_t* __restrict from, std::int32_t* __restrict to, int count)
    {
        for (int i = 0; i < count; ++i)
            to[i] = from[2 * i] + from[2 * i + 1];
    }

    static void mean_of_pairs(const std::int32_t* __restrict from, std::int32_t* __restrict to, int count, int shift)
    {
        for (int i = 0; i < count; ++i)
            to[i] = rounded_mean(from[2 * i] + from[2 * i + 1], shift);
    }

    void widen()
    {
        for (int i = 0; i < job_.size.x; ++i) {
            const int end = smaller((i + 1) << job_.mip_level, job_.volume_size.x);
            for (int x = i << job_.mip_level; x < end; ++x)
                scratch_.sums[i] += static_cast<std::uint32_t>(scratch_.steps[x]);
        }
    }

    const std::int32_t* wide_mean(int shift)
    {
        for (int i = 0; i < job_.size.x; ++i)
            scratch_.steps[i] = rounded_mean(scratch_.sums[i], shift);
        return scratch_.steps;
    }

    const ClassifyJob& job_;
    const Steps& steps_of_;
    const T* voxels_;
    const ClassifyScratch& scratch_;
};

template <class F, class Steps, class T>
void classify_rows(const ClassifyJob& job, const T* voxels, int slice, int first_row, int end_row,
                   const ClassifyScratch& scratch)
{
    const Steps steps_of(job);
    MeanRow<F, Steps, T> mean(job, steps_of, voxels, scratch);
    for (int j = first_row; j < end_row; ++j) {
        const std::size_t row =
            static_cast<std::size_t>(slice) * static_cast<std::size_t>(job.size.y) + static_cast<std::size_t>(j);
        if (job.mip_level == 0) {
            add_row<F, Sum::first>(steps_of, voxels + row * static_cast<std::size_t>(job.size.x), job.size.x,
                                   scratch.steps);
            dither_row(job, row, scratch.steps);
        } else {
            dither_row(job, row, mean(slice, j));
        }
        job.filled[row] = filled_of<F>(job.stored + row * static_cast<std::size_t>(job.size.x), job.size.x);
    }
}

template <class F>
void transpose_rows(const ClassifyJob& job, int slice, int first_row, int end_row, std::uint8_t* lines)
{
    const std::size_t nx = static_cast<std::size_t>(job.size.x), ny = static_cast<std::size_t>(job.size.y);
    const std::size_t stride = static_cast<std::size_t>(job.size.z) * ny;
    const std::size_t rows = static_cast<std::size_t>(end_row - first_row);
    const std::size_t first = static_cast<std::size_t>(slice) * ny + static_cast<std::size_t>(first_row);
    const std::uint8_t* from = job.stored + first * nx;
    std::uint8_t* to = job.transposed + first;
    const std::size_t block = static_cast<std::size_t>(first_row / classify_block_rows);
    ExtinctionGrid::Filled* filled = job.filled_transposed + block * nx * static_cast<std::size_t>(job.size.z);
    const bool large = nx >= 64 && rows >= 64;
    for (std::size_t x = 0; x < nx; x += 64) {
        // Whole squares: the last ones overlap those before them.
        const std::size_t begin = large && x + 64 > nx ? nx - 64 : x, end = x + 64 < nx ? x + 64 : nx;
        if (large)
            for (std::size_t y = 0; y < rows; y += 64) {
                const std::size_t begin_y = y + 64 > rows ? rows - 64 : y;
                ClassifyLanes<F>::transpose_64(from + begin_y * nx + begin, nx, lines + begin_y, scratch_line);
            }
        else
            transpose(from + begin, nx, lines, scratch_line, end - begin, rows);
        for (std::size_t i = x; i < end; ++i) {
            const std::uint8_t* line = lines + (i - begin) * scratch_line;
            ClassifyLanes<F>::copy(to + i * stride, line, rows);
            const ExtinctionGrid::Filled part = filled_of<F>(line, end_row - first_row);
            filled[i * static_cast<std::size_t>(job.size.z) + static_cast<std::size_t>(slice)] =
                part.first < part.last ? ExtinctionGrid::Filled{first_row + part.first, first_row + part.last} : part;
        }
    }
}

template <class F, class FloatSegments>
void classify_block_lanes(const ClassifyJob& job, int slice, int first_row, const ClassifyScratch& scratch)
{
    const int end_row = smaller(first_row + classify_block_rows, job.size.y);
    const auto rows_of = [&]<class Steps, class T>(const T* voxels) {
        classify_rows<F, Steps>(job, voxels, slice, first_row, end_row, scratch);
    };
    switch (job.type) {
    case VoxelType::u8: rows_of.template operator()<TableSteps<F>>(static_cast<const std::uint8_t*>(job.voxels)); break;
    case VoxelType::u16:
        rows_of.template operator()<TableSteps<F>>(static_cast<const std::uint16_t*>(job.voxels));
        break;
    case VoxelType::i16:
        rows_of.template operator()<TableSteps<F>>(static_cast<const std::int16_t*>(job.voxels));
        break;
    default:
        rows_of.template operator()<LoadedFloatSteps<F, FloatSegments>>(static_cast<const float*>(job.voxels));
        break;
    }
    if (job.transposed != nullptr)
        transpose_rows<F>(job, slice, first_row, end_row, scratch.lines);
}

} // namespace
} // namespace lumisweep
