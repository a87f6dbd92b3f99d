#include "lumisweep/visibility/sweep_pair.h"

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/visibility/sweep_box.h"
#include "lumisweep/visibility/sweep_optics.h"
#include "lumisweep/visibility/transpose_block.h"

namespace lumisweep {

void PairVisibility::Sides::place(const SweepAxis& axis, const CellPlaces& places, double cell_side, int slice)
{
    const std::size_t count = static_cast<std::size_t>(places.cells);
    for (std::vector<float>* list : {&begin_low, &begin_high, &end_low, &end_high, &enter, &leave})
        list->resize(count);
    const std::int32_t* rays = places.rays_of(slice);
    const CellRow cells(axis, cell_side, places.depths[static_cast<std::size_t>(slice)]);
    for (std::size_t c = 0; c < count; ++c) {
        const CellSides sides = sides_of(axis, axis.begin.data(), axis.end.data(), cells, static_cast<int>(c), rays[c]);
        begin_low[c] = sides.begin_low;
        begin_high[c] = sides.begin_high;
        end_low[c] = sides.end_low;
        end_high[c] = sides.end_high;
        enter[c] = sides.enter;
        leave[c] = sides.leave;
    }
}

CellSides PairVisibility::Sides::of(std::size_t cell) const
{
    return {begin_low[cell], begin_high[cell], end_low[cell], end_high[cell], enter[cell], leave[cell]};
}

PairVisibility::PairVisibility(const MarchedLevel& level, const SweepKernels& kernels, double tan_beta,
                               const std::atomic<bool>* cancel)
    : level_(level), kernels_(kernels), tan_beta_(tan_beta), cancel_(cancel)
{
}

bool PairVisibility::write(RayPlane& plane, std::uint8_t* towards_low, std::uint8_t* towards_high, SweepStats& stats)
{
    const SweepGeometry& g = plane.geometry();
    const int u_axis = u_axis_of(g.axis), v_axis = v_axis_of(g.axis);
    const int cells_u = component(level_.cells, u_axis), cells_v = component(level_.cells, v_axis);
    if (cells_u != cells_u_ || cells_v != cells_v_ || !filter_) {
        cells_u_ = cells_u;
        cells_v_ = cells_v;
        filter_ = std::make_unique<SliceFilter>(kernels_, cells_u, cells_v);
        for (AlignedArray<float>* row : {&total_, &forwards_, &backwards_, &row_forwards_, &row_backwards_})
            *row = AlignedArray<float>(static_cast<std::size_t>(cells_u));
        for (AlignedArray<std::uint16_t>* slice : {&slice_low_, &slice_high_})
            *slice = AlignedArray<std::uint16_t>(static_cast<std::size_t>(cells_u) * static_cast<std::size_t>(cells_v));
    }
    cells_w_ = component(level_.cells, g.axis);
    const std::size_t cells =
        static_cast<std::size_t>(cells_u) * static_cast<std::size_t>(cells_v) * static_cast<std::size_t>(cells_w_);
    turned_low_.resize(g.axis == 0 && towards_low != nullptr ? cells : 0);
    turned_high_.resize(g.axis == 0 && towards_high != nullptr ? cells : 0);
    low_ = towards_low;
    high_ = towards_high;
    for (int w = 0; w < cells_w_; ++w) {
        if (is_cancelled(cancel_)) {
            kernels_.finish_stores();
            return false;
        }
        look_up(plane, w, stats);
        const double depth = plane.places_u().depths[static_cast<std::size_t>(w)];
        if (low_ != nullptr)
            emit(g, slice_low_, depth, w, low_, turned_low_, stats);
        if (high_ != nullptr)
            emit(g, slice_high_, g.slices - depth, w, high_, turned_high_, stats);
    }
    kernels_.finish_stores();
    const ProcessorStopwatch watch(stats.lookup_s);
    if (!turned_low_.empty())
        turn(turned_low_, low_);
    if (!turned_high_.empty())
        turn(turned_high_, high_);
    return true;
}

void PairVisibility::look_up(RayPlane& plane, int slice, SweepStats& stats)
{
    const ProcessorStopwatch watch(stats.lookup_s);
    const SweepGeometry& g = plane.geometry();
    const CellPlaces &places_u = plane.places_u(), &places_v = plane.places_v();
    u_.place(g.u, places_u, level_.cell_side(u_axis_of(g.axis)), slice);
    v_.place(g.v, places_v, level_.cell_side(v_axis_of(g.axis)), slice);
    const double depth = places_u.depths[static_cast<std::size_t>(slice)];
    const float whole = static_cast<float>(g.slices * slice_weight);
    SideRow side{};
    side.begin_low = u_.begin_low.data();
    side.begin_high = u_.begin_high.data();
    side.end_low = u_.end_low.data();
    side.end_high = u_.end_high.data();
    side.enter = u_.enter.data();
    side.leave = u_.leave.data();
    side.fraction = places_u.fractions_of(slice);
    side.depth = static_cast<float>(depth);
    side.weight = static_cast<float>(weight_at(depth));
    side.count = cells_u_;
    side.scale = optical_scale(level_.extinction_of_one, g.slice_world);
    const float slices = static_cast<float>(g.slices);
    side.row = no_row_sides(whole, slices);
    kernels_.side_factors(forwards_.data(), backwards_.data(), side);

    for (int row = 0; row < cells_v_; ++row) {
        const std::size_t r = static_cast<std::size_t>(row);
        const float *forwards = forwards_.data(), *backwards = backwards_.data();
        if (const CellSides sides = v_.of(r); sees_sides(sides, whole, slices)) {
            SideRow own = side;
            own.row = row_sides(sides, slices, places_v.fractions_of(slice)[row]);
            kernels_.side_factors(row_forwards_.data(), row_backwards_.data(), own);
            forwards = row_forwards_.data();
            backwards = row_backwards_.data();
        }
        const float* tau = plane.tau_of(slice, row);
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(row) * cells_u_;
        if (low_ != nullptr)
            kernels_.to_visibility(slice_low_.data() + at, tau, forwards, cells_u_);
        if (high_ != nullptr) {
            plane.look_up(kernels_, slice, row, total_.data());
            kernels_.to_visibility_of_rest(slice_high_.data() + at, total_.data(), tau, backwards, cells_u_);
        }
    }
}

/// Filters a slice whose rays have come `distance` slices and writes it, in 8 bits, to where it belongs.
void PairVisibility::emit(const SweepGeometry& g, AlignedArray<std::uint16_t>& slice, double distance, int w,
                          std::uint8_t* visibility, std::vector<std::uint8_t>& turned, SweepStats& stats)
{
    const std::uint16_t* filtered = slice.data();
    if (tan_beta_ > 0.0) {
        const ProcessorStopwatch watch(stats.filter_s);
        const auto box = [&](int axis) {
            return box_side(distance, g.slice_world, tan_beta_, level_.cell_side_world(axis));
        };
        filtered = filter_->apply(slice.data(), box(u_axis_of(g.axis)), box(v_axis_of(g.axis)));
    }
    const ProcessorStopwatch watch(stats.lookup_s);
    const std::size_t x = static_cast<std::size_t>(level_.cells.x), y = static_cast<std::size_t>(level_.cells.y);
    const std::size_t z = static_cast<std::size_t>(level_.cells.z);
    const std::size_t slice_stride = g.axis == 0 ? y * z : g.axis == 1 ? x : x * y;
    const std::size_t row_stride = g.axis == 0 ? y : g.axis == 1 ? x * y : x;
    std::uint8_t* out = (turned.empty() ? visibility : turned.data()) + static_cast<std::size_t>(w) * slice_stride;
    for (int row = 0; row < cells_v_; ++row)
        kernels_.store(out + static_cast<std::size_t>(row) * row_stride,
                       filtered + static_cast<std::ptrdiff_t>(row) * cells_u_, cells_u_);
}

/// [x][z][y] to [z][y][x].
void PairVisibility::turn(const std::vector<std::uint8_t>& turned, std::uint8_t* visibility) const
{
    const std::size_t cx = static_cast<std::size_t>(level_.cells.x), cy = static_cast<std::size_t>(level_.cells.y);
    const std::size_t cz = static_cast<std::size_t>(level_.cells.z);
    for (std::size_t z = 0; z < cz; ++z)
        transpose(turned.data() + z * cy, cz * cy, visibility + z * cy * cx, cx, cy, cx);
}

} // namespace lumisweep
