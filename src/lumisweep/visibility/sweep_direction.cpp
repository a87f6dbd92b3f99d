#include "lumisweep/visibility/sweep_direction.h"

#include <algorithm>
#include <cmath>

#include "lumisweep/base/stopwatch.h"

namespace lumisweep {
namespace {

int u_axis_of(int axis) { return axis == 0 ? 1 : 0; }
int v_axis_of(int axis) { return axis == 2 ? 1 : 2; }

} // namespace

DirectionSweep::DirectionSweep(const MarchedVolume& volume, Vec3i volume_size, Vec3i cells,
                               const std::atomic<bool>* cancel)
    : volume_(volume), kernels_(sweep_kernels()), volume_size_(volume_size), cells_(cells), cancel_(cancel),
      stored_(static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z))
{
}

bool DirectionSweep::run(const Vec3d& w_world, double tan_beta, SweepFilter filter_kind, std::uint8_t* visibility)
{
    const SweepGeometry geometry(volume_.size, volume_.level_from_world, w_world);
    geometry_ = &geometry;
    start();
    SliceFilter slice_filter(cells_u_, cells_v_);
    const double side_u = component(volume_.voxel_sides_world, u_axis_of(geometry.axis));
    const double side_v = component(volume_.voxel_sides_world, v_axis_of(geometry.axis));
    double depth = 0.0;
    for (int k = 0; k < cells_w_; ++k) {
        const int slice = geometry.from_high_side ? cells_w_ - 1 - k : k;
        const double next = geometry.depth_of((slice + 0.5) * cell_w_);
        if (!march(depth, next) || !look_up(next))
            return false;
        depth = next;
        if (filter_kind != SweepFilter::none) {
            const Stopwatch watch(stats_.filter_s);
            const double widening_world = depth * geometry.slice_world * tan_beta;
            slice_filter.apply(slice_.data(), 1.0 + widening_world / (side_u * cell_u_),
                               1.0 + widening_world / (side_v * cell_v_));
        }
        const Stopwatch watch(stats_.lookup_s);
        store(slice);
    }
    const Stopwatch watch(stats_.lookup_s);
    finish(visibility);
    return true;
}

void DirectionSweep::start()
{
    const SweepGeometry& g = *geometry_;
    const auto cell_side = [&](int axis) {
        return static_cast<double>(component(volume_size_, axis)) / component(cells_, axis) /
               volume_.voxels_per_level_voxel;
    };
    cells_u_ = component(cells_, u_axis_of(g.axis));
    cells_v_ = component(cells_, v_axis_of(g.axis));
    cells_w_ = component(cells_, g.axis);
    cell_u_ = cell_side(u_axis_of(g.axis));
    cell_v_ = cell_side(v_axis_of(g.axis));
    cell_w_ = cell_side(g.axis);
    tau_.assign(static_cast<std::size_t>(g.u.ray_count) * static_cast<std::size_t>(g.v.ray_count), 0);
    mixed_.assign(static_cast<std::size_t>(g.u.size) + 2, 0);
    slice_.resize(static_cast<std::size_t>(cells_u_) * static_cast<std::size_t>(cells_v_));
    mixed_tau_.resize(static_cast<std::size_t>(g.u.ray_count));
    mixed_length_.resize(static_cast<std::size_t>(g.u.ray_count));
    scratch_.resize(static_cast<std::size_t>(cells_u_));
    const auto split = [](const SweepAxis& axis, std::vector<float>& enter, std::vector<float>& leave) {
        enter.clear();
        leave.clear();
        for (const SidePass& pass : axis.passes) {
            enter.push_back(static_cast<float>(pass.enter));
            leave.push_back(static_cast<float>(pass.leave));
        }
    };
    split(g.u, enter_u_, leave_u_);
    split(g.v, enter_v_, leave_v_);
}

bool DirectionSweep::march(double begin_depth, double end_depth)
{
    const Stopwatch watch(stats_.march_s);
    const std::vector<SweepStep> steps = sweep_steps(*geometry_, begin_depth, end_depth);
    if (steps.empty())
        return true;
    // Rows outside, slices inside: a row of rays stays in the first-level cache for all the slices up to the next
    // lookup.
    int first = steps.front().v.touched_first, last = steps.front().v.touched_last;
    for (const SweepStep& step : steps) {
        first = std::min(first, step.v.touched_first);
        last = std::max(last, step.v.touched_last);
        stats_.voxel_steps += static_cast<std::uint64_t>(step.u.touched_last - step.u.touched_first) *
                              static_cast<std::uint64_t>(step.v.touched_last - step.v.touched_first);
    }
    for (int ray_row = first; ray_row < last; ++ray_row) {
        if (cancelled())
            return false;
        for (const SweepStep& step : steps)
            if (ray_row >= step.v.touched_first && ray_row < step.v.touched_last)
                march_row(step, ray_row);
    }
    return true;
}

