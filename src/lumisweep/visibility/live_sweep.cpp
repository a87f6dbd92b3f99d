#include "lumisweep/visibility/live_sweep.h"

#include <algorithm>
#include <vector>

#include <tbb/task_arena.h>

#include "lumisweep/base/stopwatch.h"

namespace lumisweep {

namespace {

/// What of the groups is wanted.
std::vector<std::vector<int>> wanted_of(std::vector<std::vector<int>> groups, const std::vector<int>& directions)
{
    if (!directions.empty())
        for (std::vector<int>& group : groups)
            std::erase_if(group, [&](int d) { return std::ranges::count(directions, d) == 0; });
    return groups;
}

/// A group for each thread, as far as the spare slots go; larger groups are cut.
std::vector<std::vector<int>> batches(const std::vector<std::vector<int>>& groups, int threads, std::size_t slots)
{
    std::vector<std::vector<int>> result;
    int groups_in_last = threads;
    for (const std::vector<int>& group : groups)
        for (std::size_t begin = 0; begin < group.size(); begin += slots) {
            const std::span<const int> part = std::span(group).subspan(begin, std::min(slots, group.size() - begin));
            if (groups_in_last >= threads || result.back().size() + part.size() > slots) {
                result.emplace_back();
                groups_in_last = 0;
            }
            result.back().insert(result.back().end(), part.begin(), part.end());
            ++groups_in_last;
        }
    return result;
}

bool sweep_all(LiveVisibility& grid, const LiveSweepInput& input, const std::atomic<bool>& cancel,
               LiveSweepStats& stats)
{
    ExtinctionGrid extinction;
    {
        const Stopwatch watch(stats.classify_s);
        extinction = classify(*input.volume, input.range, input.transfer_function,
                              sweep_mip_level(input.volume->size(), input.visibility.rays),
                              ExtinctionLayouts::with_transposed, &cancel);
    }
    if (cancel.load(std::memory_order_relaxed))
        return false;
    const Stopwatch watch(stats.sweep_s);
    for (const std::vector<int>& batch :
         batches(wanted_of(sweep_groups(extinction, input.visibility), input.directions), input.threads,
                 static_cast<std::size_t>(grid.spare_slots()))) {
        if (cancel.load(std::memory_order_relaxed))
            return false;
        VisibilityGrid& staged = grid.stage(batch);
        stats.sweep += sweep_visibility(staged, extinction, input.visibility, batch, &cancel);
        if (cancel.load(std::memory_order_relaxed))
            return false;
        grid.publish();
    }
    return true;
}

} // namespace

bool sweep_live(LiveVisibility& grid, const LiveSweepInput& input, const std::atomic<bool>& cancel,
                LiveSweepStats& stats)
{
    tbb::task_arena arena(input.threads);
    return arena.execute([&] { return sweep_all(grid, input, cancel, stats); });
}

} // namespace lumisweep
