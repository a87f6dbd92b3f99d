// Volumes in the device's memory: the one that is rendered, and the next of a time series on its way.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/render/background_task.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Voxels as ScalarGrid lays them out, so that GridView is the same on either side.
class DeviceVolume {
public:
    /// Copies the voxels, unless prefetch() has. They are there when this returns, after what `stream` does with the
    /// ones before.
    void set(std::shared_ptr<const ScalarGrid> volume, const Stream& stream);
    /// Begins to copy into memory of its own, beside what the device does; the volume before that is dropped. Without
    /// memory for it set() copies later.
    void prefetch(std::shared_ptr<const ScalarGrid> volume);

    const std::shared_ptr<const ScalarGrid>& volume() const { return volume_; }
    const void* voxels() const { return voxels_.data(); }
    std::uint64_t bytes() const { return voxels_.bytes() + next_voxels_.bytes(); }

private:
    /// False when cancelled.
    bool copy(std::byte* to, const ScalarGrid& volume, const std::atomic<bool>* cancel);

    std::shared_ptr<const ScalarGrid> volume_, next_;
    DeviceArray<std::byte> voxels_, next_voxels_;
    PinnedArray<std::byte> stage_[2]; ///< through which voxels go
    Event staged_[2];
    Stream copies_;
    BackgroundTask prefetching_; // last: it uses the others
};

} // namespace lumisweep::LUMISWEEP_CUDA
