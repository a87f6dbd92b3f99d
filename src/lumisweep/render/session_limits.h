// What a session refuses before it takes any memory.
#pragma once

#include "lumisweep/render/session.h"

namespace lumisweep {

/// Throws Error unless the medium's free flights are long enough to be tracked.
void validate_extinction(const ScalarGrid& volume, const TransferFunction& transfer_function);

/// Throws Error unless all of it makes sense and what it needs fits into the memory that is left and the bytes that the
/// session already `holds` for the same ends.
void validate_with_memory(const SessionInput& input, SweepMode mode, int background_threads, std::uint64_t holds);

/// Likewise where a device has all but the film.
void validate_with_device(const SessionInput& input);

} // namespace lumisweep
