#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sweep_oracle.h"
#include "sweep_oracle_level.h"

namespace lumisweep::test {
namespace {

struct Interval {
    double begin, end;
};

} // namespace

std::vector<double> sweep_in_reals(const ExtinctionGrid& extinction, const VisibilitySettings& settings, int direction)
{
    const Level level(extinction, settings.cell);
    const Vec3i size = extinction.size;
    const Vec3d w_level = level.level_from_world.vector(texel_direction(direction, settings.directions));
    int axis = 0;
    for (const int candidate : {1, 2})
        if (std::fabs(component(w_level, candidate)) > std::fabs(component(w_level, axis)) * (1.0 - 1e-9))
            axis = candidate;
    if (axis == 2 && std::fabs(w_level.y) >= std::fabs(w_level.z) * (1.0 - 1e-9))
        axis = 1;
    const int au = across_u(axis), av = across_v(axis);
    const double slope_u = component(w_level, au) / component(w_level, axis);
    const double slope_v = component(w_level, av) / component(w_level, axis);
    const int slices = component(size, axis);
    const double extinction_of_slice = static_cast<double>(extinction.scale) / std::fabs(component(w_level, axis));
    const bool towards_high = component(w_level, axis) > 0.0;

    /// The depths between which a line is inside of the box; it passes (x, y) on the start face, from voxel centre 0.
    const auto inside = [&](double x, double y) {
        double enter = 0.0, leave = slices;
        const auto clip = [&](double begin, double slope, int sides) {
            const double low = -0.5 - begin, high = sides - 0.5 - begin;
            if (std::fabs(slope) < 1e-12) {
                if (low > 0.0 || high < 0.0)
                    leave = enter = 0.0;
                return;
            }
            enter = std::max(enter, std::min(low / slope, high / slope));
            leave = std::min(leave, std::max(low / slope, high / slope));
        };
        clip(x, slope_u, component(size, au));
        clip(y, slope_v, component(size, av));
        return Interval{enter, std::max(enter, leave)};
    };
    // Slices are cut where cells look up; each part is sampled bilinearly at its middle.
    std::vector<double> cuts;
    for (int slice = 0; slice <= slices; ++slice)
        cuts.push_back(slice);
    for (int cell = 0; cell < component(level.cells, axis); ++cell)
        cuts.push_back((cell + 0.5) * component(level.cell_sides, axis));
    std::sort(cuts.begin(), cuts.end());
    const auto ray_sum = [&](int i, int m, double begin, double end) {
        const Interval pass = inside(i, m);
        const double first = std::floor(pass.begin + 1e-9), last = std::ceil(pass.end - 1e-9);
        double sum = 0.0, counted = 0.0;
        for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
            const double from = cuts[c], to = cuts[c + 1];
            if (from < std::max(first, begin) || to > std::min(last, end) || to - from < 1e-9)
                continue;
            const double middle = 0.5 * (from + to), u = i + slope_u * middle, v = m + slope_v * middle;
            const int slice = static_cast<int>(middle);
            const int iu = static_cast<int>(std::floor(u)), iv = static_cast<int>(std::floor(v));
            const auto row = [&](int k) {
                return std::lerp(static_cast<double>(level.voxel(axis, iu, k, slice)),
                                 static_cast<double>(level.voxel(axis, iu + 1, k, slice)), u - iu);
            };
            sum += (to - from) * std::lerp(row(iv), row(iv + 1), v - iv);
            counted += to - from;
        }
        return std::pair{sum, counted};
    };

    std::vector<double> visibility(level.cell_count());
    for (int cw = 0; cw < component(level.cells, axis); ++cw)
        for (int cv = 0; cv < component(level.cells, av); ++cv)
            for (int cu = 0; cu < component(level.cells, au); ++cu) {
                const double depth = (cw + 0.5) * component(level.cell_sides, axis);
                const double x = (cu + 0.5) * component(level.cell_sides, au) - 0.5 - slope_u * depth;
                const double y = (cv + 0.5) * component(level.cell_sides, av) - 0.5 - slope_v * depth;
                const double begin = towards_high ? depth : 0.0, end = towards_high ? slices : depth;
                const int i = static_cast<int>(std::floor(x)), m = static_cast<int>(std::floor(y));
                double sum = 0.0, counted = 0.0;
                for (const int di : {0, 1})
                    for (const int dm : {0, 1}) {
                        const double share = (di == 0 ? 1.0 - (x - i) : x - i) * (dm == 0 ? 1.0 - (y - m) : y - m);
                        const auto [held, slices_counted] = ray_sum(i + di, m + dm, begin, end);
                        sum += share * held;
                        counted += share * slices_counted;
                    }
                const Interval own = inside(x, y);
                const double way = std::max(0.0, std::min(end, own.end) - std::max(begin, own.begin));
                const double optical_depth = counted > 0.0 ? sum / counted * way * extinction_of_slice : 0.0;
                visibility[level.cell_index(axis, cu, cv, cw)] = std::exp(-optical_depth);
            }
    return visibility;
}

} // namespace lumisweep::test
