#include "lumisweep/visibility/sweep_memory.h"

#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_plan.h"

namespace lumisweep {

namespace {

Vec3i level_size(Vec3i volume_size, const VisibilitySettings& settings)
{
    const int level = sweep_mip_level(volume_size, settings.rays);
    const auto halved = [&](int side) { return static_cast<int>((std::int64_t{side} + (1 << level) - 1) >> level); };
    return {halved(volume_size.x), halved(volume_size.y), halved(volume_size.z)};
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
    return static_cast<std::uint64_t>(threads) * largest_sweep_group(size, cells, directions, threads) *
           sweep_pair_bytes(size, cells);
}

} // namespace lumisweep
