#include "lumisweep/visibility/sweep_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {
namespace {

/// The texel whose centre is opposite to that of `morton`, −1 if there is none (1 × 1 texels).
int opposite(int morton, int side)
{
    const Vec3d w = texel_direction(morton, side);
    const UV<double> uv = oct_from_direction(Vec3d{-w.x, -w.y, -w.z});
    const auto texel = [&](double x) { return std::clamp(static_cast<std::int32_t>(x * side), 0, side - 1); };
    const int found = morton_encode<std::int32_t>(texel(uv.u), texel(uv.v));
    return dot(w, texel_direction(found, side)) < -1.0 + 1e-9 ? found : -1;
}

/// The sweep's axis and the sign of the shear across rows.
using GroupKey = std::pair<int, bool>;

/// In as few parts as can be, of nearly equal size.
void append_parts(std::vector<SweepGroup>& parts, const SweepGroup& group, std::size_t largest)
{
    for (std::size_t first = 0; first < group.size();) {
        const std::size_t rest = group.size() - first, left = (rest + largest - 1) / largest;
        const auto begin = group.begin() + static_cast<std::ptrdiff_t>(first);
        first += (rest + left - 1) / left;
        parts.emplace_back(begin, group.begin() + static_cast<std::ptrdiff_t>(first));
    }
}

} // namespace

std::vector<int> SweepTask::directions() const
{
    std::vector<int> list;
    for (const SweepGroup& group : groups)
        for (const SweepPair& pair : group)
            for (const int d : {pair.towards_low, pair.towards_high})
                if (d >= 0 && std::find(list.begin(), list.end(), d) == list.end())
                    list.push_back(d);
    return list;
}

std::vector<SweepTask> plan_sweeps(const Affine3d& level_from_world, const VisibilitySettings& settings,
                                   std::span<const int> directions, std::size_t largest_group)
{
    const int n = settings.directions;
    const int lines_per_texel = settings.oversampling;
    const int lines_per_side = lines_per_texel == 1 ? 1 : lines_per_texel == 4 ? 2 : 4;
    std::vector<bool> wanted(static_cast<std::size_t>(n) * static_cast<std::size_t>(n), false);
    for (const int d : directions)
        wanted[static_cast<std::size_t>(d)] = true;

    std::vector<SweepTask> tasks;
    std::map<GroupKey, SweepGroup> shared; // without oversampling, over all texels
    for (int d = 0; d < n * n; ++d) {
        // Of two opposite texels the one with the lower index names the line, so that it is always the same.
        const int other = opposite(d, n);
        const bool named_by_other = other >= 0 && other < d;
        if (named_by_other ||
            !(wanted[static_cast<std::size_t>(d)] || (other >= 0 && wanted[static_cast<std::size_t>(other)])))
            continue;
        const auto target = [&](int direction) {
            return direction >= 0 && wanted[static_cast<std::size_t>(direction)] ? direction : -1;
        };
        std::map<GroupKey, SweepGroup> own;
        std::map<GroupKey, SweepGroup>& groups = lines_per_texel == 1 ? shared : own;
        for (int line = 0; line < lines_per_texel; ++line) {
            SweepPair pair;
            pair.w_world = texel_direction(d * lines_per_texel + line, n * lines_per_side);
            const SweepLine sweep(level_from_world, pair.w_world);
            pair.towards_low = target(sweep.towards_high_side ? other : d);
            pair.towards_high = target(sweep.towards_high_side ? d : other);
            groups[{sweep.axis, sweep.slope_v > 0.0}].push_back(pair);
        }
        if (lines_per_texel > 1) {
            SweepTask task;
            for (const auto& [key, group] : own)
                append_parts(task.groups, group, largest_group);
            tasks.push_back(std::move(task));
        }
    }
    for (const auto& [key, group] : shared) {
        std::vector<SweepGroup> parts;
        append_parts(parts, group, largest_group);
        for (SweepGroup& part : parts)
            tasks.push_back({{std::move(part)}});
    }
    std::stable_sort(tasks.begin(), tasks.end(), [](const SweepTask& a, const SweepTask& b) {
        return a.groups.front().size() > b.groups.front().size();
    });
    return tasks;
}

std::uint64_t sweep_pair_bytes(Vec3i level_size, Vec3i cells)
{
    const std::array<std::uint64_t, 3> side{static_cast<std::uint64_t>(level_size.x),
                                            static_cast<std::uint64_t>(level_size.y),
                                            static_cast<std::uint64_t>(level_size.z)};
    std::uint64_t rays = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        rays = std::max(rays, (side[(axis + 1) % 3] + side[axis] + 40) * (side[(axis + 2) % 3] + side[axis] + 8));
    const std::uint64_t cell_count =
        static_cast<std::uint64_t>(cells.x) * static_cast<std::uint64_t>(cells.y) * static_cast<std::uint64_t>(cells.z);
    // Rays; where cells look up along both axes; optical depths at the cells.
    return rays * 4 + cell_count * 4 +
           16 * (static_cast<std::uint64_t>(cells.x) * static_cast<std::uint64_t>(cells.y) +
                 static_cast<std::uint64_t>(cells.y) * static_cast<std::uint64_t>(cells.z) +
                 static_cast<std::uint64_t>(cells.z) * static_cast<std::uint64_t>(cells.x));
}

std::size_t largest_sweep_group(Vec3i level_size, Vec3i cells, const VisibilitySettings& settings,
                                std::size_t directions, int threads)
{
    // With oversampling a thread sweeps all lines of a texel, in however many groups.
    if (settings.oversampling > 1) {
        directions *= static_cast<std::size_t>(settings.oversampling);
        threads = 1;
    }
    constexpr std::size_t most = 6; // lines of one axis and shear at 8 × 8 directions
    constexpr std::uint64_t memory = std::uint64_t{256} << 20;
    const std::size_t fitting = static_cast<std::size_t>(memory / sweep_pair_bytes(level_size, cells));
    const std::size_t per_thread = directions / 2 / static_cast<std::size_t>(threads > 2 ? 2 * threads : threads);
    return std::clamp(std::min(fitting, per_thread), std::size_t{1}, most);
}

} // namespace lumisweep
