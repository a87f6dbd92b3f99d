// Large copies between pageable memory of the host and the device, through page-locked memory.
#pragma once

#include <atomic>
#include <cstddef>

#include "lumisweep/backends/cuda/device.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// While one stage is on the bus, threads copy the other from or to where it belongs. For one caller at a time.
class StagedCopy {
public:
    /// Both wait until all is there. False when cancelled, with a part copied.
    bool upload(void* to, const void* from, std::size_t bytes, const Stream& stream,
                const std::atomic<bool>* cancel = nullptr);
    void download(void* to, const void* from, std::size_t bytes, const Stream& stream);

private:
    void take_memory();

    PinnedArray<std::byte> stage_[2];
    Event passed_[2]; ///< what the stage holds has come or gone
};

} // namespace lumisweep::LUMISWEEP_CUDA
