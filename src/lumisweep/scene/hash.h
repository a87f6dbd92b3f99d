// A 64-bit hash of bytes, for checksums and fingerprints: it meets accidents, not forgers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace lumisweep {

/// Depends on `seed` and on every byte; about 8 bytes a nanosecond.
std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed = 0);

/// 16 hexadecimal digits.
std::string hex(std::uint64_t value);

} // namespace lumisweep
