#include "lumisweep/render/session_limits.h"

#include <algorithm>

#include <tbb/task_arena.h>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/visibility/live_visibility.h"
#include "lumisweep/visibility/sweep_memory.h"
#include "lumisweep/volume/majorant_grid.h"

namespace lumisweep {

namespace {

std::size_t count(const Vec3i& cells)
{
    return static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z);
}

void validate(const SessionInput& input)
{
    require(input.volume != nullptr && input.volume->voxel_count() > 0, "volume: is missing");
    require(input.environment != nullptr, "environment: is missing");
    input.camera.validate();
    input.image.validate();
    input.render.validate();
    input.visibility.validate();
    validate_extinction(*input.volume, input.transfer_function);
    const std::size_t cells = count(VisibilityGrid::cells_of(input.volume->size(), input.visibility.cell));
    JointGrid::require_indexable(cells, input.visibility.directions);
}

/// The film and the image that is written.
std::uint64_t image_bytes(const ImageSettings& image)
{
    constexpr std::uint64_t layers = 14;
    return Film::bytes_needed(image.width, image.height) +
           static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) * layers * sizeof(float);
}

} // namespace

/// Distances along a ray are kept in single precision: across the volume's diagonal a rounding is 1e-7 of it. Free
/// flights must be several times longer than that, else the density of tentative collisions is off, and finally
/// tracking stands still. At the limit they are about ten roundings long and the density is right to 0.1 %.
void validate_extinction(const ScalarGrid& volume, const TransferFunction& transfer_function)
{
    constexpr double max_depth = 1e6;
    double extinction = 0.0;
    for (const TransferPoint& p : transfer_function.points())
        extinction = std::max(extinction, p.extinction * transfer_function.extinction_scale());
    const Vec3i n = volume.size();
    const auto& column = volume.world_from_voxel().column;
    double diagonal = 0.0;
    for (const double sy : {-1.0, 1.0}) {
        for (const double sz : {-1.0, 1.0})
            diagonal = std::max(diagonal, length(column[0] * n.x + column[1] * (sy * n.y) + column[2] * (sz * n.z)));
    }
    require(
        extinction * diagonal <= max_depth,
        "transfer_function: extinction {:.3g} over a volume of {:.3g} is an optical depth of {:.3g}, above {:g} (lower "
        "transfer_function.extinction_scale; is the extinction in 1/world unit?)",
        extinction, diagonal, extinction * diagonal, max_depth);
}

void validate_with_memory(const SessionInput& input, SweepMode mode, int background_threads, std::uint64_t holds)
{
    validate(input);
    const std::uint64_t needed = Session::memory_needed(input.volume->size(), input.image, input.render.strategy,
                                                        input.visibility, mode, background_threads);
    require_memory(needed - std::min(needed, holds), "rendering this scene",
                   "a larger visibility.cell, fewer visibility.directions or a smaller image need less");
}

void validate_with_device(const SessionInput& input)
{
    validate(input);
    require_memory(image_bytes(input.image), "rendering this scene", "a smaller image needs less");
}

std::uint64_t Session::memory_needed(const Vec3i& volume_size, const ImageSettings& image, Strategy strategy,
                                     const VisibilitySettings& visibility, SweepMode mode, int background_threads)
{
    std::uint64_t bytes = image_bytes(image);
    bytes += BoundsGrid::bytes_needed(volume_size) + MajorantGrid::bytes_needed(volume_size);
    if (strategy == Strategy::uniform || strategy == Strategy::environment)
        return bytes;
    const std::size_t cells = count(VisibilityGrid::cells_of(volume_size, visibility.cell));
    const std::uint64_t joint = JointGrid::bytes_needed(cells, visibility.directions);
    const int threads = mode == SweepMode::in_background ? background_threads : tbb::this_task_arena::max_concurrency();
    const std::uint64_t sweeping =
        extinction_bytes(volume_size, visibility) + sweep_scratch_bytes(volume_size, visibility, threads);
    bytes += VisibilityGrid::bytes_needed(cells, visibility.directions);
    if (mode == SweepMode::in_background)
        return bytes + LiveVisibility::spare_bytes(cells, visibility.directions, threads) + sweeping + joint;
    return bytes + std::max(sweeping, joint); // where memory is short the old joint grid gives way to sweeps
}

} // namespace lumisweep
