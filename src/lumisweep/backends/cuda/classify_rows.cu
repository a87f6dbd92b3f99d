// What comes before and after the levels of classify_fine.cu and classify_coarse.cu: the table of steps by raw value,
// and rows along y from those along x.
#include "lumisweep/backends/cuda/classify_kernels.h"
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/words.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

struct FillTable {
    static constexpr int threads = 128, blocks_a_multiprocessor = 4;
    TableWork work;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            const int i = block.index.x * threads + thread;
            if (i < work.count)
                work.table[i] = steps_of_raw(work.tf, work.slope, work.intercept, work.scale, work.first + i);
        });
    }
};

/// A block turns 64 voxels along x of up to 128 neighbours along y of one slice, through shared memory. It counts y in
/// words of the rows that come out, margins and all: what lies outside of the volume repeats its end.
struct Transpose {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    static constexpr int x_voxels = 64, y_words = 32;
    static constexpr int line = y_words + 1; // words of shared memory, so that neighbours lie in other banks
    static constexpr int shared_bytes = x_voxels * line * 4;

    TransposeWork work;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        auto* lines = block.shared<std::uint32_t>(); // [x_voxels][line]
        const int first_x = block.index.y * x_voxels, first_word = block.index.x * y_words, z = block.index.z;
        block.run([&](int thread) {
            for (int i = thread; i < x_voxels / 4 * y_words; i += threads) {
                const int x = i % (x_voxels / 4) * 4, word = i / (x_voxels / 4);
                if (first_x + x >= work.size.x || 4 * (first_word + word) >= work.pitch)
                    continue;
                Words<4> rows;
                for (int r = 0; r < 4; ++r)
                    rows.word[r] = voxels_along_x(first_x + x, 4 * (first_word + word) - row_margin + r, z);
                const Words<4> turned = transposed_bytes(rows);
                for (int c = 0; c < 4; ++c)
                    lines[(x + c) * line + word] = turned.word[c];
            }
        });
        block.run([&](int thread) {
            for (int i = thread; i < x_voxels * y_words; i += threads) {
                const int x = i / y_words, word = i % y_words;
                if (first_x + x < work.size.x && 4 * (first_word + word) < work.pitch)
                    row_along_y(first_x + x, z)[first_word + word] = lines[x * line + word];
            }
        });
    }

private:
    LUMISWEEP_HD std::uint32_t voxels_along_x(int x, int y, int z) const
    {
        const int inside = min(max(y, 0), work.size.y - 1);
        const std::size_t row = static_cast<std::size_t>(z * work.size.y + inside);
        return *reinterpret_cast<const std::uint32_t*>(
            work.straight.rows + row * static_cast<std::size_t>(work.straight.pitch) + (row_margin + x));
    }
    LUMISWEEP_HD std::uint32_t* row_along_y(int x, int z) const
    {
        const std::size_t row = static_cast<std::size_t>(x * work.size.z + z);
        return reinterpret_cast<std::uint32_t*>(work.transposed + row * static_cast<std::size_t>(work.pitch));
    }
};

} // namespace

void launch_table(const TableWork& work, const Stream& stream)
{
    launch("the table of classification", stream, {(work.count + FillTable::threads - 1) / FillTable::threads, 1, 1}, 0,
           FillTable{work});
}

void launch_transpose(const TransposeWork& work, const Stream& stream)
{
    const Vec3i grid{(work.pitch / 4 + Transpose::y_words - 1) / Transpose::y_words,
                     (work.size.x + Transpose::x_voxels - 1) / Transpose::x_voxels, work.size.z};
    launch("the transposed classification", stream, grid, Transpose::shared_bytes, Transpose{work});
}

} // namespace lumisweep::LUMISWEEP_CUDA
