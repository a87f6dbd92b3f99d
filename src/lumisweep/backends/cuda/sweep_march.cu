// The march on the device: sweep_geometry.h's sums in whole numbers, so that their order does not matter and they equal
// the CPU's.
//
// A block takes a tile of 128 × 32 rays of one line through all slices. A warp has 8 rows of rays and a thread 4
// neighbouring rays of each, whose sums stay in registers. The voxels that a tile looks at in a slice, 129 × 33, come
// to shared memory two slices ahead, in rows of whole 16 bytes. For the rays beside them a thread takes two words of a
// voxel row; it is the high row of one row of rays and then the low row of the next, two bytes and two weights each.
// At a slice of cells the rays' sums change hands in shared memory.
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"
#include "lumisweep/backends/cuda/sweep_rays.h"
#include "lumisweep/visibility/sweep_optics.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// Pieces whose voxels are fetched together.
constexpr int stage_pieces = 2;

/// Shared memory. Pieces are known a stage before their voxels are fetched: three stages of them are in use, and a
/// power of two makes remainders cheap.
constexpr int pieces_at = 2 * stage_pieces * window_bytes, piece_stages = 4;
constexpr int exchange_at = pieces_at + piece_stages * stage_pieces * static_cast<int>(sizeof(MarchPiece));
/// Even and odd rays apart, so that cells two rays apart read neighbours; in different banks, for cells one ray apart.
constexpr int odd_rays = tile_v * tile_u / 2 + 16;
constexpr int range_at = exchange_at + 4 * (2 * odd_rays - 16);
constexpr int march_shared_bytes = range_at + 16;
static_assert((stage_pieces & (stage_pieces - 1)) == 0 && warps % stage_pieces == 0);
static_assert(window_bytes % 16 == 0 && exchange_at % 16 == 0 && range_at % 16 == 0);

struct MarchRays {
    static constexpr int threads = warps * warp_lanes, blocks_a_multiprocessor = 6;
    SweepBatch batch;
    VoxelsView voxels;

    /// A block's tile, and what of the line concerns it.
    struct Tile {
        const LineView& view;
        const MarchPiece* pieces; ///< of the line
        int line, tile_index_u, tile_index_v;
        int u, v;            ///< its first ray
        int first, end;      ///< pieces that it counts
        int lookup, lookups; ///< slices of cells that it looks up: the next, behind the last

        LUMISWEEP_HD bool counts(const MarchPiece& piece) const
        {
            return piece.first_u < u + tile_u && piece.last_u > u && piece.first_v < v + tile_v && piece.last_v > v;
        }
    };
    /// A slice of cells: the piece before which it is looked up, and the tile's cells in it.
    struct Lookup {
        int before, first_u, last_u, first_v, last_v;
    };

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        const int line = block.index.z;
        const LineView& view = batch.line(line);
        Tile tile{view,
                  batch.lines.pieces + view.first_piece,
                  line,
                  block.index.x,
                  block.index.y,
                  block.index.x * tile_step_u,
                  block.index.y * tile_step_v,
                  0,
                  0,
                  0,
                  0};
        if (tile.u >= view.u.ray_count - 1 || tile.v >= view.v.ray_count - 1)
            return;
        find_ranges(block, tile);
        march(block, tile);
    }

