// Memory: what may still be taken, and refusing before it is taken.
#pragma once

#include <cstdint>
#include <string>

namespace lumisweep {

/// Bytes that this process can still take without swapping: the smaller of the kernel's MemAvailable, what is left
/// under the control group's limit, and what is left under RLIMIT_AS (ulimit -v). Returns UINT64_MAX where none can be
/// read.
std::uint64_t available_memory();

/// Throws Error naming `what`, the bytes needed, those available and `mend` unless `bytes` fit into
/// available_memory() with a reserve of 5 %.
void require_memory(std::uint64_t bytes, const std::string& what, const std::string& mend);

/// The peak resident set size of this process in bytes; 0 where it cannot be read.
std::uint64_t peak_resident_memory();

/// "1.5 GiB" and the like.
std::string format_bytes(std::uint64_t bytes);

} // namespace lumisweep
