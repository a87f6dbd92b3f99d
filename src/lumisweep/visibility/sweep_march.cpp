#include "lumisweep/visibility/sweep_march.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/stopwatch.h"

namespace lumisweep {
namespace {

constexpr int strip_rows = 32; ///< voxel rows, about: with their pairs and rays they fit the second-level cache

struct Layout {
    const std::uint8_t* voxels;
    const ExtinctionGrid::Filled* filled;
    std::size_t row_length, slice_stride, row_stride; ///< strides in rows

    std::size_t row(int slice, int v) const
    {
        return static_cast<std::size_t>(slice) * slice_stride + static_cast<std::size_t>(v) * row_stride;
    }
};

Layout layout_of(const MarchedLevel& level, int axis)
{
    const std::size_t x = static_cast<std::size_t>(level.size.x), y = static_cast<std::size_t>(level.size.y);
    const std::size_t z = static_cast<std::size_t>(level.size.z);
    switch (axis) {
    case 0: return {level.transposed, level.filled_transposed, y, z, 1};
    case 1: return {level.voxels, level.filled, x, 1, y};
    default: return {level.voxels, level.filled, x, y, 1};
    }
}

} // namespace

GroupMarch::GroupMarch(const MarchedLevel& level, const SweepKernels& kernels, const std::atomic<bool>* cancel)
    : level_(level), kernels_(kernels), cancel_(cancel)
{
}

bool GroupMarch::run(std::span<RayPlane> planes, SweepStats& stats)
{
    const bool ended = march_strips(planes, stats);
    kernels_.finish_stores();
    return ended;
}

bool GroupMarch::march_strips(std::span<RayPlane> planes, SweepStats& stats)
{
    const SweepGeometry& g = planes.front().geometry();
    const int v_axis = v_axis_of(g.axis);
    const int cells_v = component(level_.cells, v_axis), cells_w = component(level_.cells, g.axis);
    const double cell_v = component(level_.cell_sides, v_axis);
    // With less than two rays a cell the rows of neighbouring lookups overlap; then there is only one strip.
    const int cells_per_strip = cell_v >= 2.0 ? std::max(1, static_cast<int>(strip_rows / cell_v)) : cells_v;
    const int strips = (cells_v + cells_per_strip - 1) / cells_per_strip;
    parts_.resize(planes.size());
    tau_.resize(static_cast<std::size_t>(planes.front().places_u().cells));
    for (int s = 0; s < strips; ++s) {
        const int which = g.v.slope > 0.0 ? s : strips - 1 - s;
        const Strip strip{which * cells_per_strip, std::min((which + 1) * cells_per_strip, cells_v), which == 0,
                          which == strips - 1};
        for (int slab = 0; slab <= cells_w; ++slab) {
            const std::size_t pieces = planes.front().slab(slab).size(); // the same of all
            for (std::size_t first = 0; first < pieces; first += march_slices) {
                if (is_cancelled(cancel_))
                    return false;
                {
                    const ProcessorStopwatch watch(stats.layout_s);
                    for (std::size_t d = 0; d < planes.size(); ++d)
                        place(planes[d], strip, slab, first, parts_[d]);
                    make_pairs(planes, stats);
                }
                const ProcessorStopwatch watch(stats.march_s);
                march(planes, stats);
            }
            if (slab == cells_w)
                continue;
            const ProcessorStopwatch watch(stats.lookup_s);
            for (RayPlane& plane : planes) {
                if (is_cancelled(cancel_)) // the first stores to a plane's fresh memory take milliseconds
                    return false;
                for (int row = strip.first_cell; row < strip.last_cell; ++row) {
                    plane.look_up(kernels_, slab, row, tau_.data());
                    kernels_.stream(plane.tau_of(slab, row), tau_.data(), plane.places_u().cells);
                }
            }
        }
    }
    return true;
}

/// The ray rows that belong to a strip during a slab: from the lower row of its first lookup to below that of the next
/// strip's first. Behind the last lookup they stay with their strip.
GroupMarch::Span GroupMarch::ray_rows(const RayPlane& plane, const Strip& strip, int slab) const
{
    const CellPlaces& places = plane.places_v();
    const std::int32_t* boundary = places.rays_of(std::min(slab, static_cast<int>(places.depths.size()) - 1));
    return {strip.lowest ? 0 : boundary[strip.first_cell],
            strip.highest ? plane.geometry().v.ray_count : boundary[strip.last_cell]};
}

void GroupMarch::place(const RayPlane& plane, const Strip& strip, int slab, std::size_t first_piece, Part& part) const
{
    const SweepGeometry& g = plane.geometry();
    const std::span<const SweepPiece> pieces = plane.slab(slab);
    part.pieces = pieces.subspan(first_piece, std::min<std::size_t>(march_slices, pieces.size() - first_piece));
    part.voxel_row = g.v.first_ray + part.pieces.back().shift_v;
    const Span rows = ray_rows(plane, strip, slab);
    part.rows = {rows.last, rows.first};
    part.counted.clear();
    for (const SweepPiece& piece : part.pieces) {
        const std::size_t slice = static_cast<std::size_t>(piece.slice);
        const Span counted{std::max(rows.first, g.v.first[slice]), std::min(rows.last, g.v.last[slice])};
        part.counted.push_back(counted);
        if (counted.first < counted.last)
            part.rows = {std::min(part.rows.first, counted.first), std::max(part.rows.last, counted.last)};
    }
    place_blocks(g.u, part);
}

void GroupMarch::place_blocks(const SweepAxis& u, Part& part)
{
    int first = u.ray_count, last = 0, inner_first = 0, inner_last = u.ray_count;
    for (const SweepPiece& piece : part.pieces) {
        const std::size_t slice = static_cast<std::size_t>(piece.slice);
        first = std::min(first, u.first[slice]);
        last = std::max(last, u.last[slice]);
        inner_first = std::max(inner_first, u.first[slice]);
        inner_last = std::min(inner_last, u.last[slice]);
    }
    const int end = (last + ray_block - 1) / ray_block;
    int inner_begin = (inner_first + ray_block - 1) / ray_block, inner_end = inner_last / ray_block;
    if (inner_begin >= inner_end)
        inner_begin = inner_end = end;
    part.edge.clear();
    for (int block = first / ray_block; block < end; ++block)
        if (block < inner_begin || block >= inner_end)
            part.edge.push_back(block);
    part.edge_rays.clear();
    for (const SweepPiece& piece : part.pieces) {
        const std::size_t slice = static_cast<std::size_t>(piece.slice);
        for (const int block : part.edge) {
            const auto in_block = [&](int ray) { return std::clamp(ray - block * ray_block, 0, ray_block); };
            const int from = in_block(u.first[slice]), to = std::max(from, in_block(u.last[slice]));
            const auto bits = [](int begin, int before) { return (1U << before) - (1U << begin); };
            part.edge_rays.push_back(bits((from + 1) / 2, (to + 1) / 2) | bits(from / 2, to / 2) << 16);
        }
    }
    part.blocks = {inner_begin, inner_end, part.edge.data(), static_cast<int>(part.edge.size())};
}

/// Of all slices and rows that the parts look at.
void GroupMarch::make_pairs(std::span<RayPlane> planes, SweepStats& stats)
{
    const SweepGeometry& g = planes.front().geometry();
    first_slice_ = parts_.front().pieces.front().slice;
    const std::size_t slices = static_cast<std::size_t>(parts_.front().pieces.back().slice - first_slice_) + 1;
    pair_rows_.assign(slices, {0, 0});
    for (std::size_t d = 0; d < planes.size(); ++d)
        for (std::size_t p = 0; p < parts_[d].pieces.size(); ++p) {
            const Span& counted = parts_[d].counted[p];
            if (counted.first >= counted.last)
                continue;
            const SweepPiece& piece = parts_[d].pieces[p];
            const int shift = planes[d].geometry().v.first_ray + piece.shift_v;
            Span& rows = pair_rows_[static_cast<std::size_t>(piece.slice - first_slice_)];
            rows = rows.first == rows.last
                       ? Span{counted.first + shift, counted.last + shift}
                       : Span{std::min(rows.first, counted.first + shift), std::max(rows.last, counted.last + shift)};
        }
    pair_stride_ = (2 * (static_cast<std::size_t>(g.u.size) + 2 * edge_voxels) + 2 * pair_row_margin + 63) / 64 * 64;
    pair_at_.clear();
    std::size_t rows = 0;
    for (const Span& span : pair_rows_) {
        pair_at_.push_back(rows);
        rows += static_cast<std::size_t>(span.last - span.first);
    }
    pair_extent_.resize(rows);
    if (pairs_.size() < rows * pair_stride_)
        pairs_ = AlignedArray<std::uint8_t>(rows * pair_stride_ * 5 / 4, Contents::uninitialised);
    const Layout layout = layout_of(level_, g.axis);
    for (std::size_t s = 0; s < slices; ++s) {
        if (pair_rows_[s].first >= pair_rows_[s].last)
            continue;
        const int slice = first_slice_ + static_cast<int>(s), slice_to_come = slice + static_cast<int>(slices);
        Span* extent = pair_extent_.data() + pair_at_[s];
        std::uint8_t* pairs = pairs_.data() + pair_at_[s] * pair_stride_ + pair_row_margin + 2 * edge_voxels;
        for (int v = pair_rows_[s].first; v < pair_rows_[s].last; ++v, pairs += pair_stride_, ++extent) {
            const int v_low = std::clamp(v, 0, g.v.size - 1), v_high = std::clamp(v + 1, 0, g.v.size - 1);
            const std::size_t low = layout.row(slice, v_low), high = layout.row(slice, v_high);
            // Voxels come from far: those of the slab to come are asked for before this one is marched.
            if (slice_to_come < g.slices) {
                const std::size_t to_come = layout.row(slice_to_come, v_high);
                const ExtinctionGrid::Filled& filled = layout.filled[to_come];
                for (int i = filled.first; i < filled.last; i += 64)
                    __builtin_prefetch(layout.voxels + to_come * layout.row_length + i, 0, 2);
            }
            const ExtinctionGrid::Filled &a = layout.filled[low], &b = layout.filled[high];
            const bool a_filled = a.first < a.last, b_filled = b.first < b.last;
            *extent = !a_filled   ? Span{b.first, b.last}
                      : !b_filled ? Span{a.first, a.last}
                                  : Span{std::min(a.first, b.first), std::max(a.last, b.last)};
            if (!a_filled && !b_filled)
                continue;
            stats.bytes_read += layout.row_length;
            kernels_.make_pairs(pairs, layout.voxels + low * layout.row_length,
                                layout.voxels + high * layout.row_length, g.u.size);
        }
    }
}

/// Voxel row by voxel row, with the planes inside: their ray rows there look at much the same pairs, which so stay in
/// the first-level cache.
void GroupMarch::march(std::span<RayPlane> planes, SweepStats& stats)
{
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
    for (std::size_t d = 0; d < planes.size(); ++d) {
        const Part& part = parts_[d];
        if (part.rows.first >= part.rows.last)
            continue;
        first = std::min(first, part.rows.first + part.voxel_row);
        last = std::max(last, part.rows.last + part.voxel_row);
        const SweepAxis& u = planes[d].geometry().u;
        for (std::size_t p = 0; p < part.pieces.size(); ++p) {
            const std::size_t slice = static_cast<std::size_t>(part.pieces[p].slice);
            stats.voxel_steps += static_cast<std::uint64_t>(std::max(0, part.counted[p].last - part.counted[p].first)) *
                                 static_cast<std::uint64_t>(std::max(0, u.last[slice] - u.first[slice]));
        }
    }
    for (int voxel_row = first; voxel_row < last; ++voxel_row)
        for (std::size_t d = 0; d < planes.size(); ++d) {
            const int ray_row = voxel_row - parts_[d].voxel_row;
            if (ray_row >= parts_[d].rows.first && ray_row < parts_[d].rows.last)
                march_row(planes[d], parts_[d], ray_row);
        }
}

void GroupMarch::march_row(RayPlane& plane, const Part& part, int ray_row)
{
    const SweepGeometry& g = plane.geometry();
    std::array<MarchRow, march_slices> rows;
    std::size_t count = 0;
    int first_ray = std::numeric_limits<int>::max(), last_ray = 0; // between them voxels are not empty
    for (std::size_t p = 0; p < part.pieces.size(); ++p) {
        if (ray_row < part.counted[p].first || ray_row >= part.counted[p].last)
            continue;
        const SweepPiece& piece = part.pieces[p];
        const std::size_t s = static_cast<std::size_t>(piece.slice - first_slice_);
        const int v = ray_row + g.v.first_ray + piece.shift_v;
        const std::size_t pair_row = pair_at_[s] + static_cast<std::size_t>(v - pair_rows_[s].first);
        const Span& extent = pair_extent_[pair_row];
        if (extent.first >= extent.last)
            continue;
        const int voxel_of_ray_0 = g.u.first_ray + piece.shift_u;
        // Up to the sides the edge voxels are repeated.
        const int from = extent.first == 0 ? -edge_voxels : extent.first;
        const int to = extent.last >= g.u.size ? g.u.size + edge_voxels : extent.last;
        first_ray = std::min(first_ray, std::max(from - 1 - voxel_of_ray_0, 0));
        last_ray = std::max(last_ray, to - voxel_of_ray_0);
        MarchRow& row = rows[count++];
        row.pairs = pairs_.data() + (static_cast<std::ptrdiff_t>(pair_row * pair_stride_) + pair_row_margin +
                                     2 * (edge_voxels + voxel_of_ray_0));
        std::copy(std::begin(piece.weight), std::end(piece.weight), std::begin(row.weight));
        row.counted = part.edge_rays.data() + p * part.edge.size();
    }
    if (count == 0)
        return;
    MarchBlocks blocks = part.blocks;
    const int first_block = first_ray / ray_block, last_block = (last_ray + ray_block - 1) / ray_block;
    blocks.first = std::max(blocks.first, first_block);
    blocks.last = std::min(blocks.last, last_block);
    int skipped = 0;
    while (skipped < blocks.edge_count && blocks.edge[skipped] < first_block)
        ++skipped;
    while (blocks.edge_count > skipped && blocks.edge[blocks.edge_count - 1] >= last_block)
        --blocks.edge_count;
    blocks.edge += skipped;
    blocks.edge_count -= skipped;
    for (std::size_t r = 0; r < count; ++r)
        rows[r].counted += skipped;
    std::int32_t* rays = plane.row(ray_row);
    kernels_.march(rays, rays + plane.half_row(), rows.data(), static_cast<int>(count), blocks);
}

} // namespace lumisweep
