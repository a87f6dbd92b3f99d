#include "lumisweep/backends/cuda/device_sweep.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "lumisweep/base/cancelled.h"
#include "lumisweep/visibility/sweep_filter.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// A batch's memory: enough for all lines of 8 × 8 directions on a grid of 128³ cells, which keep the device busy.
constexpr std::uint64_t most_batch_bytes = std::uint64_t{512} << 20;

std::size_t size_of(int n) { return static_cast<std::size_t>(n); }

bool equal(const Affine3d& a, const Affine3d& b) { return a.column == b.column && a.offset == b.offset; }

} // namespace

struct DeviceSweep::Memory {
    /// Elements that one line needs.
    struct Needs {
        std::size_t slices, cells, tiles, tau, totals, turned, averaged;
    };
    int most_cells, most_tiles;
    std::size_t cell_stride;
    Needs needs;
    DeviceArray<SliceView> slices;
    DeviceArray<CellPlace> places;
    DeviceArray<CellSides> sides;
    DeviceArray<BoxScales> scales;
    DeviceArray<std::int32_t> tile_begin, totals;
    DeviceArray<float> tau;
    DeviceArray<std::uint8_t> turned, averaged;
    DeviceArray<std::uint32_t> sums;

    Memory(const DeviceSweepPlan& plan, const DeviceVisibility& grid, int lines_a_texel)
        : most_cells(std::max({grid.cells.x, grid.cells.y, grid.cells.z})),
          most_tiles(std::max(plan.most_tiles_u(), plan.most_tiles_v())), cell_stride(grid.stride)
    {
        const std::size_t x = size_of(grid.cells.x), y = size_of(grid.cells.y), z = size_of(grid.cells.z);
        const auto pitch = [](int n) { return size_of(SweepScratch::tau_pitch(n)); };
        needs.slices = size_of(most_cells);
        needs.cells = 2 * needs.slices * needs.slices;
        needs.tiles = 2 * needs.slices * size_of(most_tiles + 1);
        needs.tau = std::max(y * z * pitch(grid.cells.x), x * z * pitch(grid.cells.y));
        needs.totals = plan.most_rays();
        needs.turned = plan.along_x() ? 2 * cell_stride : 0;
        needs.averaged = lines_a_texel > 1 ? 2 * cell_stride : 0;
    }

    std::uint64_t bytes_of_line() const
    {
        return needs.slices * sizeof(SliceView) +
               needs.cells * (sizeof(CellPlace) + sizeof(CellSides) + 2 * sizeof(BoxScales)) +
               (needs.tiles + needs.totals) * sizeof(std::int32_t) + needs.tau * sizeof(float) + needs.turned +
               needs.averaged;
    }

    /// Texels whose lines are of several batches have sums to keep.
    void allocate(int lines, bool keeps_sums)
    {
        constexpr const char* what = "working memory for sweeps";
        const std::size_t n = size_of(lines);
        slices.resize(n * needs.slices, what);
        places.resize(n * needs.cells, what);
        sides.resize(n * needs.cells, what);
        scales.resize(n * 2 * needs.cells, what);
        tile_begin.resize(n * needs.tiles, what);
        tau.resize(n * needs.tau, what);
        totals.resize(n * needs.totals, what);
        turned.resize(n * needs.turned, what);
        averaged.resize(n * needs.averaged, what);
        sums.resize(keeps_sums ? cell_stride : 0, what);
    }

    SweepScratch view()
    {
        return {most_cells,    most_tiles,        slices.data(),   places.data(), sides.data(),
                scales.data(), tile_begin.data(), tau.data(),      needs.tau,     totals.data(),
                needs.totals,  turned.data(),     averaged.data(), sums.data(),   cell_stride};
    }
};

DeviceSweep::DeviceSweep() = default;
DeviceSweep::~DeviceSweep() = default;

void DeviceSweep::release_memory()
{
    shape_.reset();
    plan_.reset();
    memory_.reset();
}

bool DeviceSweep::Shape::operator==(const Shape& other) const
{
    return volume_size == other.volume_size && size == other.size && mip_level == other.mip_level &&
           equal(world_from_voxel, other.world_from_voxel) && settings == other.settings;
}

