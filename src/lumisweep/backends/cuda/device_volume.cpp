#include "lumisweep/backends/cuda/device_volume.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceVolume::set(std::shared_ptr<const ScalarGrid> volume, const Stream& stream)
{
    const bool is_next = volume == next_;
    bool is_there = false;
    if (is_next) {
        prefetching_.wait(nullptr);
        is_there = arrived_.load();
    } else {
        prefetching_.stop();
    }
    next_.reset();
    stream.wait();
    volume_.reset(); // until the new one is there
    if (is_there) {
        std::swap(voxels_, next_voxels_);
    } else {
        voxels_.resize(volume->bytes(), "the volume");
        copy_.upload(voxels_.data(), volume->data(), volume->bytes(), copies_);
    }
    volume_ = std::move(volume);
}

void DeviceVolume::prefetch(std::shared_ptr<const ScalarGrid> volume, std::uint64_t spared)
{
    if (volume == next_ || volume == volume_)
        return;
    prefetching_.stop();
    next_.reset();
    const std::uint64_t bytes = volume->bytes();
    if (next_voxels_.bytes() != bytes && free_device_memory() + next_voxels_.bytes() < bytes + spared)
        return;
    next_voxels_.resize(bytes, "the next volume");
    next_ = volume;
    arrived_ = false;
    prefetching_.start([this, volume = std::move(volume)](const std::atomic<bool>& cancelled) {
        // What fails here is tried again, and reported, by set().
        arrived_ = copy_.upload(next_voxels_.data(), volume->data(), volume->bytes(), copies_, &cancelled);
    });
}

void DeviceVolume::release_next()
{
    prefetching_.stop();
    next_.reset();
    next_voxels_ = DeviceArray<std::byte>();
}

} // namespace lumisweep::LUMISWEEP_CUDA