void DirectionSweep::march_row(const SweepStep& step, int ray_row)
{
    const SweepGeometry& g = *geometry_;
    const bool across_x = g.axis == 0;
    const std::uint8_t* voxels = across_x ? volume_.transposed : volume_.voxels;
    const std::size_t size_x = static_cast<std::size_t>(volume_.size.x),
                      size_y = static_cast<std::size_t>(volume_.size.y);
    const std::size_t slice_stride = across_x      ? size_y * static_cast<std::size_t>(volume_.size.z)
                                     : g.axis == 1 ? size_x
                                                   : size_x * size_y;
    const std::size_t row_stride = across_x ? size_y : g.axis == 1 ? size_x * size_y : size_x;
    const auto row = [&](int v) {
        return voxels + static_cast<std::size_t>(step.slice) * slice_stride +
               static_cast<std::size_t>(std::clamp(v, 0, g.v.size - 1)) * row_stride;
    };
    // Voxel k of the mixed row is at mixed_[k + 1]; values clamp to the edge voxel.
    const int weight_v = static_cast<int>(std::lround(step.v.fraction * 256.0));
    kernels_.mix_rows(mixed_.data() + 1, row(ray_row + step.v.shift), row(ray_row + step.v.shift + 1), weight_v,
                      g.u.size);
    mixed_.front() = mixed_[1];
    mixed_.back() = mixed_[static_cast<std::size_t>(g.u.size)];

    if (ray_row < step.v.first || ray_row >= step.v.last) {
        march_partial(step, ray_row, step.u.touched_first, step.u.touched_last);
        return;
    }
    march_partial(step, ray_row, step.u.touched_first, step.u.first);
    if (step.u.first < step.u.last) {
        const double whole = whole_weight * (step.end - step.begin);
        const int weight_u = static_cast<int>(std::lround(whole * step.u.fraction));
        std::int32_t* tau =
            tau_.data() + static_cast<std::size_t>(ray_row - g.v.first_ray) * static_cast<std::size_t>(g.u.ray_count) +
            static_cast<std::size_t>(step.u.first - g.u.first_ray);
        kernels_.advance_rays(tau, mixed_.data() + (step.u.first + step.u.shift + 1),
                              static_cast<int>(std::lround(whole)) - weight_u, weight_u, step.u.last - step.u.first);
    }
    march_partial(step, ray_row, step.u.last, step.u.touched_last);
}

// They count only with their part inside of the box.
void DirectionSweep::march_partial(const SweepStep& step, int ray_row, int first, int last)
{
    const SweepGeometry& g = *geometry_;
    const SidePass& row_pass = g.v.passes[static_cast<std::size_t>(ray_row - g.v.first_ray)];
    std::int32_t* tau =
        tau_.data() + static_cast<std::size_t>(ray_row - g.v.first_ray) * static_cast<std::size_t>(g.u.ray_count);
    for (int i = first; i < last; ++i) {
        const SidePass& pass = g.u.passes[static_cast<std::size_t>(i - g.u.first_ray)];
        const double inside =
            std::min({step.end, pass.leave, row_pass.leave}) - std::max({step.begin, pass.enter, row_pass.enter});
        if (inside <= 0.0)
            continue;
        const std::size_t k = static_cast<std::size_t>(std::clamp(i + step.u.shift, -1, g.u.size - 1) + 1);
        const double mixed = mixed_[k] + (static_cast<double>(mixed_[k + 1]) - mixed_[k]) * step.u.fraction;
        tau[i - g.u.first_ray] += static_cast<std::int32_t>(std::lround(mixed * inside));
    }
}

void DirectionSweep::CellLine::place(const SweepAxis& axis, double depth, double voxels_per_cell)
{
    const std::size_t count = ray.size();
    for (std::size_t i = 0; i < count; ++i) {
        const double x = (static_cast<double>(i) + 0.5) * voxels_per_cell - 0.5 - axis.slope * depth;
        const double low = std::floor(x);
        ray[i] = std::clamp(static_cast<int>(low) - axis.first_ray, 0, axis.ray_count - 2);
        fraction[i] = static_cast<float>(x - low);
        const SidePass pass = axis.pass(x);
        enter[i] = static_cast<float>(pass.enter);
        leave[i] = static_cast<float>(pass.leave);
    }
}

