#include "lumisweep/visibility/sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/visibility/sweep_direction.h"

namespace lumisweep {
namespace {

MarchedVolume prepare(const ExtinctionGrid& extinction, const std::vector<int>& directions, int n)
{
    MarchedVolume volume;
    volume.size = extinction.size;
    volume.voxels = extinction.stored.data();
    volume.transposed = extinction.transposed.data();
    volume.voxels_per_level_voxel = std::ldexp(1.0, extinction.mip_level);
    volume.extinction_of_one = static_cast<double>(extinction.scale);
    Affine3d world_from_level = extinction.world_from_voxel;
    for (Vec3d& column : world_from_level.column)
        column = column * volume.voxels_per_level_voxel;
    volume.level_from_world = inverse(world_from_level);
    volume.voxel_sides_world = {length(world_from_level.column[0]), length(world_from_level.column[1]),
                                length(world_from_level.column[2])};
    for (const int d : directions)
        require(!extinction.transposed.empty() ||
                    SweepGeometry(volume.size, volume.level_from_world, texel_direction(d, n)).axis != 0,
                "visibility sweep: direction {} runs along x and needs the transposed layout (see ExtinctionLayouts)",
                d);
    return volume;
}

void check(const VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
           std::span<const int> directions, int level)
{
    settings.validate();
    require(!extinction.stored.empty(), "visibility sweep: the volume has not been classified");
    require(grid.directions_per_side() == settings.directions &&
                grid.cells() == VisibilityGrid::cells_of(extinction.volume_size, settings.cell),
            "visibility sweep: the grid was made for another volume or other visibility settings (make a new one)");
    require(level == extinction.mip_level,
            "visibility sweep: mip level {} is needed but level {} was classified (see sweep_mip_level)", level,
            extinction.mip_level);
    for (const int d : directions)
        require(d >= 0 && d < grid.direction_count(), "visibility sweep: direction {} is not in 0 to {}", d,
                grid.direction_count() - 1);
}

/// The directions in the caller's order, each once: no two threads may write the same one.
std::vector<int> order_of(std::span<const int> directions, int direction_count)
{
    std::vector<int> order;
    if (directions.empty()) {
        order.resize(static_cast<std::size_t>(direction_count));
        std::iota(order.begin(), order.end(), 0);
        return order;
    }
    std::vector<bool> seen(static_cast<std::size_t>(direction_count), false);
    for (const int d : directions)
        if (!seen[static_cast<std::size_t>(d)]) {
            seen[static_cast<std::size_t>(d)] = true;
            order.push_back(d);
        }
    return order;
}

} // namespace

int sweep_mip_level(Vec3i volume_size, int rays)
{
    int side = std::max({volume_size.x, volume_size.y, volume_size.z});
    // Filtered V from rays two voxels apart is as good as from all rays, so "auto" halves until fewer than 512 are
    // left.
    const int most = rays > 0 ? rays : 511;
    int level = 0;
    for (; side > most && side > 1; side = (side + 1) / 2)
        ++level;
    return level;
}

SweepStats sweep_visibility(VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                            std::span<const int> directions, const std::atomic<bool>* cancel)
{
    const auto begin = std::chrono::steady_clock::now();
    const int level = sweep_mip_level(extinction.volume_size, settings.rays);
    check(grid, extinction, settings, directions, level);

    const std::vector<int> order = order_of(directions, grid.direction_count());
    const double tan_beta = std::tan(filter_angle(settings.filter, settings.directions));
    const MarchedVolume volume = prepare(extinction, order, settings.directions);
    tbb::enumerable_thread_specific<DirectionSweep> sweep_of_thread(
        [&] { return DirectionSweep(volume, extinction.volume_size, grid.cells(), cancel); });
    parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
        if (cancel != nullptr && cancel->load(std::memory_order_relaxed))
            return;
        if (extinction.scale > 0.0F)
            sweep_of_thread.local().run(texel_direction(order[i], settings.directions), tan_beta, settings.filter,
                                        grid.direction(order[i]));
        else
            std::memset(grid.direction(order[i]), 255, grid.cell_count());
    });

    SweepStats stats;
    for (const DirectionSweep& sweep : sweep_of_thread) {
        stats.march_s += sweep.stats().march_s;
        stats.lookup_s += sweep.stats().lookup_s;
        stats.filter_s += sweep.stats().filter_s;
        stats.voxel_steps += sweep.stats().voxel_steps;
    }
    stats.mip_level = level;
    stats.rays = std::max({volume.size.x, volume.size.y, volume.size.z});
    stats.total_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return stats;
}

} // namespace lumisweep