bool DeviceSweep::sweep(DeviceVisibility& grid, const DeviceExtinction& extinction, const VisibilitySettings& settings,
                        const Stream& stream, const std::atomic<bool>* cancel)
{
    check_sweep(grid.cells, grid.directions_per_side, extinction.volume_size, extinction.mip_level, settings);
    voxel_steps_ = 0;
    if (is_cancelled(cancel))
        return false;
    if (!(extinction.scale > 0.0F)) {
        fill_on_device(grid.stored.data(), 255, grid.stored.bytes(), stream);
        return true;
    }
    Shape shape{extinction.volume_size, extinction.size, extinction.world_from_voxel, extinction.mip_level, settings};
    shape.settings.epsilon = VisibilitySettings{}.epsilon; // not the sweep's
    if (shape_ != shape)
        plan(shape, grid, stream);
    for (int batch = 0, first_line = 0; first_line < plan_->line_count(); ++batch, first_line += batch_lines_) {
        Event& end = batch_ends_[batch % 2];
        if (cancel != nullptr && batch >= 2)
            end.wait();
        if (is_cancelled(cancel))
            return false;
        sweep_batch(grid, extinction, first_line, stream);
        end.record(stream);
    }
    voxel_steps_ = plan_->voxel_steps();
    return true;
}

void DeviceSweep::plan(const Shape& shape, const DeviceVisibility& grid, const Stream& stream)
{
    shape_.reset();
    plan_.reset();
    memory_.reset();
    const VisibilitySettings& settings = shape.settings;
    const SweepLevel level(shape.volume_size, shape.world_from_voxel, shape.mip_level, shape.size, grid.cells);
    plan_ = std::make_unique<DeviceSweepPlan>(level, settings, stream);
    tan_beta_ = std::tan(filter_angle(settings.filter, settings.directions));
    memory_ = std::make_unique<Memory>(*plan_, grid, settings.oversampling);

    // Whole texels, or one's lines in equal parts; as few batches as the memory allows, and these alike.
    const int lines = plan_->line_count(), of_texel = settings.oversampling;
    const std::uint64_t budget = std::min(most_batch_bytes, free_device_memory() / 2);
    const int fitting = static_cast<int>(
        std::clamp<std::uint64_t>(budget / memory_->bytes_of_line(), 1, static_cast<std::uint64_t>(lines)));
    if (const int texels_fitting = fitting / of_texel; texels_fitting > 0) {
        const int texels = lines / of_texel;
        const int batches = (texels + texels_fitting - 1) / texels_fitting;
        batch_lines_ = (texels + batches - 1) / batches * of_texel;
    } else {
        batch_lines_ = static_cast<int>(std::bit_floor(static_cast<unsigned>(fitting)));
    }
    memory_->allocate(batch_lines_, batch_lines_ < of_texel);
    shape_ = shape;
}

void DeviceSweep::sweep_batch(DeviceVisibility& grid, const DeviceExtinction& extinction, int first_line,
                              const Stream& stream)
{
    const int of_texel = shape_->settings.oversampling;
    const SweepBatch batch{plan_->view(),
                           memory_->view(),
                           first_line,
                           std::min(batch_lines_, plan_->line_count() - first_line),
                           plan_->most_tiles_u(),
                           plan_->most_tiles_v()};
    const SweepTarget target{of_texel > 1 ? nullptr : grid.stored.data(), grid.stride};
    place_cells(batch, static_cast<double>(extinction.scale), tan_beta_, stream);
    march_rays(batch, {extinction.rows_along_x(), extinction.rows_along_y(), extinction.size}, stream);
    make_visible(batch, stream);
    store_visible(batch, target, stream);
    if (plan_->along_x())
        turn_visible(batch, target, grid.cells, stream);
    if (of_texel > 1)
        average_lines(batch,
                      {of_texel, std::min(of_texel, batch_lines_), first_line % of_texel == 0,
                       (first_line + batch.line_count) % of_texel == 0, grid.stored.data(), grid.stride},
                      stream);
}

} // namespace lumisweep::LUMISWEEP_CUDA
