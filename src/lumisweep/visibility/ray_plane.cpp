#include "lumisweep/visibility/ray_plane.h"

#include <algorithm>

namespace lumisweep {

void CellPlaces::place(const SweepAxis& axis, int cell_count, double cell_side, std::span<const double> lookup_depths)
{
    cells = cell_count;
    depths.assign(lookup_depths.begin(), lookup_depths.end());
    const std::size_t count = depths.size() * static_cast<std::size_t>(cells);
    ray.resize(count);
    fraction.resize(count);
    step = CellRow::is_even(cell_side) ? static_cast<int>(cell_side) : 0;
    std::size_t at = 0;
    for (const double depth : depths) {
        const CellRow row(axis, cell_side, depth);
        for (int c = 0; c < cells; ++c, ++at) {
            const CellPlace place = row.place(c);
            ray[at] = place.ray;
            fraction[at] = place.fraction;
        }
    }
}

void RayPlane::start(const MarchedLevel& level, const Vec3d& w_world)
{
    geometry_ = std::make_unique<SweepGeometry>(level.size, level.level_from_world, w_world);
    const SweepGeometry& g = *geometry_;
    slabs_ = g.slabs(component(level.cells, g.axis), level.cell_side(g.axis));
    const std::vector<double>& depths = slabs_.depths;
    const int u = u_axis_of(g.axis), v = v_axis_of(g.axis);
    u_.place(g.u, component(level.cells, u), level.cell_side(u), depths);
    v_.place(g.v, component(level.cells, v), level.cell_side(v), depths);

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
