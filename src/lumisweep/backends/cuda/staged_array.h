// Small arrays that the host replaces on the device while the device is at work.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lumisweep/backends/cuda/device.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// An array on the device that is filled from page-locked memory of its own, so the host waits for nothing but the
/// upload before. Memory only grows: giving it back would wait for all of the device's work.
template <class T>
class StagedArray {
public:
    /// In the order of the stream; `from` may go at once.
    void upload(std::span<const T> from, const char* what, const Stream& stream)
    {
        copied_.wait();
        if (array_.size() < from.size()) {
            const std::size_t room = std::bit_ceil(from.size());
            array_.resize(room, what);
            staged_ = PinnedArray<T>(room);
        }
        std::copy(from.begin(), from.end(), staged_.data());
        copy_to_device(array_.data(), staged_.data(), from.size_bytes(), stream);
        copied_.record(stream);
    }
    const T* data() const { return array_.data(); }
    std::uint64_t bytes() const { return array_.bytes(); }

private:
    DeviceArray<T> array_;
    PinnedArray<T> staged_;
    Event copied_;
};

} // namespace lumisweep::LUMISWEEP_CUDA
