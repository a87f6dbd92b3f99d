#include "sweep_oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lumisweep/visibility/sweep_filter.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_kernel.h"
#include "sweep_oracle_level.h"

namespace lumisweep::test {
namespace {

/// The texel with the opposite centre, −1 where there is none.
int opposite_of(int direction, int n)
{
    const Vec3d w = texel_direction(direction, n);
    for (int d = 0; d < n * n; ++d)
        if (dot(w, texel_direction(d, n)) < -1.0 + 1e-9)
            return d;
    return -1;
}

/// Where the cells of one slice lie along one axis of the plane: beside which ray, how far towards the next.
struct Place {
    int ray; // less first_ray
    float fraction;
};

Place place_of(const SweepAxis& axis, double cell_side, double depth, int cell)
{
    const double begin = 0.5 * cell_side - 0.5 - axis.slope * depth - axis.first_ray;
    const bool even = cell_side == std::floor(cell_side) && cell_side <= 8.0; // all cells share the first's fraction
    const double x = even ? begin : begin + cell * cell_side;
    const double low = std::floor(x);
    return {static_cast<int>(low) + (even ? cell * static_cast<int>(cell_side) : 0), static_cast<float>(x - low)};
}

/// One line's rays and, at the cells, what they held there.
class IntegerLine {
public:
    IntegerLine(const Level& level, const Vec3d& w_world)
        : level_(level), g_(level.extinction.size, level.level_from_world, w_world), u_axis_(u_axis_of(g_.axis)),
          v_axis_(v_axis_of(g_.axis)), cells_u_(component(level.cells, u_axis_)),
          cells_v_(component(level.cells, v_axis_)), cells_w_(component(level.cells, g_.axis)),
          tau_(static_cast<std::size_t>(g_.u.ray_count) * static_cast<std::size_t>(g_.v.ray_count), 0)
    {
        double depth = 0.0;
        for (int w = 0; w <= cells_w_; ++w) {
            const double next = w < cells_w_ ? (w + 0.5) * component(level.cell_sides, g_.axis) : g_.slices;
            for (const SweepPiece& piece : g_.pieces(depth, next))
                march(piece);
            for (int v = 0; w < cells_w_ && v < cells_v_; ++v)
                for (int u = 0; u < cells_u_; ++u)
                    until_cell_.push_back(held_at(u, v, next));
            depth = next;
        }
    }

    /// In 1/4080, filtered: [w][v][u].
    std::vector<int> visibility(bool towards_high, double tan_beta) const
    {
        std::vector<int> all;
        for (int w = 0; w < cells_w_; ++w) {
            const double depth = depth_of(w);
            std::vector<int> slice;
            for (int v = 0; v < cells_v_; ++v)
                for (int u = 0; u < cells_u_; ++u)
                    slice.push_back(cell_visibility(u, v, w, towards_high));
            if (tan_beta > 0.0) {
                const double distance = towards_high ? g_.slices - depth : depth;
                const auto box = [&](int axis) {
                    return 1.0 + distance * g_.slice_world * tan_beta /
                                     (level_.voxel_side_world(axis) * component(level_.cell_sides, axis));
                };
                filter(slice, cells_v_, cells_u_, 1, cells_u_, box(u_axis_));
                filter(slice, cells_u_, 1, cells_u_, cells_v_, box(v_axis_));
            }
            all.insert(all.end(), slice.begin(), slice.end());
        }
        return all;
    }

    /// Adds V in 8 bits to sums at the cells.
    void add(std::vector<int>& sums, bool towards_high, double tan_beta) const
    {
        const std::vector<int> v = visibility(towards_high, tan_beta);
        std::size_t at = 0;
        for (int k = 0; k < cells_w_; ++k)
            for (int j = 0; j < cells_v_; ++j)
                for (int i = 0; i < cells_u_; ++i)
                    sums[level_.cell_index(g_.axis, i, j, k)] += (v[at++] + 8) / 16;
    }

    bool towards_high() const { return g_.towards_high_side; }

private:
    double depth_of(int w) const { return (w + 0.5) * component(level_.cell_sides, g_.axis); }