private:
    // ---- the tile's part of the line ----
    LUMISWEEP_HD void find_ranges(const Block<threads>& block, Tile& tile) const
    {
        std::uint32_t* range = block.shared<std::uint32_t>(range_at);
        block.run([&](int thread) {
            if (thread < 4)
                range[thread] = thread % 2 == 0 ? 0x7fffffffU : 0U;
        });
        block.run([&](int thread) {
            std::uint32_t first = 0x7fffffffU, end = 0;
            const auto take = [&](int i) {
                const std::uint32_t index = static_cast<std::uint32_t>(i);
                first = index < first ? index : first;
                end = index + 1;
            };
            for (int p = thread; p < tile.view.piece_count; p += threads)
                if (tile.counts(tile.pieces[p]))
                    take(p);
            share_range(range, first, end);
            first = 0x7fffffffU;
            end = 0;
            for (int k = thread; k < tile.view.cells; k += threads) {
                const Lookup lookup = cells_of(tile, k);
                if (lookup.first_u < lookup.last_u && lookup.first_v < lookup.last_v)
                    take(k);
            }
            share_range(range + 2, first, end);
        });
        tile.end = static_cast<int>(range[1]);
        tile.first = tile.end > 0 ? static_cast<int>(range[0]) : 0;
        tile.lookups = static_cast<int>(range[3]);
        tile.lookup = tile.lookups > 0 ? static_cast<int>(range[2]) : 0;
    }
    LUMISWEEP_HD static void share_range(std::uint32_t* range, std::uint32_t first, std::uint32_t end)
    {
        if (first < end) {
            atomic_min(range, first);
            atomic_max(range + 1, end);
        }
    }
    LUMISWEEP_HD Lookup cells_of(const Tile& tile, int k) const
    {
        const std::int32_t* u = batch.scratch.tiles(tile.line, k, 0) + tile.tile_index_u;
        const std::int32_t* v = batch.scratch.tiles(tile.line, k, 1) + tile.tile_index_v;
        return {batch.lines.slab_begin[tile.view.first_slab + k + 1], u[0], u[1], v[0], v[1]};
    }
    LUMISWEEP_HD Lookup next_lookup(const Tile& tile) const
    {
        constexpr int never = 0x7fffffff;
        return tile.lookup < tile.lookups ? cells_of(tile, tile.lookup) : Lookup{never, 0, 0, 0, 0};
    }

    // ---- the march ----
    LUMISWEEP_HD void march(const Block<threads>& block, Tile& tile) const
    {
        const VoxelRows rows(voxels, tile.view.axis);
        PerThread<RaySums, threads> sums;
        block.run([&](int thread) {
            sums[thread] = RaySums{};
            copy_pieces(block, tile, thread, 0);
            copy_pieces(block, tile, thread, 1);
            end_copies();
            wait_for_copies<0>();
        });
        block.run_apart([&](int thread) {
            copy_windows(block, tile, rows, thread, 0);
            end_copies();
        });
        Lookup lookup = next_lookup(tile);
        bool exchange_is_read = false; // and no barrier since
        for (int piece = tile.first;; ++piece) {
            while (tile.lookup < tile.lookups && (lookup.before <= piece || piece >= tile.end)) {
                if (exchange_is_read)
                    block.run([](int) {});
                block.run([&](int thread) { put(block, thread, sums[thread]); });
                block.run_apart([&](int thread) { look_up(block, tile, lookup, thread); });
                exchange_is_read = true;
                ++tile.lookup;
                lookup = next_lookup(tile);
            }
            if (piece >= tile.end)
                break;
            const int in_range = piece - tile.first;
            if ((in_range & (stage_pieces - 1)) == 0) {
                const int stage = in_range / stage_pieces;
                block.run([](int) { wait_for_copies<0>(); });
                exchange_is_read = false;
                block.run_apart([&](int thread) {
                    copy_windows(block, tile, rows, thread, stage + 1);
                    copy_pieces(block, tile, thread, stage + 2);
                    end_copies();
                });
            }
            block.run_apart([&](int thread) { march_piece(block, tile, thread, in_range, sums[thread]); });
        }
        if (tile.view.direction[1] >= 0) {
            if (exchange_is_read)
                block.run([](int) {});
            block.run([&](int thread) { put(block, thread, sums[thread]); });
            block.run_apart([&](int thread) { store_totals(block, tile, thread); });
        }
    }

    LUMISWEEP_HD static MarchPiece* piece_in_range(const Block<threads>& block, int in_range)
    {
        return block.shared<MarchPiece>(pieces_at) + (in_range & (piece_stages * stage_pieces - 1));
    }
    LUMISWEEP_HD static std::uint8_t* window_in_range(const Block<threads>& block, int in_range)
    {
        return block.shared<std::uint8_t>((in_range & (2 * stage_pieces - 1)) * window_bytes);
    }

    LUMISWEEP_HD static void copy_pieces(const Block<threads>& block, const Tile& tile, int thread, int stage)
    {
        constexpr int halves = static_cast<int>(sizeof(MarchPiece)) / 16;
        const int in_range = stage * stage_pieces + thread / halves;
        if (thread < stage_pieces * halves && tile.first + in_range < tile.end) {
            const int byte = 16 * (thread % halves);
            copy_16_async(reinterpret_cast<std::byte*>(piece_in_range(block, in_range)) + byte,
                          reinterpret_cast<const std::byte*>(tile.pieces + tile.first + in_range) + byte);
        }
    }

    /// The voxels that rays which count look at. Voxels beyond a row's margin are those of rays that do not count.
    LUMISWEEP_HD static void copy_windows(const Block<threads>& block, const Tile& tile, const VoxelRows& rows,
                                          int thread, int stage)
    {
        constexpr int warps_a_piece = warps / stage_pieces, rows_at_once = warp_lanes / window_chunks;
        const int warp = thread / warp_lanes, lane = thread % warp_lanes;
        const int in_range = stage * stage_pieces + warp / warps_a_piece;
        if (tile.first + in_range >= tile.end || lane >= rows_at_once * window_chunks)
            return;
        const MarchPiece& piece = *piece_in_range(block, in_range);
        const int chunk = lane % window_chunks, first_row = lane / window_chunks;
        const int byte = row_margin + piece.voxel_u + tile.u, offset = byte & 15;
        if (16 * chunk + 15 < offset + piece.first_u - tile.u || 16 * chunk > offset + piece.last_u - tile.u)
            return;
        const int column = 16 * between((byte >> 4) + chunk, 0, rows.pitch / 16 - 1);
        const std::uint8_t* from = rows.rows + static_cast<std::size_t>(piece.slice) * rows.slice_stride + column;
        std::uint8_t* to = window_in_range(block, in_range) + 16 * chunk;
        const int last_row = between(piece.last_v - tile.v, 0, tile_v), v = piece.voxel_v + tile.v;
        for (int row = rows_at_once * (warp % warps_a_piece) + first_row; row <= last_row;
             row += rows_at_once * warps_a_piece) {
            const int voxel_row = between(v + row, 0, rows.rows_of_slice - 1);
            copy_16_async(to + row * window_row, from + static_cast<std::size_t>(voxel_row) * rows.row_stride);
        }
    }

    LUMISWEEP_HD static void march_piece(const Block<threads>& block, const Tile& tile, int thread, int in_range,
                                         RaySums& sums)
    {
        const MarchPiece piece = *piece_in_range(block, in_range);
        const int warp = thread / warp_lanes, lane = thread % warp_lanes;
        const int row = tile.v + warp * rows_a_warp, ray = tile.u + lane * rays_a_thread;
        if (piece.last_v <= row || piece.first_v >= row + rows_a_warp)
            return;
        const int offset = (row_margin + piece.voxel_u + tile.u) & 15;
        const std::uint32_t* words = reinterpret_cast<const std::uint32_t*>(window_in_range(block, in_range)) +
                                     warp * rows_a_warp * (window_row / 4) + lane + offset / 4;
        // The same for a whole warp.
        const bool all_rows = piece.first_v <= row && piece.last_v >= row + rows_a_warp;
        if (piece.first_u <= tile.u && piece.last_u >= tile.u + tile_u)
            all_rows ? add_piece<true, true>(piece, words, offset & 3, row, ray, sums)
                     : add_piece<true, false>(piece, words, offset & 3, row, ray, sums);
        else
            all_rows ? add_piece<false, true>(piece, words, offset & 3, row, ray, sums)
                     : add_piece<false, false>(piece, words, offset & 3, row, ray, sums);
    }

    // ---- where rays change hands ----
    LUMISWEEP_HD static int exchanged(int row, int ray) { return ray % 2 * odd_rays + row * (tile_u / 2) + ray / 2; }

    LUMISWEEP_HD static void put(const Block<threads>& block, int thread, const RaySums& sums)
    {
        std::uint32_t* exchange = block.shared<std::uint32_t>(exchange_at);
        const int row = thread / warp_lanes * rows_a_warp, ray = thread % warp_lanes * rays_a_thread;
        LUMISWEEP_UNROLL
        for (int r = 0; r < rows_a_warp; ++r)
            LUMISWEEP_UNROLL
        for (int i = 0; i < 2; ++i) {
            Pair* pair = reinterpret_cast<Pair*>(exchange + exchanged(row + r, ray + i));
            *pair = {sums.of[r][i], sums.of[r][i + 2]};
        }
    }
    struct alignas(8) Pair {
        std::uint32_t first, second;
    };

    /// A warp takes every fourth row of cells.
    LUMISWEEP_HD void look_up(const Block<threads>& block, const Tile& tile, const Lookup& lookup, int thread) const
    {
        const std::int32_t* exchange = block.shared<std::int32_t>(exchange_at);
        const SweepScratch& scratch = batch.scratch;
        const CellPlace* places_u = scratch.places + scratch.cells(tile.line, tile.lookup, 0);
        const CellPlace* places_v = scratch.places + scratch.cells(tile.line, tile.lookup, 1);
        float* tau = scratch.tau_row(tile.view, tile.line, tile.lookup, 0);
        const int pitch = SweepScratch::tau_pitch(tile.view.u.cells);
        for (int cell = lookup.first_u + thread % warp_lanes; cell < lookup.last_u; cell += warp_lanes) {
            const CellPlace u = places_u[cell];
            const int ray = u.ray - tile.u;
            const std::int32_t *low = exchange + exchanged(0, ray), *next = exchange + exchanged(0, ray + 1);
            for (int row = lookup.first_v + thread / warp_lanes; row < lookup.last_v; row += warps) {
                const CellPlace v = places_v[row];
                const int at = (v.ray - tile.v) * (tile_u / 2), above = at + tile_u / 2;
                tau[row * pitch + cell] =
                    between_rays(low[at], next[at], low[above], next[above], u.fraction, v.fraction);
            }
        }
    }

    /// Of the tile's own rays: those that are not the next tile's, too.
    LUMISWEEP_HD void store_totals(const Block<threads>& block, const Tile& tile, int thread) const
    {
        const std::int32_t* exchange = block.shared<std::int32_t>(exchange_at);
        const auto own = [](int rays_left, int step) { return rays_left > step + 1 ? step : rays_left; };
        const int rays = own(tile.view.u.ray_count - tile.u, tile_step_u);
        const int rows = own(tile.view.v.ray_count - tile.v, tile_step_v);
        for (int row = thread / warp_lanes; row < rows; row += warps) {
            std::int32_t* totals = batch.scratch.totals_row(tile.view, tile.line, tile.v + row) + tile.u;
            for (int ray = thread % warp_lanes; ray < rays; ray += warp_lanes)
                totals[ray] = exchange[exchanged(row, ray)];
        }
    }
};

} // namespace

void march_rays(const SweepBatch& batch, const VoxelsView& voxels, const Stream& stream)
{
    launch("marching rays", stream, {batch.most_tiles_u, batch.most_tiles_v, batch.line_count}, march_shared_bytes,
           MarchRays{batch, voxels});
}

} // namespace lumisweep::LUMISWEEP_CUDA
