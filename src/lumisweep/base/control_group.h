// What a Linux control group (a container's or a service's memory limit) still allows.
#pragma once

#include <cstdint>
#include <filesystem>

namespace lumisweep {

/// What memory limits are where there is none.
inline constexpr std::uint64_t unlimited_memory = UINT64_MAX;

/// Bytes left under the tightest memory limit of this process's control group and its ancestors, version 1 and 2;
/// unlimited_memory without a limit. `membership` is /proc/self/cgroup and `mount` /sys/fs/cgroup, or copies of them in
/// tests.
std::uint64_t control_group_memory_left(const std::filesystem::path& membership, const std::filesystem::path& mount);

} // namespace lumisweep
