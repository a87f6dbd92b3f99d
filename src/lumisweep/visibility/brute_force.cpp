#include "lumisweep/visibility/brute_force.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

/// Trilinear interpolation between voxel centres, clamped to the edge voxel; in stored steps.
double interpolate(const ExtinctionGrid& grid, const Vec3d& p)
{
    struct Pair {
        int low, high;
        double fraction;
    };
    const auto pair = [](double x, int size) {
        const double centre = std::clamp(x - 0.5, 0.0, size - 1.0);
        const int low = static_cast<int>(centre);
        return Pair{low, std::min(low + 1, size - 1), centre - low};
    };
    const Pair x = pair(p.x, grid.size.x), y = pair(p.y, grid.size.y), z = pair(p.z, grid.size.z);
    const auto stored = [&](int i, int j, int k) {
        const std::size_t row =
            static_cast<std::size_t>(k) * static_cast<std::size_t>(grid.size.y) + static_cast<std::size_t>(j);
        return static_cast<double>(
            grid.stored[row * static_cast<std::size_t>(grid.size.x) + static_cast<std::size_t>(i)]);
    };
    const auto along_x = [&](int j, int k) { return std::lerp(stored(x.low, j, k), stored(x.high, j, k), x.fraction); };
    const auto along_y = [&](int k) { return std::lerp(along_x(y.low, k), along_x(y.high, k), y.fraction); };
    return std::lerp(along_y(z.low), along_y(z.high), z.fraction);
}

/// How far p + t w stays inside of [0, size]; 0 when p is outside.
double distance_to_outside(const Vec3d& p, const Vec3d& w, Vec3i size)
{
    double t = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double x = component(p, axis), dx = component(w, axis), side = component(size, axis);
        if (x < 0.0 || x > side)
            return 0.0;
        if (dx != 0.0)
            t = std::min(t, ((dx > 0.0 ? side : 0.0) - x) / dx);
    }
    return std::isfinite(t) ? t : 0.0;
}

Vec3d random_in(std::mt19937_64& random)
{
    std::uniform_real_distribution<double> uniform;
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    return {x, y, z};
}

Vec3d cell_side(const VisibilityGrid& grid, Vec3i volume_size)
{
    return {static_cast<double>(volume_size.x) / grid.cells().x, static_cast<double>(volume_size.y) / grid.cells().y,
            static_cast<double>(volume_size.z) / grid.cells().z};
}

/// A grid of transmittance(p_voxel, w_world) at cell and texel centres.
template <class Transmittance>
VisibilityGrid grid_of(Vec3i volume_size, int voxels_per_cell, int directions_per_side, const std::atomic<bool>* cancel,
                       const Transmittance& transmittance)
{
    VisibilityGrid grid(volume_size, voxels_per_cell, directions_per_side);
    const Vec3d side = cell_side(grid, volume_size);
    parallel_for(0, grid.direction_count(), [&](int d) {
        const Vec3d w_world = texel_direction(d, directions_per_side);
        for (int k = 0; k < grid.cells().z; ++k)
            for (int j = 0; j < grid.cells().y && !is_cancelled(cancel); ++j)
                for (int i = 0; i < grid.cells().x; ++i) {
                    const double v = transmittance(Vec3d{i + 0.5, j + 0.5, k + 0.5} * side, w_world);
                    grid.direction(d)[grid.cell_index(i, j, k)] = static_cast<std::uint8_t>(std::lround(v * 255.0));
                }
    });
    return grid;
}

} // namespace

double transmittance_classified(const ExtinctionGrid& extinction, const Vec3d& p_voxel, const Vec3d& w_world)
{
    const double level_from_voxel = std::ldexp(1.0, -extinction.mip_level);
    const Vec3d p = p_voxel * level_from_voxel;
    const Vec3d w = inverse(extinction.world_from_voxel).vector(w_world) * level_from_voxel; // per world unit
    const double end = distance_to_outside(p, w, extinction.size);

    std::vector<double> cuts{0.0, end};
    for (int axis = 0; axis < 3; ++axis) {
        const double x = component(p, axis), dx = component(w, axis);
        for (int k = 0; dx != 0.0 && k < component(extinction.size, axis); ++k) {
            const double t = (k + 0.5 - x) / dx;
            if (t > 0.0 && t < end)
                cuts.push_back(t);
        }
    }
    std::sort(cuts.begin(), cuts.end());
    double optical_depth = 0.0;
    const double node = 0.5 / std::sqrt(3.0);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const double middle = 0.5 * (cuts[i] + cuts[i + 1]), width = cuts[i + 1] - cuts[i];
        optical_depth += 0.5 * width *
                         (interpolate(extinction, p + w * (middle - node * width)) +
                          interpolate(extinction, p + w * (middle + node * width)));
    }
    return std::exp(-optical_depth * static_cast<double>(extinction.scale));
}

double transmittance_exact(const ScalarGrid& volume, const TransferFunction& transfer_function, const Vec3d& p_voxel,
                           const Vec3d& w_world, double step_voxels)
{
    require(step_voxels >= 1e-4 && step_voxels <= 1e4, "transmittance: a step of {} voxels (use 0.0001 to 10000)",
            step_voxels);
    const Vec3d w = volume.voxel_from_world().vector(w_world);
    const double end = distance_to_outside(p_voxel, w, volume.size());
    const auto steps = static_cast<std::int64_t>(std::ceil(end * length(w) / step_voxels));
    double optical_depth = 0.0;
    for (std::int64_t i = 0; i < steps; ++i) {
        const double t = (static_cast<double>(i) + 0.5) * end / static_cast<double>(steps);
        optical_depth += transfer_function.evaluate(volume.interpolate(p_voxel + w * t)).extinction;
    }
    return steps > 0 ? std::exp(-optical_depth * end / static_cast<double>(steps)) : 1.0;
}