    void march(const SweepPiece& piece)
    {
        const auto counts = [&](const SweepAxis& axis, int ray) {
            const std::size_t i = static_cast<std::size_t>(ray);
            return axis.begin[i] <= piece.slice && piece.slice < axis.end[i];
        };
        for (int m = 0; m < g_.v.ray_count; ++m)
            for (int i = 0; counts(g_.v, m) && i < g_.u.ray_count; ++i) {
                if (!counts(g_.u, i))
                    continue;
                const int u = i + g_.u.first_ray + piece.shift_u, v = m + g_.v.first_ray + piece.shift_v;
                ray(i, m) += piece.weight[0] * level_.voxel(g_.axis, u, v, piece.slice) +
                             piece.weight[1] * level_.voxel(g_.axis, u, v + 1, piece.slice) +
                             piece.weight[2] * level_.voxel(g_.axis, u + 1, v, piece.slice) +
                             piece.weight[3] * level_.voxel(g_.axis, u + 1, v + 1, piece.slice);
            }
    }

    std::int32_t& ray(int i, int m) { return tau_[static_cast<std::size_t>(m * g_.u.ray_count + i)]; }
    float ray(int i, int m) const { return static_cast<float>(tau_[static_cast<std::size_t>(m * g_.u.ray_count + i)]); }

    /// What the rays hold now, at a cell.
    float held_at(int u, int v, double depth) const
    {
        const Place a = place_of(g_.u, component(level_.cell_sides, u_axis_), depth, u);
        const Place b = place_of(g_.v, component(level_.cell_sides, v_axis_), depth, v);
        const IntegerLine& now = *this;
        const float below = now.ray(a.ray, b.ray) * (1.0F - a.fraction) + now.ray(a.ray + 1, b.ray) * a.fraction;
        const float above =
            now.ray(a.ray, b.ray + 1) * (1.0F - a.fraction) + now.ray(a.ray + 1, b.ray + 1) * a.fraction;
        return below * (1.0F - b.fraction) + above * b.fraction;
    }

    /// In 1/4080. The two kernels that turn optical depth to V have tests of their own.
    int cell_visibility(int u, int v, int w, bool towards_high) const
    {
        const double depth = depth_of(w);
        const double side_u = component(level_.cell_sides, u_axis_), side_v = component(level_.cell_sides, v_axis_);
        const Place a = place_of(g_.u, side_u, depth, u), b = place_of(g_.v, side_v, depth, v);
        const auto weight = [](const std::vector<int>& slices, int ray) {
            return static_cast<float>(slices[static_cast<std::size_t>(ray)] * slice_weight);
        };
        const auto pass = [&](const SweepAxis& axis, double cell_side, int cell) {
            return axis.pass(0.5 * cell_side - 0.5 - axis.slope * depth + cell * cell_side);
        };
        const float begin[2] = {weight(g_.u.begin, a.ray), weight(g_.u.begin, a.ray + 1)};
        const float end[2] = {weight(g_.u.end, a.ray), weight(g_.u.end, a.ray + 1)};
        const SidePass column = pass(g_.u, side_u, u), row = pass(g_.v, side_v, v);
        const float enter = static_cast<float>(column.enter), leave = static_cast<float>(column.leave);
        const float whole = static_cast<float>(g_.slices * slice_weight), slices = static_cast<float>(g_.slices);
        SideRow side{};
        side.begin_low = &begin[0];
        side.begin_high = &begin[1];
        side.end_low = &end[0];
        side.end_high = &end[1];
        side.enter = &enter;
        side.leave = &leave;
        side.fraction = &a.fraction;
        for (int k = 0; k < 2; ++k) {
            side.row.begin[k] = weight(g_.v.begin, b.ray + k);
            side.row.end[k] = weight(g_.v.end, b.ray + k);
        }
        side.row.enter = std::max(static_cast<float>(row.enter), 0.0F);
        side.row.leave = std::min(static_cast<float>(row.leave), slices);
        // Interpolating between two rows of rays that see all slices would only round.
        const bool passes_a_side = side.row.begin[0] > 0.0F || side.row.begin[1] > 0.0F || side.row.enter > 0.0F ||
                                   side.row.end[0] < whole || side.row.end[1] < whole || side.row.leave < slices;
        side.row.fraction = passes_a_side ? b.fraction : 0.0F;
        side.depth = static_cast<float>(depth);
        side.weight = static_cast<float>(weight_at(depth));
        side.scale =
            static_cast<float>(static_cast<double>(level_.extinction.scale) * g_.slice_world * std::numbers::log2e);
        side.count = 1;
        float forwards = 0.0F, backwards = 0.0F;
        sweep_kernels_baseline.side_factors(&forwards, &backwards, side);
        const float tau = until_cell_[static_cast<std::size_t>((w * cells_v_ + v) * cells_u_ + u)];
        std::uint16_t visibility = 0;
        if (towards_high) {
            const float total = held_at(u, v, depth);
            sweep_kernels_baseline.to_visibility_of_rest(&visibility, &total, &tau, &backwards, 1);
        } else {
            sweep_kernels_baseline.to_visibility(&visibility, &tau, &forwards, 1);
        }
        return visibility;
    }