bool DirectionSweep::look_up(double depth)
{
    const Stopwatch watch(stats_.lookup_s);
    const SweepGeometry& g = *geometry_;
    const auto place = [&](CellLine& line, const SweepAxis& axis, int cells, double cell) {
        const std::size_t count = static_cast<std::size_t>(cells);
        line.ray.resize(count);
        line.fraction.resize(count);
        line.enter.resize(count);
        line.leave.resize(count);
        line.place(axis, depth, cell);
    };
    place(line_u_, g.u, cells_u_, cell_u_);
    place(line_v_, g.v, cells_v_, cell_v_);
    const int first = line_u_.ray.front(), count = line_u_.ray.back() + 2 - first;
    LookupRow row{};
    row.tau = mixed_tau_.data();
    row.length = mixed_length_.data();
    row.ray = line_u_.ray.data();
    row.fraction = line_u_.fraction.data();
    row.enter = line_u_.enter.data();
    row.leave = line_u_.leave.data();
    row.tau_scale =
        static_cast<float>(volume_.extinction_of_one * g.slice_world * (65536.0 / whole_weight) / optical_depth_unit);
    row.count = cells_u_;
    const float depth_f = static_cast<float>(depth);
    for (std::size_t j = 0; j < static_cast<std::size_t>(cells_v_); ++j) {
        if (cancelled())
            return false;
        const int ray_row = line_v_.ray[j];
        const std::int32_t* low =
            tau_.data() + static_cast<std::size_t>(ray_row) * static_cast<std::size_t>(g.u.ray_count) + first;
        kernels_.mix_rays(mixed_tau_.data() + first, low, low + g.u.ray_count, line_v_.fraction[j], count);
        kernels_.mix_lengths(mixed_length_.data() + first, enter_u_.data() + first, leave_u_.data() + first,
                             enter_v_.data() + ray_row, leave_v_.data() + ray_row, depth_f, line_v_.fraction[j], count);
        row.row_enter = line_v_.enter[j];
        row.row_leave = line_v_.leave[j];
        kernels_.look_up(slice_.data() + j * static_cast<std::size_t>(cells_u_), row, depth_f, scratch_.data());
    }
    return true;
}

/// Writes the slice in 8 bits; for sweeps along x in the order [x][z][y], which finish() turns.
void DirectionSweep::store(int slice)
{
    const std::size_t cx = static_cast<std::size_t>(cells_.x), cy = static_cast<std::size_t>(cells_.y);
    const std::size_t cz = static_cast<std::size_t>(cells_.z);
    const int axis = geometry_->axis;
    const std::size_t slice_stride = axis == 0 ? cy * cz : axis == 1 ? cx : cx * cy;
    const std::size_t row_stride = axis == 0 ? cy : axis == 1 ? cx * cy : cx;
    const std::size_t count = static_cast<std::size_t>(cells_u_);
    for (std::size_t j = 0; j < static_cast<std::size_t>(cells_v_); ++j) {
        std::uint8_t* out = stored_.data() + static_cast<std::size_t>(slice) * slice_stride + j * row_stride;
        const std::int32_t* in = slice_.data() + j * count;
        for (std::size_t i = 0; i < count; ++i)
            out[i] = static_cast<std::uint8_t>((in[i] * 255 + whole_visibility / 2) / whole_visibility);
    }
}

void DirectionSweep::finish(std::uint8_t* visibility)
{
    if (geometry_->axis != 0) {
        std::copy(stored_.begin(), stored_.end(), visibility);
        return;
    }
    const std::size_t cx = static_cast<std::size_t>(cells_.x), cy = static_cast<std::size_t>(cells_.y);
    const std::size_t cz = static_cast<std::size_t>(cells_.z);
    constexpr std::size_t block = 16;
    for (std::size_t z = 0; z < cz; ++z)
        for (std::size_t y0 = 0; y0 < cy; y0 += block)
            for (std::size_t x0 = 0; x0 < cx; x0 += block)
                for (std::size_t y = y0; y < std::min(y0 + block, cy); ++y)
                    for (std::size_t x = x0; x < std::min(x0 + block, cx); ++x)
                        visibility[(z * cy + y) * cx + x] = stored_[(x * cz + z) * cy + y];
}

} // namespace lumisweep
