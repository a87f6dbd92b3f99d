// How long work is told to end early: by a flag that somebody else sets, or none.
#pragma once

#include <atomic>

namespace lumisweep {

/// Relaxed: the flag says nothing of other memory, and may be asked in inner loops.
inline bool is_cancelled(const std::atomic<bool>* cancel)
{
    return cancel != nullptr && cancel->load(std::memory_order_relaxed);
}

} // namespace lumisweep
