// Volumes in the device's memory: the one that is rendered, and the next of a time series on its way.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/backends/cuda/staged_copy.h"
#include "lumisweep/render/background_task.h"
#include "lumisweep/volume/scalar_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// Voxels as ScalarGrid lays them out, so that GridView is the same on either side.
class DeviceVolume {
public:
    /// Copies the voxels, unless prefetch() has. They are there when this returns, after what `stream` does with the
    /// ones before.
    void set(std::shared_ptr<const ScalarGrid> volume, const Stream& stream);
    /// Begins to copy into memory of its own, beside what the device does; the volume before that is dropped. Where
    /// less than `spared` bytes would be left free, set() copies later.
    void prefetch(std::shared_ptr<const ScalarGrid> volume, std::uint64_t spared);
    /// Gives back the memory for it.
    void release_next();

    /// Null after set() has failed.
    const std::shared_ptr<const ScalarGrid>& volume() const { return volume_; }
    const void* voxels() const { return voxels_.data(); }
    std::uint64_t bytes() const { return voxels_.bytes(); }
    std::uint64_t bytes_of_next() const { return next_voxels_.bytes(); }

private:
    std::shared_ptr<const ScalarGrid> volume_, next_;
    DeviceArray<std::byte> voxels_, next_voxels_;
    StagedCopy copy_;
    Stream copies_;
    std::atomic<bool> arrived_{false}; // what is next is there
    BackgroundTask prefetching_;       // last: it uses the others
};

} // namespace lumisweep::LUMISWEEP_CUDA
