#include "lumisweep/visibility/sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

#include "lumisweep/base/aligned.h"
#include "lumisweep/base/cancelled.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/visibility/sweep_march.h"
#include "lumisweep/visibility/sweep_pair.h"
#include "lumisweep/visibility/sweep_plan.h"

namespace lumisweep {
namespace {

MarchedLevel level_of(const ExtinctionGrid& extinction, Vec3i cells)
{
    return {{extinction.volume_size, extinction.world_from_voxel, extinction.mip_level, extinction.size, cells},
            extinction.stored.data(),
            extinction.transposed.data(),
            extinction.filled.data(),
            extinction.filled_transposed.data(),
            static_cast<double>(extinction.scale)};
}

void check(const VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
           std::span<const int> directions)
{
    require(!extinction.stored.empty(), "visibility sweep: the volume has not been classified");
    check_sweep(grid.cells(), grid.directions_per_side(), extinction.volume_size, extinction.mip_level, settings);
    for (const int d : directions)
        require(d >= 0 && d < grid.direction_count(), "visibility sweep: direction {} is not in 0 to {}", d,
                grid.direction_count() - 1);
}

int threads_of_arena() { return tbb::this_task_arena::max_concurrency(); }

std::vector<SweepTask> plan(const MarchedLevel& level, const VisibilitySettings& settings,
                            std::span<const int> directions, int threads)
{
    std::vector<int> all;
    if (directions.empty()) {
        all.resize(static_cast<std::size_t>(settings.directions) * static_cast<std::size_t>(settings.directions));
        std::iota(all.begin(), all.end(), 0);
        directions = all;
    }
    return plan_sweeps(level.level_from_world, settings, directions,
                       largest_sweep_group(level.size, level.cells, settings, directions.size(), threads));
}

/// One thread's working memory and what it did.
class Worker {
public:
    Worker(const SweepKernels& kernels, const MarchedLevel& level, const VisibilitySettings& settings,
           const std::atomic<bool>* cancel)
        : level_(level), lines_per_texel_(settings.oversampling), cancel_(cancel), march_(level, kernels, cancel),
          visibility_(level, kernels, std::tan(filter_angle(settings.filter, settings.directions)), cancel)
    {
    }

    void run(const SweepTask& task, VisibilityGrid& grid)
    {
        if (lines_per_texel_ > 1)
            return run_averaged(task, grid);
        const SweepGroup& group = task.groups.front();
        if (!march(group))
            return;
        const auto target = [&](int d) { return d >= 0 ? grid.direction(d) : nullptr; };
        for (std::size_t i = 0; i < group.size(); ++i)
            if (!visibility_.write(planes_[i], target(group[i].towards_low), target(group[i].towards_high), stats_))
                return;
    }

    const SweepStats& stats() const { return stats_; }

private:
    bool march(const SweepGroup& group)
    {
        {
            const ProcessorStopwatch watch(stats_.layout_s);
            if (planes_.size() < group.size())
                planes_.resize(group.size());
            for (std::size_t i = 0; i < group.size(); ++i) {
                if (is_cancelled(cancel_)) // many planes with many small cells take tens of milliseconds
                    return false;
                planes_[i].start(level_, group[i].w_world);
            }
        }
        return march_.run(std::span(planes_).first(group.size()), stats_);
    }

