#include "lumisweep/backends/cuda/device_volume.h"

#include <algorithm>
#include <cstring>

#include "lumisweep/base/parallel.h"

namespace lumisweep::LUMISWEEP_CUDA {

namespace {

constexpr std::size_t stage_bytes = std::size_t{16} << 20;
constexpr std::size_t piece_bytes = std::size_t{1} << 20; ///< that a thread copies at a time

} // namespace

void DeviceVolume::set(std::shared_ptr<const ScalarGrid> volume, const Stream& stream)
{
    if (volume == next_) {
        prefetching_.wait(nullptr);
        prefetching_.rethrow();
        next_.reset();
        stream.wait();
        std::swap(voxels_, next_voxels_);
    } else {
        prefetching_.stop();
        next_.reset();
        stream.wait();
        volume_.reset();
        voxels_.resize(volume->bytes(), "the volume");
        copy(voxels_.data(), *volume, nullptr);
    }
    volume_ = std::move(volume);
}

void DeviceVolume::prefetch(std::shared_ptr<const ScalarGrid> volume)
{
    prefetching_.stop();
    next_.reset();
    constexpr std::uint64_t reserve = std::uint64_t{1} << 28; // for what sweeps and films may yet take
    if (next_voxels_.bytes() < volume->bytes() && free_device_memory() < volume->bytes() + reserve)
        return;
    next_voxels_.resize(volume->bytes(), "the next volume");
    next_ = volume;
    prefetching_.start([this, volume = std::move(volume)](const std::atomic<bool>& cancelled) {
        copy(next_voxels_.data(), *volume, &cancelled);
    });
}

bool DeviceVolume::copy(std::byte* to, const ScalarGrid& volume, const std::atomic<bool>* cancel)
{
    for (PinnedArray<std::byte>& stage : stage_)
        if (stage.size() == 0)
            stage = PinnedArray<std::byte>(stage_bytes);
    const std::byte* from = volume.data();
    for (std::size_t at = 0, which = 0; at < volume.bytes(); at += stage_bytes, which = 1 - which) {
        if (cancel != nullptr && cancel->load(std::memory_order_relaxed)) {
            copies_.wait();
            return false;
        }
        const std::size_t count = std::min(stage_bytes, volume.bytes() - at);
        staged_[which].wait(); // what this stage held before has left
        parallel_for(std::size_t{0}, (count + piece_bytes - 1) / piece_bytes, [&](std::size_t piece) {
            const std::size_t first = piece * piece_bytes;
            std::memcpy(stage_[which].data() + first, from + at + first, std::min(piece_bytes, count - first));
        });
        copy_to_device(to + at, stage_[which].data(), count, copies_);
        staged_[which].record(copies_);
    }
    copies_.wait();
    return true;
}

} // namespace lumisweep::LUMISWEEP_CUDA