double transmittance_averaged(const ExtinctionGrid& extinction, const VisibilityGrid& grid, Vec3i cell, int direction,
                              int strata, std::uint64_t seed)
{
    std::mt19937_64 random(seed);
    const Vec3d side = cell_side(grid, extinction.volume_size);
    const int n = grid.directions_per_side();
    const TexelXY<std::int32_t> texel = morton_decode<std::int32_t>(direction);
    const int samples = strata * strata * strata;
    std::vector<int> direction_stratum(static_cast<std::size_t>(samples));
    std::iota(direction_stratum.begin(), direction_stratum.end(), 0);
    std::shuffle(direction_stratum.begin(), direction_stratum.end(), random);
    double sum = 0.0;
    for (int s = 0; s < samples; ++s) {
        const Vec3d jitter = random_in(random);
        const Vec3d p_voxel = {(cell.x + (s % strata + jitter.x) / strata) * side.x,
                               (cell.y + (s / strata % strata + jitter.y) / strata) * side.y,
                               (cell.z + (s / strata / strata + jitter.z) / strata) * side.z};
        // The texel in strata² columns × strata rows, in random order.
        const int stratum = direction_stratum[static_cast<std::size_t>(s)];
        const Vec3d shift = random_in(random);
        const double u = (stratum / strata + shift.x) / (strata * strata);
        const double v = (stratum % strata + shift.y) / strata;
        const Vec3d w_world = direction_from_oct(UV<double>{(texel.x + u) / n, (texel.y + v) / n});
        sum += transmittance_classified(extinction, p_voxel, w_world);
    }
    return sum / samples;
}

VisibilityGrid brute_force_visibility(const ExtinctionGrid& extinction, int voxels_per_cell, int directions_per_side,
                                      const std::atomic<bool>* cancel)
{
    return grid_of(extinction.volume_size, voxels_per_cell, directions_per_side, cancel,
                   [&](const Vec3d& p_voxel, const Vec3d& w_world) {
                       return transmittance_classified(extinction, p_voxel, w_world);
                   });
}

VisibilityGrid brute_force_visibility_exact(const ScalarGrid& volume, const TransferFunction& transfer_function,
                                            int voxels_per_cell, int directions_per_side, double step_voxels,
                                            const std::atomic<bool>* cancel)
{
    return grid_of(volume.size(), voxels_per_cell, directions_per_side, cancel,
                   [&](const Vec3d& p_voxel, const Vec3d& w_world) {
                       return transmittance_exact(volume, transfer_function, p_voxel, w_world, step_voxels);
                   });
}

SweepCheck sweep_check(const VisibilityGrid& grid, const ExtinctionGrid& extinction, int positions, std::uint64_t seed)
{
    require(positions >= 1, "sweep check: {} positions (use at least 1)", positions);
    const Vec3i size = extinction.volume_size, cells = grid.cells();
    require(cells.x >= 1 && cells.x <= size.x && cells.y >= 1 && cells.y <= size.y && cells.z >= 1 && cells.z <= size.z,
            "sweep check: the grid has {} x {} x {} cells, more than the volume has voxels", cells.x, cells.y, cells.z);
    const Vec3d side = cell_side(grid, size);
    struct Errors {
        double squares = 0.0, max = 0.0, squares_averaged = 0.0, max_averaged = 0.0;
    };
    std::vector<Errors> errors(static_cast<std::size_t>(positions));
    parallel_for(0, positions, [&](int s) {
        std::mt19937_64 random(seed + static_cast<std::uint64_t>(s) * 0x9e3779b97f4a7c15ULL);
        const Vec3d at = random_in(random);
        const Vec3i cell = {static_cast<int>(at.x * cells.x), static_cast<int>(at.y * cells.y),
                            static_cast<int>(at.z * cells.z)};
        const Vec3d p_voxel = Vec3d{cell.x + 0.5, cell.y + 0.5, cell.z + 0.5} * side;
        Errors& e = errors[static_cast<std::size_t>(s)];
        for (int d = 0; d < grid.direction_count(); ++d) {
            const double v = grid.direction(d)[grid.cell_index(cell.x, cell.y, cell.z)] / 255.0;
            const Vec3d w_world = texel_direction(d, grid.directions_per_side());
            const double point = std::fabs(v - transmittance_classified(extinction, p_voxel, w_world));
            const double averaged = std::fabs(v - transmittance_averaged(extinction, grid, cell, d, 4, random()));
            e.squares += point * point;
            e.max = std::max(e.max, point);
            e.squares_averaged += averaged * averaged;
            e.max_averaged = std::max(e.max_averaged, averaged);
        }
    });
    SweepCheck check;
    check.positions = positions;
    for (const Errors& e : errors) {
        check.rms += e.squares;
        check.max = std::max(check.max, e.max);
        check.rms_averaged += e.squares_averaged;
        check.max_averaged = std::max(check.max_averaged, e.max_averaged);
    }
    const double count = static_cast<double>(positions) * grid.direction_count();
    check.rms = std::sqrt(check.rms / count);
    check.rms_averaged = std::sqrt(check.rms_averaged / count);
    return check;
}

} // namespace lumisweep
