#include "lumisweep/visibility/ray_plane.h"

#include <algorithm>
#include <cmath>

namespace lumisweep {

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
        rays_ = AlignedArray<std::int32_t>(rays, Contents::uninitialised);
    started_.assign(static_cast<std::size_t>(g.v.ray_count), 0);
    const std::size_t cells = depths.size() * static_cast<std::size_t>(u_.cells) * static_cast<std::size_t>(v_.cells);
    if (tau_.size() < cells)
        tau_ = AlignedArray<float>(cells, Contents::uninitialised);
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
        const int count = row_step() != 0 ? 1 : u_.cells;
        for (int c = 0; c < count; ++c) {
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
    lookup.step = row_step();
    lookup.count = u_.cells;
    kernels.look_up(tau, lookup);
}

} // namespace lumisweep