    /// Box filter of `lines` lines of `count` cells, by sums of sweep_filter.h's precision.
    static void filter(std::vector<int>& slice, int lines, int line_stride, int cell_stride, int count, double box)
    {
        const double side = std::clamp(0.5 * (box - 1.0), 0.0, static_cast<double>(count));
        const int reach = static_cast<int>(side);
        const double part = side - reach;
        if (count == 1 || (reach == 0 && part < 1e-4))
            return;
        int shift = 0;
        while (((whole_visibility + ((1 << shift) >> 1)) >> shift) * std::min(2 * reach + 1, count) > 65535)
            ++shift;
        std::vector<int> mean(static_cast<std::size_t>(count));
        for (int line = 0; line < lines; ++line) {
            const auto cell = [&](int i) -> int& {
                return slice[static_cast<std::size_t>(line * line_stride + i * cell_stride)];
            };
            for (int i = 0; i < count; ++i) {
                int whole = 0, cells = 0, ends = 0, end_cells = 0;
                for (int j = 0; j < count; ++j) {
                    const int distance = std::abs(i - j), v = (cell(j) + ((1 << shift) >> 1)) >> shift;
                    whole += distance <= reach ? v : 0;
                    cells += distance <= reach ? 1 : 0;
                    ends += distance == reach + 1 ? v : 0;
                    end_cells += distance == reach + 1 ? 1 : 0;
                }
                const double one = std::ldexp(65536.0, shift) / (cells + part * end_cells);
                const auto scaled = [](int sum, double scale) {
                    return static_cast<int>(sum * static_cast<std::int64_t>(std::min(std::ceil(scale), 65535.0)) >> 16);
                };
                const int found = scaled(whole, one) + scaled(ends, one * part);
                // Fewer than 8 bits a cell would round 1 up.
                mean[static_cast<std::size_t>(i)] = shift > 4 ? std::min(found, whole_visibility) : found;
            }
            for (int i = 0; i < count; ++i)
                cell(i) = mean[static_cast<std::size_t>(i)];
        }
    }

    const Level& level_;
    SweepGeometry g_;
    int u_axis_, v_axis_, cells_u_, cells_v_, cells_w_;
    std::vector<std::int32_t> tau_; // [ray row][ray]
    std::vector<float> until_cell_; // [w][v][u]
};

} // namespace

std::vector<std::uint8_t> sweep_in_integers(const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                                            int direction)
{
    const Level level(extinction, settings.cell);
    if (!(extinction.scale > 0.0F))
        return std::vector<std::uint8_t>(level.cell_count(), 255);
    // Two opposite texels share a line, which is the one's with the lower index.
    const int other = opposite_of(direction, settings.directions);
    const int named = other >= 0 ? std::min(direction, other) : direction;
    const int lines = settings.oversampling;
    const int side = settings.directions * static_cast<int>(std::lround(std::sqrt(lines)));
    const double tan_beta = std::tan(filter_angle(settings.filter, settings.directions));
    std::vector<int> sums(level.cell_count(), 0);
    for (int k = 0; k < lines; ++k) {
        const IntegerLine line(level, texel_direction(named * lines + k, side));
        line.add(sums, line.towards_high() == (direction == named), tan_beta);
    }
    std::vector<std::uint8_t> mean;
    for (const int sum : sums)
        mean.push_back(static_cast<std::uint8_t>((sum + lines / 2) / lines));
    return mean;
}

} // namespace lumisweep::test
