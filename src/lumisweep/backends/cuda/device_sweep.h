// Visibility sweeps on the device (visibility/sweep.h says what they compute), equal to the CPU's to the byte.
//
// Lines through the volume are swept in batches as large as the memory allows; a batch is a launch for each of the
// steps of sweep_kernels.h, in which all lines, tiles and slices go side by side.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "lumisweep/backends/cuda/device_extinction.h"
#include "lumisweep/backends/cuda/device_sweep_plan.h"
#include "lumisweep/backends/cuda/device_visibility.h"
#include "lumisweep/backends/cuda/sweep_kernels.h"
#include "lumisweep/visibility/settings.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Keeps what depends on the volume's shape and the settings, and the working memory, from sweep to sweep.
class DeviceSweep {
public:
    DeviceSweep();
    ~DeviceSweep();

    /// Puts the sweep of all directions of `grid` into the stream; the grid must be of the volume's geometry and the
    /// settings (DeviceVisibility::resize). When *cancel becomes true, returns false early: directions have their old
    /// V or their new. With `cancel`, the host goes no more than two batches ahead of the device.
    bool sweep(DeviceVisibility& grid, const DeviceExtinction& extinction, const VisibilitySettings& settings,
               const Stream& stream, const std::atomic<bool>* cancel = nullptr);

    /// Of the last sweep: rays × slices, as SweepStats counts them.
    std::uint64_t voxel_steps() const { return voxel_steps_; }
    /// Gives back the working memory that is kept for the next sweep.
    void release_memory();

private:
    /// What the plan depends on.
    struct Shape {
        Vec3i volume_size, size;
        Affine3d world_from_voxel;
        int mip_level;
        VisibilitySettings settings;

        bool operator==(const Shape& other) const;
    };
    void plan(const Shape& shape, const DeviceVisibility& grid, const Stream& stream);
    void sweep_batch(DeviceVisibility& grid, const DeviceExtinction& extinction, int first_line, const Stream& stream);

    std::optional<Shape> shape_;
    std::unique_ptr<DeviceSweepPlan> plan_;
    double tan_beta_ = 0.0;
    std::uint64_t voxel_steps_ = 0;

    struct Memory; ///< of a batch
    std::unique_ptr<Memory> memory_;
    int batch_lines_ = 0;
    Event batch_ends_[2];
};

} // namespace lumisweep::LUMISWEEP_CUDA
