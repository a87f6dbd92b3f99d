#include "lumisweep/visibility/sweep_geometry.h"

#include <algorithm>
#include <cmath>

namespace lumisweep {
namespace {

constexpr double tolerance = 1e-9;

int dominant_axis(const Vec3d& w_level)
{
    const double x = std::fabs(w_level.x), y = std::fabs(w_level.y), z = std::fabs(w_level.z);
    const double tie = 1.0 - tolerance;
    if (y >= x * tie && y >= z * tie)
        return 1;
    return z >= x * tie ? 2 : 0;
}

} // namespace

SweepAxis::SweepAxis(int voxels, double slope_per_slice, int slices) : RayAxis{voxels, slope_per_slice, 0}
{
    // Lookups are at −1/2 ≤ u − 1/2 − slope · depth ≤ size − 1/2 and use the ray below and above, with a little to
    // spare.
    first_ray = static_cast<int>(std::floor(-0.5 - std::max(slope * slices, 0.0))) - 1;
    first_ray -= first_ray & 1;
    const int end_ray = static_cast<int>(std::ceil(size - 0.5 - std::min(slope * slices, 0.0))) + 2;
    ray_count = end_ray - first_ray;
    begin.resize(static_cast<std::size_t>(ray_count));
    end.resize(static_cast<std::size_t>(ray_count));
    const int none = ray_count;
    first.assign(static_cast<std::size_t>(slices), none);
    last.assign(static_cast<std::size_t>(slices), 0);
    const auto whole = [&](double depth) { return static_cast<int>(std::clamp(depth, 0.0, 1.0 * slices)); };
    for (int i = 0; i < ray_count; ++i) {
        const SidePass p = pass(first_ray + i);
        const int b = whole(std::floor(p.enter + tolerance)), e = whole(std::ceil(p.leave - tolerance));
        begin[static_cast<std::size_t>(i)] = b;
        end[static_cast<std::size_t>(i)] = std::max(b, e);
        if (b >= e)
            continue;
        // Rays pass a side one after the other, so those of a slice are neighbours.
        int& low = first[static_cast<std::size_t>(slope > 0.0 ? b : e - 1)];
        int& high = last[static_cast<std::size_t>(slope > 0.0 ? e - 1 : b)];
        low = std::min(low, i);
        high = std::max(high, i + 1);
    }
    const auto forwards = [&](std::vector<int>& list, auto&& better) {
        for (std::size_t j = 1; j < list.size(); ++j)
            list[j] = better(list[j], list[j - 1]);
    };
    const auto backwards = [&](std::vector<int>& list, auto&& better) {
        for (std::size_t j = list.size() - 1; j > 0; --j)
            list[j - 1] = better(list[j - 1], list[j]);
    };
    const auto lesser = [](int a, int b) { return std::min(a, b); };
    const auto greater = [](int a, int b) { return std::max(a, b); };
    if (slope > 0.0) {
        forwards(first, lesser);
        backwards(last, greater);
    } else {
        backwards(first, lesser);
        forwards(last, greater);
    }
}

SweepLine::SweepLine(const Affine3d& level_from_world, const Vec3d& w_world)
{
    const Vec3d w_level = level_from_world.vector(w_world);
    axis = dominant_axis(w_level);
    const double along = component(w_level, axis);
    towards_high_side = along > 0.0;
    slice_world = 1.0 / std::fabs(along);
    slope_u = component(w_level, u_axis_of(axis)) / along;
    slope_v = component(w_level, v_axis_of(axis)) / along;
}

SweepGeometry::SweepGeometry(Vec3i level_size, const Affine3d& level_from_world, const Vec3d& w_world)
    : SweepLine(level_from_world, w_world), slices(component(level_size, axis)),
      u(component(level_size, u_axis_of(axis)), slope_u, slices),
      v(component(level_size, v_axis_of(axis)), slope_v, slices)
{
}

std::span<const SweepPiece> SweepSlabs::slab(int index) const
{
    const auto i = static_cast<std::size_t>(index);
    return std::span(pieces).subspan(static_cast<std::size_t>(begin[i]),
                                     static_cast<std::size_t>(begin[i + 1] - begin[i]));
}

std::vector<SweepPiece> SweepGeometry::pieces(double begin_depth, double end_depth) const
{
    std::vector<SweepPiece> list;
    end_depth = std::min(end_depth, static_cast<double>(slices));
    const int first_slice = static_cast<int>(std::floor(begin_depth + tolerance));
    for (int slice = first_slice; slice < slices && slice < end_depth - tolerance; ++slice) {
        const double from = std::max(begin_depth, static_cast<double>(slice));
        const double to = std::min(end_depth, slice + 1.0);
        const int weight = weight_at(to) - weight_at(from);
        if (weight == 0)
            continue;
        const double middle = 0.5 * (from + to);
        const double at_u = u.slope * middle, at_v = v.slope * middle;
        SweepPiece piece;
        piece.slice = slice;
        piece.shift_u = static_cast<int>(std::floor(at_u));
        piece.shift_v = static_cast<int>(std::floor(at_v));
        const double fraction_u = at_u - piece.shift_u, fraction_v = at_v - piece.shift_v;
        const int high_row = static_cast<int>(std::lround(weight * fraction_v)), low_row = weight - high_row;
        const int low_next = static_cast<int>(std::lround(low_row * fraction_u));
        const int high_next = static_cast<int>(std::lround(high_row * fraction_u));
        piece.weight[0] = static_cast<std::int8_t>(low_row - low_next);
        piece.weight[1] = static_cast<std::int8_t>(high_row - high_next);
        piece.weight[2] = static_cast<std::int8_t>(low_next);
        piece.weight[3] = static_cast<std::int8_t>(high_next);
        list.push_back(piece);
    }
    return list;
}

SweepSlabs SweepGeometry::slabs(int cells, double cell_side) const
{
    SweepSlabs all;
    all.begin.push_back(0);
    double depth = 0.0;
    for (int k = 0; k <= cells; ++k) {
        const double next = k < cells ? lookup_depth(k, cell_side) : slices;
        for (const SweepPiece& piece : pieces(depth, next))
            all.pieces.push_back(piece);
        all.begin.push_back(static_cast<int>(all.pieces.size()));
        if (k < cells)
            all.depths.push_back(next);
        depth = next;
    }
    return all;
}

} // namespace lumisweep
