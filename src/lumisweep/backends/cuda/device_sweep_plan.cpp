#include "lumisweep/backends/cuda/device_sweep_plan.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_plan.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

struct PlannedLine {
    LineView view{};
    std::vector<MarchPiece> pieces;
    std::vector<std::int32_t> slab_begin, begin, end; ///< begin and end: of u, then of v
    std::uint64_t voxel_steps = 0;
};

MarchPiece march_piece(const SweepGeometry& g, const SweepPiece& piece)
{
    const std::size_t slice = static_cast<std::size_t>(piece.slice);
    const auto byte = [&](int i, int to) { return static_cast<std::uint32_t>(piece.weight[i]) << (8 * to); };
    MarchPiece m{};
    m.slice = piece.slice;
    m.voxel_u = g.u.first_ray + piece.shift_u;
    m.voxel_v = g.v.first_ray + piece.shift_v;
    m.weights = byte(0, 0) | byte(2, 1) | byte(1, 2) | byte(3, 3);
    m.first_u = g.u.first[slice];
    m.last_u = g.u.last[slice];
    m.first_v = g.v.first[slice];
    m.last_v = g.v.last[slice];
    return m;
}

LineAxis line_axis(const SweepLevel& level, const SweepAxis& axis, int which)
{
    return {{axis.size, axis.slope, axis.first_ray}, axis.ray_count,         0,
            component(level.cells, which),           level.cell_side(which), level.cell_side_world(which)};
}

PlannedLine plan_line(const SweepLevel& level, const SweepPair& pair)
{
    const SweepGeometry g(level.size, level.level_from_world, pair.w_world);
    const SweepSlabs slabs = g.slabs(component(level.cells, g.axis), level.cell_side(g.axis));
    PlannedLine line;
    for (const SweepPiece& piece : slabs.pieces) {
        const MarchPiece& m = line.pieces.emplace_back(march_piece(g, piece));
        line.voxel_steps += static_cast<std::uint64_t>(std::max(0, m.last_u - m.first_u)) *
                            static_cast<std::uint64_t>(std::max(0, m.last_v - m.first_v));
    }
    line.slab_begin = slabs.begin;
    for (const SweepAxis* axis : {&g.u, &g.v}) {
        line.begin.insert(line.begin.end(), axis->begin.begin(), axis->begin.end());
        line.end.insert(line.end.end(), axis->end.begin(), axis->end.end());
    }
    LineView& view = line.view;
    view.axis = g.axis;
    view.slices = g.slices;
    view.cells = component(level.cells, g.axis);
    view.cell_side = level.cell_side(g.axis);
    view.slice_world = g.slice_world;
    view.u = line_axis(level, g.u, u_axis_of(g.axis));
    view.v = line_axis(level, g.v, v_axis_of(g.axis));
    view.direction[0] = pair.towards_low;
    view.direction[1] = pair.towards_high;
    return line;
}

/// Those of a texel one after the other.
std::vector<PlannedLine> plan_lines(const SweepLevel& level, const VisibilitySettings& settings)
{
    std::vector<int> all(static_cast<std::size_t>(settings.directions) * static_cast<std::size_t>(settings.directions));
    std::iota(all.begin(), all.end(), 0);
    std::vector<SweepPair> pairs;
    std::vector<int> slot_0; // [line] its texel's first direction
    const std::size_t whole_group = all.size() * static_cast<std::size_t>(settings.oversampling);
    for (const SweepTask& task : plan_sweeps(level.level_from_world, settings, all, whole_group))
        for (const SweepGroup& group : task.groups)
            for (const SweepPair& pair : group) {
                pairs.push_back(pair);
                slot_0.push_back(task.directions().front());
            }
    std::vector<PlannedLine> lines(pairs.size());
    parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) {
        lines[i] = plan_line(level, pairs[i]);
        LineView& view = lines[i].view;
        for (int side = 0; side < 2; ++side)
            view.slot[side] = view.direction[side] < 0 ? -1 : view.direction[side] == slot_0[i] ? 0 : 1;
    });
    return lines;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

} // namespace

DeviceSweepPlan::DeviceSweepPlan(const SweepLevel& level, const VisibilitySettings& settings, const Stream& stream)
{
    std::vector<LineView> views;
    std::vector<MarchPiece> pieces;
    std::vector<std::int32_t> slab_begin, begin, end;
    for (PlannedLine& line : plan_lines(level, settings)) {
        LineView& view = line.view;
        view.first_piece = static_cast<std::int32_t>(pieces.size());
        view.piece_count = static_cast<std::int32_t>(line.pieces.size());
        view.first_slab = static_cast<std::int32_t>(slab_begin.size());
        view.u.ranges = static_cast<std::int32_t>(begin.size());
        view.v.ranges = view.u.ranges + view.u.ray_count;
        append(pieces, line.pieces);
        append(slab_begin, line.slab_begin);
        append(begin, line.begin);
        append(end, line.end);
        views.push_back(view);
        most_tiles_u_ = std::max(most_tiles_u_, tiles_of(view.u.ray_count, tile_step_u));
        most_tiles_v_ = std::max(most_tiles_v_, tiles_of(view.v.ray_count, tile_step_v));
        most_rays_ = std::max(most_rays_,
                              static_cast<std::size_t>(view.u.ray_count) * static_cast<std::size_t>(view.v.ray_count));
        along_x_ = along_x_ || view.axis == 0;
        voxel_steps_ += line.voxel_steps;
    }
    constexpr const char* what = "the plan of the sweeps";
    lines_.upload(views, what, stream);
    pieces_.upload(pieces, what, stream);
    slab_begin_.upload(slab_begin, what, stream);
    begin_.upload(begin, what, stream);
    end_.upload(end, what, stream);
    stream.wait(); // what was copied from goes
}

} // namespace lumisweep::LUMISWEEP_CUDA
