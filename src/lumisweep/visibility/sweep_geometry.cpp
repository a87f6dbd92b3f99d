#include "lumisweep/visibility/sweep_geometry.h"

#include <algorithm>
#include <cmath>

namespace lumisweep {
namespace {

int dominant_axis(const Vec3d& w_level)
{
    const double x = std::fabs(w_level.x), y = std::fabs(w_level.y), z = std::fabs(w_level.z);
    const double tie = 1.0 - 1e-9;
    if (y >= x * tie && y >= z * tie)
        return 1;
    return z >= x * tie ? 2 : 0;
}

SweepAxis make_axis(int size, double slope, int slices)
{
    SweepAxis axis;
    axis.size = size;
    axis.slope = slope;
    // Lookups are at −1/2 ≤ u − 1/2 − slope · depth ≤ size − 1/2 and use the ray below and above, with a little to
    // spare.
    axis.first_ray = static_cast<int>(std::floor(-0.5 - std::max(slope * slices, 0.0))) - 1;
    const int end = static_cast<int>(std::ceil(size - 0.5 - std::min(slope * slices, 0.0))) + 2;
    axis.ray_count = end - axis.first_ray;
    axis.passes.reserve(static_cast<std::size_t>(axis.ray_count));
    for (int i = axis.first_ray; i < end; ++i)
        axis.passes.push_back(axis.pass(i));
    return axis;
}

SweepStep::Window make_window(const SweepAxis& axis, double begin, double end)
{
    constexpr double tolerance = 1e-9;
    SweepStep::Window w;
    const double offset = axis.slope * 0.5 * (begin + end);
    w.shift = static_cast<int>(std::floor(offset));
    w.fraction = offset - w.shift;
    w.first = w.last = w.touched_first = w.touched_last = axis.first_ray;
    for (int i = 0; i < axis.ray_count; ++i) {
        const SidePass& pass = axis.passes[static_cast<std::size_t>(i)];
        if (!(pass.enter < end - tolerance && pass.leave > begin + tolerance))
            continue;
        const int ray = axis.first_ray + i;
        if (w.touched_first == w.touched_last)
            w.touched_first = ray;
        w.touched_last = ray + 1;
        if (pass.enter > begin + tolerance || pass.leave < end - tolerance)
            continue;
        if (w.first == w.last)
            w.first = ray;
        w.last = ray + 1;
    }
    if (w.first == w.last)
        w.first = w.last = w.touched_last;
    return w;
}

} // namespace

SidePass SweepAxis::pass(double x) const
{
    constexpr double never = 1e9;
    const double low = -0.5 - x, high = size - 0.5 - x; // of slope · depth
    if (std::fabs(slope) < 1e-12)
        return low <= 0.0 && high >= 0.0 ? SidePass{-never, never} : SidePass{never, -never};
    const double a = std::clamp(low / slope, -never, never), b = std::clamp(high / slope, -never, never);
    return {std::min(a, b), std::max(a, b)};
}

SweepGeometry::SweepGeometry(Vec3i level_size, const Affine3d& level_from_world, const Vec3d& w_world)
{
    const Vec3d w_level = level_from_world.vector(w_world);
    axis = dominant_axis(w_level);
    const double along = component(w_level, axis);
    from_high_side = along > 0.0;
    slices = component(level_size, axis);
    slice_world = 1.0 / std::fabs(along);
    const int u_axis = axis == 0 ? 1 : 0, v_axis = axis == 2 ? 1 : 2;
    u = make_axis(component(level_size, u_axis), -component(w_level, u_axis) * slice_world, slices);
    v = make_axis(component(level_size, v_axis), -component(w_level, v_axis) * slice_world, slices);
}

SweepStep::SweepStep(const SweepGeometry& geometry, int slice_depth, double begin_depth, double end_depth)
    : slice(geometry.slice_at(slice_depth)), begin(begin_depth), end(end_depth),
      u(make_window(geometry.u, begin_depth, end_depth)), v(make_window(geometry.v, begin_depth, end_depth))
{
}

std::vector<SweepStep> sweep_steps(const SweepGeometry& geometry, double begin_depth, double end_depth)
{
    constexpr double tolerance = 1e-9;
    std::vector<SweepStep> steps;
    double depth = begin_depth;
    end_depth = std::min(end_depth, static_cast<double>(geometry.slices));
    while (depth < end_depth - tolerance) {
        const int slice = std::min(static_cast<int>(std::floor(depth + tolerance)), geometry.slices - 1);
        const double next = slice + 1.0 < end_depth - tolerance ? slice + 1.0 : end_depth;
        steps.emplace_back(geometry, slice, depth, next);
        depth = next;
    }
    return steps;
}

} // namespace lumisweep
