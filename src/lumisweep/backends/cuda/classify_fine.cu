// Levels 0 and 1: every thread has four bytes of rows at a time, and all its voxels on their way before it looks at
// one.
#include <type_traits>

#include "lumisweep/backends/cuda/device_steps.h"
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/words.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

template <class T, int level>
struct ClassifyFine {
    static constexpr int threads = 256, blocks_a_multiprocessor = 4;
    static constexpr int finest = 4 << level;              // voxels of a piece along x
    static constexpr int finest_rows = level == 0 ? 1 : 4; // of a piece
    // Enough bytes on their way at a time, and of floats no more code than they need, which have so many instructions.
    static constexpr bool floats = std::is_same_v<T, float>;
    static constexpr int pieces = level == 0 && !floats ? 4 : 1; // of a thread
    static constexpr int rows_at_a_time = floats ? 1 : finest_rows;
    static constexpr int voxel_words = finest * static_cast<int>(sizeof(T)) / 4;
    using Voxels = Words<voxel_words>;

    ClassifyWork work;
    bool aligned; ///< all rows of finest voxels, as Voxels

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        block.run_apart([&](int thread) {
            Piece piece[pieces];
            LUMISWEEP_UNROLL
            for (int p = 0; p < pieces; ++p)
                piece[p] = piece_at((block.index.x * pieces + p) * threads + thread);
            std::int32_t sums[pieces][4] = {};
            for (int first_row = 0; first_row < finest_rows; first_row += rows_at_a_time)
                add_rows(piece, first_row, sums);
            std::uint32_t stored[pieces];
            LUMISWEEP_UNROLL
            for (int p = 0; p < pieces; ++p)
                stored[p] = piece[p].inside ? stored_inside(piece[p], sums[p]) : stored_at_ends(piece[p]);
            LUMISWEEP_UNROLL
            for (int p = 0; p < pieces; ++p)
                if (piece[p].slice < work.size.z)
                    *reinterpret_cast<std::uint32_t*>(stored_row(work, piece[p].row) + row_margin + piece[p].first) =
                        stored[p];
        });
    }

private:
    /// Four level voxels of a row, of which some may lie in its margins.
    struct Piece {
        int row, slice; ///< row counts through all slices
        int y;
        int first;   ///< level voxel, from −row_margin on
        bool inside; ///< all voxels exist, and all finest ones along x
    };

    LUMISWEEP_HD Piece piece_at(int index) const
    {
        const int pieces_a_row = work.pitch / 4;
        Piece piece;
        piece.row = index / pieces_a_row;
        piece.slice = piece.row / work.size.y;
        piece.y = piece.row - piece.slice * work.size.y;
        piece.first = 4 * (index - piece.row * pieces_a_row) - row_margin;
        piece.inside =
            piece.slice < work.size.z && piece.first >= 0 && (piece.first << level) + finest <= work.volume_size.x;
        return piece;
    }

    LUMISWEEP_HD static int finest_y(const Piece& piece, int r) { return (piece.y << level) + r % 2; }
    LUMISWEEP_HD static int finest_z(const Piece& piece, int r) { return (piece.slice << level) + r / 2; }
    LUMISWEEP_HD bool has_row(const Piece& piece, int r) const
    {
        return finest_y(piece, r) < work.volume_size.y && finest_z(piece, r) < work.volume_size.z;
    }

    /// The next rows_at_a_time of the pieces that lie inside.
    LUMISWEEP_HD void add_rows(const Piece (&piece)[pieces], int first_row, std::int32_t (&sums)[pieces][4]) const
    {
        Voxels voxels[pieces][rows_at_a_time];
        LUMISWEEP_UNROLL
        for (int p = 0; p < pieces; ++p) {
            LUMISWEEP_UNROLL
            for (int r = 0; r < rows_at_a_time; ++r)
                if (piece[p].inside && has_row(piece[p], first_row + r))
                    voxels[p][r] = load(piece[p], first_row + r);
        }
        LUMISWEEP_UNROLL
        for (int p = 0; p < pieces; ++p) {
            LUMISWEEP_UNROLL
            for (int r = 0; r < rows_at_a_time; ++r)
                if (piece[p].inside && has_row(piece[p], first_row + r))
                    add(voxels[p][r], sums[p]);
        }
    }
    LUMISWEEP_HD void add(const Voxels& voxels, std::int32_t (&sums)[4]) const
    {
        LUMISWEEP_UNROLL
        for (int i = 0; i < finest; ++i)
            sums[i >> level] += steps_of(work, number_in<T>(voxels, i));
    }
    LUMISWEEP_HD Voxels load(const Piece& piece, int r) const
    {
        const T* voxels = finest_row<T>(work, finest_y(piece, r), finest_z(piece, r)) + (piece.first << level);
        return aligned ? load_aligned_words<voxel_words>(voxels) : load_words<voxel_words>(voxels);
    }

    LUMISWEEP_HD static std::int32_t mean(std::int32_t sum)
    {
        if constexpr (level == 0)
            return sum;
        else
            return rounded_mean(sum, 3 * level);
    }

    LUMISWEEP_HD std::uint32_t stored_inside(const Piece& piece, const std::int32_t (&sums)[4]) const
    {
        const Words<2> random = load_words<2>(dither_of(work, piece.row, piece.first));
        std::uint32_t stored = 0;
        LUMISWEEP_UNROLL
        for (int i = 0; i < 4; ++i)
            stored |= std::uint32_t{dithered(mean(sums[i]), number_in<std::uint16_t>(random, i))} << (8 * i);
        return stored;
    }

    LUMISWEEP_HD std::uint32_t stored_at_ends(const Piece& piece) const
    {
        std::uint32_t stored = 0;
        for (int b = 0; b < 4 && piece.slice < work.size.z; ++b) {
            const int i = min(max(piece.first + b, 0), work.size.x - 1);
            std::int32_t sum = 0;
            for (int r = 0; r < finest_rows; ++r)
                for (int x = i << level; x < min((i + 1) << level, work.volume_size.x) && has_row(piece, r); ++x)
                    sum += steps_of(work, finest_row<T>(work, finest_y(piece, r), finest_z(piece, r))[x]);
            stored |= std::uint32_t{dithered(mean(sum), *dither_of(work, piece.row, i))} << (8 * b);
        }
        return stored;
    }
};

template <class T, int level>
void launch_fine(const ClassifyWork& work, const Stream& stream)
{
    using Kernel = ClassifyFine<T, level>;
    const int pieces = work.size.y * work.size.z * (work.pitch / 4), in_block = Kernel::threads * Kernel::pieces;
    launch("classification", stream, {(pieces + in_block - 1) / in_block, 1, 1}, 0,
           Kernel{work, rows_aligned<T>(work, alignof(typename Kernel::Voxels))});
}

} // namespace

void launch_classify_fine(const ClassifyWork& work, const Stream& stream)
{
    const auto launch_as = [&]<class T>(const T*) {
        if (work.mip_level == 0)
            launch_fine<T, 0>(work, stream);
        else
            launch_fine<T, 1>(work, stream);
    };
    visit_voxels(work, launch_as);
}

} // namespace lumisweep::LUMISWEEP_CUDA
