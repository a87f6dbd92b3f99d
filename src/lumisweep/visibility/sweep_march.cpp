#include "lumisweep/visibility/sweep_march.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/stopwatch.h"

namespace lumisweep {
namespace {

constexpr int strip_rows = 32; ///< voxel rows, about: with their pairs and rays they fit the second-level cache

struct Layout {
    const std::uint8_t* voxels;
    std::size_t slice_stride, row_stride;
};

Layout layout_of(const MarchedLevel& level, int axis)
{
    const std::size_t x = static_cast<std::size_t>(level.size.x), y = static_cast<std::size_t>(level.size.y);
    const std::size_t z = static_cast<std::size_t>(level.size.z);
    switch (axis) {
    case 0: return {level.transposed, y * z, y};
    case 1: return {level.voxels, x, x * y};
    default: return {level.voxels, x * y, x};
    }
}

} // namespace

void CellPlaces::place(const SweepAxis& axis, int cell_count, double cell_side, std::span<const double> lookup_depths)
{
    cells = cell_count;
    depths.assign(lookup_depths.begin(), lookup_depths.end());
    const std::size_t count = depths.size() * static_cast<std::size_t>(cells);
    ray.resize(count);
    fraction.resize(count);
    const bool even = cell_side == std::floor(cell_side) && cell_side <= 8.0;
    step = even ? static_cast<int>(cell_side) : 0;
    std::size_t at = 0;
    for (const double depth : depths) {
        const double begin = 0.5 * cell_side - 0.5 - axis.slope * depth - axis.first_ray;
        const double first = std::floor(begin);
        for (int c = 0; c < cells; ++c, ++at) {
            const double x = even ? first + c * cell_side : begin + c * cell_side;
            const double low = even ? x : std::floor(x);
            ray[at] = static_cast<std::int32_t>(low);
            fraction[at] = static_cast<float>(even ? begin - first : x - low);
        }
    }
}

void RayPlane::start(const MarchedLevel& level, const Vec3d& w_world)
{
    geometry_ = std::make_unique<SweepGeometry>(level.size, level.level_from_world, w_world);
    const SweepGeometry& g = *geometry_;
    const int slices = component(level.cells, g.axis);
    const double cell_w = component(level.cell_sides, g.axis);
    std::vector<double> depths;
    pieces_.clear();
    slab_begin_.assign(1, 0);
    double depth = 0.0;
    for (int k = 0; k <= slices; ++k) {
        const double next = k < slices ? (k + 0.5) * cell_w : g.slices;
        for (const SweepPiece& piece : g.pieces(depth, next))
            pieces_.push_back(piece);
        slab_begin_.push_back(static_cast<int>(pieces_.size()));
        if (k < slices)
            depths.push_back(next);
        depth = next;
    }
    const int u = u_axis_of(g.axis), v = v_axis_of(g.axis);
    u_.place(g.u, component(level.cells, u), component(level.cell_sides, u), depths);
    v_.place(g.v, component(level.cells, v), component(level.cell_sides, v), depths);

    // Even and odd rays of a row one after the other, each in whole blocks.
    half_row_ = (g.u.ray_count + ray_block - 1) / ray_block * (ray_block / 2);
    const std::size_t rays = 2 * static_cast<std::size_t>(half_row_) * static_cast<std::size_t>(g.v.ray_count);
    if (rays_.size() < rays)
        rays_ = AlignedArray<std::int32_t>(rays);
    started_.assign(static_cast<std::size_t>(g.v.ray_count), 0);
    const std::size_t cells = depths.size() * static_cast<std::size_t>(u_.cells) * static_cast<std::size_t>(v_.cells);
    if (tau_.size() < cells)
        tau_ = AlignedArray<float>(cells);
    index_.resize(static_cast<std::size_t>(u_.cells));
    next_.resize(static_cast<std::size_t>(u_.cells));
    indexed_slice_ = -1;
}

std::int32_t* RayPlane::row(int ray_row)
{
    std::int32_t* rays = rays_.data() + 2 * static_cast<std::ptrdiff_t>(half_row_) * ray_row;
    std::uint8_t& started = started_[static_cast<std::size_t>(ray_row)];
    if (started == 0) {
        std::fill(rays, rays + 2 * static_cast<std::ptrdiff_t>(half_row_), 0);
        started = 1;
    }
    return rays;
}

std::span<const SweepPiece> RayPlane::slab(int slab) const
{
    const int begin = slab_begin_[static_cast<std::size_t>(slab)];
    return std::span(pieces_).subspan(
        static_cast<std::size_t>(begin),
        static_cast<std::size_t>(slab_begin_[static_cast<std::size_t>(slab) + 1] - begin));
}

void RayPlane::look_up(const SweepKernels& kernels, int slice, int row_of_cells, float* tau)
{
    if (slice != indexed_slice_) {
        indexed_slice_ = slice;
        const std::int32_t* rays = u_.rays_of(slice);
        const auto stored = [&](std::int32_t ray) { return (ray >> 1) + (ray & 1) * half_row_; };
        for (int c = 0; c < u_.cells; ++c) {
            index_[static_cast<std::size_t>(c)] = stored(rays[c]);
            next_[static_cast<std::size_t>(c)] = stored(rays[c] + 1);
        }
    }
    const int ray_row = v_.rays_of(slice)[row_of_cells];
    LookupRow lookup{};
    lookup.low = row(ray_row);
    lookup.high = row(ray_row + 1);
    lookup.index = index_.data();
    lookup.next = next_.data();
    lookup.fraction = u_.fractions_of(slice);
    lookup.fraction_rows = v_.fractions_of(slice)[row_of_cells];
    lookup.step = u_.step % 2 == 0 ? u_.step / 2 : 0;
    lookup.count = u_.cells;
    kernels.look_up(tau, lookup);
}

GroupMarch::GroupMarch(const MarchedLevel& level, const SweepKernels& kernels, const std::atomic<bool>* cancel)
    : level_(level), kernels_(kernels), cancel_(cancel)
{
}

bool GroupMarch::run(std::span<RayPlane> planes, SweepStats& stats)
{
    const SweepGeometry& g = planes.front().geometry();
    const int v_axis = v_axis_of(g.axis);
    const int cells_v = component(level_.cells, v_axis), cells_w = component(level_.cells, g.axis);
    const double cell_v = component(level_.cell_sides, v_axis);
    // With less than two rays a cell the rows of neighbouring lookups overlap; then there is only one strip.
    const int cells_per_strip = cell_v >= 2.0 ? std::max(1, static_cast<int>(strip_rows / cell_v)) : cells_v;
    const int strips = (cells_v + cells_per_strip - 1) / cells_per_strip;
    spans_.resize(planes.size());
    for (int s = 0; s < strips; ++s) {
        const int which = g.v.slope > 0.0 ? s : strips - 1 - s;
        const Strip strip{which * cells_per_strip, std::min((which + 1) * cells_per_strip, cells_v), which == 0,
                          which == strips - 1};
        for (int slab = 0; slab <= cells_w; ++slab) {
            if (cancel_ != nullptr && cancel_->load(std::memory_order_relaxed))
                return false;
            {
                const ProcessorStopwatch watch(stats.layout_s);
                make_pairs(planes, strip, slab);
            }
            {
                const ProcessorStopwatch watch(stats.march_s);
                for (std::size_t d = 0; d < planes.size(); ++d)
                    march(planes[d], spans_[d], slab, stats);
            }
            if (slab == cells_w)
                continue;
            const ProcessorStopwatch watch(stats.lookup_s);
            for (RayPlane& plane : planes)
                for (int row = strip.first_cell; row < strip.last_cell; ++row)
                    plane.look_up(kernels_, slab, row, plane.tau_of(slab, row));
        }
    }
    return true;
}

/// The ray rows that belong to a strip during a slab: from the lower row of its first lookup to below that of the next
/// strip's first.
GroupMarch::Span GroupMarch::ray_rows(const RayPlane& plane, const Strip& strip, int slab) const
{
    const CellPlaces& places = plane.places_v();
    const SweepGeometry& g = plane.geometry();
    const int slices = static_cast<int>(places.depths.size());
    const auto boundary = [&](int cell) {
        if (slab < slices)
            return places.rays_of(slab)[cell];
        // Behind the last lookup any boundary between it and the end will do that moves with the shear.
        return places.rays_of(slices - 1)[cell];
    };
    return {strip.lowest ? 0 : boundary(strip.first_cell), strip.highest ? g.v.ray_count : boundary(strip.last_cell)};
}

void GroupMarch::make_pairs(std::span<RayPlane> planes, const Strip& strip, int slab)
{
    const SweepGeometry& g = planes.front().geometry();
    pair_rows_.clear();
    if (planes.front().slab(slab).empty())
        return;
    first_slice_ = planes.front().slab(slab).front().slice;
    const std::size_t slices = static_cast<std::size_t>(planes.front().slab(slab).back().slice - first_slice_) + 1;
    pair_rows_.assign(slices, {std::numeric_limits<int>::max(), std::numeric_limits<int>::min()});
    for (std::size_t d = 0; d < planes.size(); ++d) {
        const SweepAxis& v = planes[d].geometry().v;
        spans_[d] = ray_rows(planes[d], strip, slab);
        for (const SweepPiece& piece : planes[d].slab(slab)) {
            const std::size_t slice = static_cast<std::size_t>(piece.slice);
            const int first = std::max(spans_[d].first, v.first[slice]), last = std::min(spans_[d].last, v.last[slice]);
            if (first >= last)
                continue;
            Span& rows = pair_rows_[slice - static_cast<std::size_t>(first_slice_)];
            rows.first = std::min(rows.first, first + v.first_ray + piece.shift_v);
            rows.last = std::max(rows.last, last + v.first_ray + piece.shift_v);
        }
    }
    pair_stride_ = (2 * (static_cast<std::size_t>(g.u.size) + 2 * edge_voxels) + 2 * pair_row_margin + 63) / 64 * 64;
    pair_at_.clear();
    std::size_t rows = 0;
    for (const Span& span : pair_rows_) {
        pair_at_.push_back(rows);
        rows += static_cast<std::size_t>(std::max(0, span.last - span.first));
    }
    if (pairs_.size() < rows * pair_stride_)
        pairs_ = AlignedArray<std::uint8_t>(rows * pair_stride_ * 5 / 4);
    const Layout layout = layout_of(level_, g.axis);
    for (std::size_t s = 0; s < slices; ++s) {
        const std::uint8_t* slice = layout.voxels + (static_cast<std::size_t>(first_slice_) + s) * layout.slice_stride;
        const auto voxels = [&](int v) {
            return slice + static_cast<std::size_t>(std::clamp(v, 0, g.v.size - 1)) * layout.row_stride;
        };
        std::uint8_t* pairs = pairs_.data() + pair_at_[s] * pair_stride_ + pair_row_margin + 2 * edge_voxels;
        for (int v = pair_rows_[s].first; v < pair_rows_[s].last; ++v, pairs += pair_stride_)
            kernels_.make_pairs(pairs, voxels(v), voxels(v + 1), g.u.size);
    }
}

void GroupMarch::march(RayPlane& plane, Span rows, int slab, SweepStats& stats)
{
    const SweepGeometry& g = plane.geometry();
    const std::span<const SweepPiece> pieces = plane.slab(slab);
    if (pieces.empty())
        return;
    std::vector<MarchRow>& at = march_rows_;
    std::vector<Span>& counted = counted_;
    at.resize(pieces.size());
    counted.resize(pieces.size());
    int first = rows.last, last = rows.first;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        const std::size_t slice = static_cast<std::size_t>(pieces[p].slice);
        counted[p] = {std::max(rows.first, g.v.first[slice]), std::min(rows.last, g.v.last[slice])};
        first = std::min(first, counted[p].first);
        last = std::max(last, counted[p].last);
        stats.voxel_steps += static_cast<std::uint64_t>(std::max(0, counted[p].last - counted[p].first)) *
                             static_cast<std::uint64_t>(std::max(0, g.u.last[slice] - g.u.first[slice]));
    }
    for (int ray_row = first; ray_row < last; ++ray_row) {
        int count = 0;
        for (std::size_t p = 0; p < pieces.size(); ++p) {
            if (ray_row < counted[p].first || ray_row >= counted[p].last)
                continue;
            const SweepPiece& piece = pieces[p];
            const std::size_t slice = static_cast<std::size_t>(piece.slice);
            const std::size_t s = slice - static_cast<std::size_t>(first_slice_);
            const int v = ray_row + g.v.first_ray + piece.shift_v;
            MarchRow& row = at[static_cast<std::size_t>(count)];
            row.first = g.u.first[slice];
            row.last = g.u.last[slice];
            if (row.first >= row.last)
                continue;
            const std::size_t pair_row = pair_at_[s] + static_cast<std::size_t>(v - pair_rows_[s].first);
            row.pairs = pairs_.data() + (static_cast<std::ptrdiff_t>(pair_row * pair_stride_) + pair_row_margin +
                                         2 * (edge_voxels + g.u.first_ray + piece.shift_u));
            for (int k = 0; k < 4; ++k)
                row.weight[k] = piece.weight[k];
            ++count;
        }
        std::int32_t* rays = plane.row(ray_row);
        kernels_.march(rays, rays + plane.half_row(), at.data(), count);
    }
}

} // namespace lumisweep
