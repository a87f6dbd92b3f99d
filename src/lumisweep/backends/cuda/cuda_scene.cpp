#include "lumisweep/backends/cuda/cuda_scene.h"

#include <algorithm>
#include <utility>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/render/session.h"
#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_plan.h"
#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

/// Pieces of the device's memory that the runtime and the allocator take for themselves.
constexpr std::uint64_t reserve = std::uint64_t{1} << 26;

std::uint64_t grid_bytes(const SessionInput& input)
{
    if (input.render.strategy == Strategy::uniform || input.render.strategy == Strategy::environment)
        return 0;
    const Vec3i& size = input.volume->size();
    const VisibilitySettings& settings = input.visibility;
    const Vec3i cells = VisibilityGrid::cells_of(size, settings.cell);
    const std::size_t count =
        static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z);
    const auto directions =
        static_cast<std::uint64_t>(settings.directions) * static_cast<std::uint64_t>(settings.directions);
    const int level = sweep_mip_level(size, settings.rays);
    const auto side = [&](int voxels) { return (voxels + (1 << level) - 1) >> level; };
    // Rays and optical depths of one line, and where and how its cells look up.
    const auto longest = static_cast<std::uint64_t>(std::max({cells.x, cells.y, cells.z}));
    const std::uint64_t one_line =
        2 * sweep_pair_bytes({side(size.x), side(size.y), side(size.z)}, cells) + 96 * longest * longest;
    return DeviceExtinction::bytes_needed(size, level) + count * directions +
           JointGrid::bytes_needed(count, settings.directions) + one_line;
}

} // namespace

void CudaScene::require_memory(const SessionInput& input)
{
    const std::uint64_t of_grids = grid_bytes(input);
    needed_ = reserve + input.volume->bytes() + BoundsGrid::bytes_needed(input.volume->size()) +
              MajorantGrid::bytes_needed(input.volume->size()) + input.environment->bytes() +
              PassQueue::bytes_needed(input.image.width, input.image.height, passes_.multiprocessors()) + of_grids;
    // Grids that this input does not use stay for one that does.
    const std::uint64_t unused = of_grids == 0 ? visibility_.stored.bytes() + joint_.bytes() + extinction_.bytes() : 0;
    const std::uint64_t held = held_bytes() - unused;
    if (needed_ > free_device_memory() + held) {
        volume_.release_next();
        sweep_.release_memory();
    }
    const std::uint64_t available = free_device_memory() + held;
    require(needed_ <= available,
            "device cuda: this scene needs {} of the GPU's memory and {} are there (a larger visibility.cell, fewer "
            "visibility.directions or a smaller image need less, or use --device cpu)",
            format_bytes(needed_), format_bytes(available));
}

std::uint64_t CudaScene::held_bytes() const
{
    const Bytes held = bytes();
    return held.volume + held.visibility + held.joint + held.environment + held.film + held.majorants +
           extinction_.bytes() + classify_.bytes();
}

void CudaScene::prefetch(std::shared_ptr<const ScalarGrid> volume)
{
    volume_.prefetch(std::move(volume), needed_ - std::min(needed_, held_bytes()));
}

void CudaScene::set_volume(std::shared_ptr<const ScalarGrid> volume)
{
    volume_.set(std::move(volume), stream_);
    bounds_.build(volume_.voxels(), *volume_.volume(), stream_);
    stream_.wait();
}

void CudaScene::set_transfer_function(const TransferFunction& transfer_function)
{
    transfer_function_ = transfer_function;
    tables_.upload(transfer_function_, stream_);
    majorants_.build(bounds_, tables_.points(), stream_);
    stream_.wait();
}

void CudaScene::set_environment(std::shared_ptr<const Environment> environment)
{
    light_ = std::move(environment);
    environment_.upload(*light_, stream_);
}

bool CudaScene::sweep(const VisibilitySettings& settings, const std::atomic<bool>* cancel, SessionStats& stats)
{
    const ScalarGrid& volume = *volume_.volume();
    {
        const Stopwatch watch(stats.classify_s);
        classify_.classify(extinction_, volume_.voxels(), volume, bounds_.raw_range(), transfer_function_, tables_,
                           sweep_mip_level(volume.size(), settings.rays), stream_);
        stream_.wait();
    }
    const Stopwatch watch(stats.sweep_s);
    double sweep_s = 0.0;
    bool ended = false;
    {
        const Stopwatch of_sweep(sweep_s);
        visibility_.resize(VisibilityGrid::cells_of(volume.size(), settings.cell), settings.directions);
        swept_size_ = volume.size();
        voxels_per_cell_ = settings.cell;
        looked_at_is_old_ = true;
        ended = sweep_.sweep(visibility_, extinction_, settings, stream_, cancel);
        stream_.wait();
    }
    stats.last_sweep = SweepStats();
    stats.last_sweep.total_s = sweep_s;
    stats.last_sweep.voxel_steps = sweep_.voxel_steps();
    stats.last_sweep.mip_level = extinction_.mip_level;
    stats.last_sweep.rays = std::max({extinction_.size.x, extinction_.size.y, extinction_.size.z});
    return ended;
}

void CudaScene::build_joint(JointFactor factor, double epsilon)
{
    passes_.draw_pending(stream_); // with the product that they were begun with
    joint_.build(visibility_, volume_.volume()->size(), *light_, factor, epsilon, stream_);
    stream_.wait();
}

const VisibilityGrid& CudaScene::visibility()
{
    if (looked_at_is_old_ && visibility_.cell_count > 0) {
        looked_at_ = VisibilityGrid(swept_size_, voxels_per_cell_, visibility_.directions_per_side);
        visibility_.download(looked_at_, stream_);
        looked_at_is_old_ = false;
    }
    return looked_at_;
}

void CudaScene::set_visibility(VisibilityGrid grid)
{
    visibility_.upload(grid, stream_);
    looked_at_ = std::move(grid);
    looked_at_is_old_ = false;
}

PassEnd CudaScene::render_pass(const SceneView& scene, std::int64_t sample, const std::atomic<bool>* cancel)
{
    SceneView on_device = scene;
    const ScalarGrid& volume = *volume_.volume();
    on_device.voxels = volume_.voxels();
    on_device.transfer_function = tables_.view(volume.slope(), volume.intercept());
    on_device.majorants = majorants_.view();
    on_device.directions.environment = environment_.view();
    on_device.directions.joint = joint_.view();
    return passes_.take(on_device, sample, cancel, stream_);
}

DeviceScene::Bytes CudaScene::bytes() const
{
    Bytes bytes;
    bytes.volume = volume_.bytes();
    bytes.visibility = visibility_.stored.bytes();
    bytes.joint = joint_.bytes();
    bytes.environment = environment_.bytes();
    bytes.film = passes_.bytes();
    bytes.majorants = majorants_.bytes() + bounds_.bytes();
    return bytes;
}

} // namespace lumisweep::LUMISWEEP_CUDA
