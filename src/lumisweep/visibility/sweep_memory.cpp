#include "lumisweep/visibility/sweep_memory.h"

#include <algorithm>

#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_kernel.h"
#include "lumisweep/visibility/sweep_plan.h"

namespace lumisweep {

namespace {

Vec3i level_size(Vec3i volume_size, const VisibilitySettings& settings)
{
    const int level = sweep_mip_level(volume_size, settings.rays);
    const auto halved = [&](int side) { return static_cast<int>((std::int64_t{side} + (1 << level) - 1) >> level); };
    return {halved(volume_size.x), halved(volume_size.y), halved(volume_size.z)};
}

/// What a thread has beside its lines: the pairs of voxel rows of a few slices; slices of V, filtered and not; V of
/// whole lines, which sweeps along x turn in the end and oversampling sums.
std::uint64_t thread_bytes(Vec3i size, Vec3i cells, const VisibilitySettings& settings)
{
    const auto of = [](const Vec3i& sides, int axis) { return static_cast<std::uint64_t>(component(sides, axis)); };
    std::uint64_t pairs = 0, slice = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = u_axis_of(axis), v = v_axis_of(axis);
        pairs = std::max(pairs, march_slices * (of(size, v) + 16) * (2 * of(size, u) + 256));
        slice = std::max(slice, of(cells, u) * of(cells, v));
    }
    const std::uint64_t lines = settings.oversampling > 1 ? 8 : 2;
    return pairs * 5 / 4 + slice * 6 + of(cells, 0) * of(cells, 1) * of(cells, 2) * lines;
}

} // namespace

std::uint64_t extinction_bytes(Vec3i volume_size, const VisibilitySettings& settings)
{
    return ExtinctionGrid::bytes_needed(level_size(volume_size, settings));
}

std::uint64_t sweep_scratch_bytes(Vec3i volume_size, const VisibilitySettings& settings, int threads)
{
    const Vec3i size = level_size(volume_size, settings), cells = VisibilityGrid::cells_of(volume_size, settings.cell);
    const auto directions =
        static_cast<std::size_t>(settings.directions) * static_cast<std::size_t>(settings.directions);
    const std::uint64_t lines = largest_sweep_group(size, cells, settings, directions, threads);
    return static_cast<std::uint64_t>(threads) *
           (lines * sweep_pair_bytes(size, cells) + thread_bytes(size, cells, settings));
}

} // namespace lumisweep
