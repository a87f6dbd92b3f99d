// A device in the host's memory: what tests set and look at.
#pragma once

#include <cstdint>

namespace lumisweep::test {

/// Bytes that the emulated device has from now on; what is taken already counts.
void set_emulated_memory(std::uint64_t bytes);
/// Fails the allocation after so many more, once; a negative number fails none.
void fail_allocation_after(int more);
/// Bytes that arrays on the device hold now.
std::uint64_t emulated_memory_taken();
/// Bytes copied from the host to the device so far.
std::uint64_t bytes_uploaded();

} // namespace lumisweep::test