    /// Averages the lines of two opposite texels.
    void run_averaged(const SweepTask& task, VisibilityGrid& grid)
    {
        const std::vector<int> directions = task.directions();
        const std::size_t cells = grid.cell_count();
        std::vector<AlignedArray<std::uint16_t>> sums;
        for (std::size_t i = 0; i < directions.size(); ++i) {
            if (is_cancelled(cancel_)) // setting the sums of many small cells to zero takes tens of milliseconds
                return;
            sums.emplace_back(cells);
        }
        AlignedArray<std::uint8_t> low(cells, Contents::uninitialised), high(cells, Contents::uninitialised);
        const auto add = [&](int direction, const AlignedArray<std::uint8_t>& line) {
            for (std::size_t i = 0; i < directions.size(); ++i)
                if (directions[i] == direction)
                    std::transform(
                        line.begin(), line.end(), sums[i].begin(), sums[i].begin(),
                        [](std::uint8_t v, std::uint16_t sum) { return static_cast<std::uint16_t>(sum + v); });
        };
        for (const SweepGroup& group : task.groups) {
            if (!march(group))
                return;
            for (std::size_t i = 0; i < group.size(); ++i) {
                const SweepPair& pair = group[i];
                if (!visibility_.write(planes_[i], pair.towards_low >= 0 ? low.data() : nullptr,
                                       pair.towards_high >= 0 ? high.data() : nullptr, stats_))
                    return;
                add(pair.towards_low, low);
                add(pair.towards_high, high);
            }
        }
        const int lines = lines_per_texel_;
        for (std::size_t i = 0; i < directions.size() && !is_cancelled(cancel_); ++i)
            std::transform(sums[i].begin(), sums[i].end(), grid.direction(directions[i]),
                           [&](std::uint16_t sum) { return static_cast<std::uint8_t>((sum + lines / 2) / lines); });
    }

    const MarchedLevel& level_;
    int lines_per_texel_;
    const std::atomic<bool>* cancel_;
    GroupMarch march_;
    PairVisibility visibility_;
    std::vector<RayPlane> planes_;
    SweepStats stats_;
};

} // namespace

SweepStats& SweepStats::operator+=(const SweepStats& part)
{
    layout_s += part.layout_s;
    march_s += part.march_s;
    lookup_s += part.lookup_s;
    filter_s += part.filter_s;
    total_s += part.total_s;
    voxel_steps += part.voxel_steps;
    bytes_read += part.bytes_read;
    mip_level = part.mip_level;
    rays = part.rays;
    return *this;
}

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

std::vector<std::vector<int>> sweep_groups(const ExtinctionGrid& extinction, const VisibilitySettings& settings)
{
    const MarchedLevel level = level_of(extinction, VisibilityGrid::cells_of(extinction.volume_size, settings.cell));
    std::vector<std::vector<int>> groups;
    for (const SweepTask& task : plan(level, settings, {}, 1))
        groups.push_back(task.directions());
    return groups;
}

SweepStats sweep_visibility(VisibilityGrid& grid, const ExtinctionGrid& extinction, const VisibilitySettings& settings,
                            std::span<const int> directions, const std::atomic<bool>* cancel)
{
    return sweep_visibility_with(sweep_kernels(), grid, extinction, settings, directions, cancel);
}

SweepStats sweep_visibility_with(const SweepKernels& kernels, VisibilityGrid& grid, const ExtinctionGrid& extinction,
                                 const VisibilitySettings& settings, std::span<const int> directions,
                                 const std::atomic<bool>* cancel)
{
    const auto begin = std::chrono::steady_clock::now();
    check(grid, extinction, settings, directions);

    const MarchedLevel marched = level_of(extinction, grid.cells());
    const std::vector<SweepTask> tasks = plan(marched, settings, directions, threads_of_arena());
    for (const SweepTask& task : tasks)
        for (const SweepGroup& group : task.groups)
            require(!extinction.transposed.empty() ||
                        SweepLine(marched.level_from_world, group.front().w_world).axis != 0,
                    "visibility sweep: a direction runs along x and needs the transposed layout (see "
                    "ExtinctionLayouts)");
    tbb::enumerable_thread_specific<Worker> worker_of_thread(
        [&] { return Worker(kernels, marched, settings, cancel); });
    parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
        if (is_cancelled(cancel))
            return;
        if (extinction.scale > 0.0F)
            worker_of_thread.local().run(tasks[i], grid);
        else
            for (const int d : tasks[i].directions())
                std::memset(grid.direction(d), 255, grid.cell_count());
    });

    SweepStats stats;
    for (const Worker& worker : worker_of_thread)
        stats += worker.stats();
    stats.mip_level = extinction.mip_level;
    stats.rays = std::max({marched.size.x, marched.size.y, marched.size.z});
    stats.total_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return stats;
}

} // namespace lumisweep
