#include "lumisweep/base/memory.h"

#include <algorithm>
#include <array>
#include <fstream>

#include <sys/resource.h>
#include <unistd.h>

#include "lumisweep/base/control_group.h"
#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

/// A line "key:   123 kB" of a file in /proc, in bytes.
std::uint64_t read_kilobytes(const char* file, const std::string& key, std::uint64_t otherwise)
{
    std::ifstream in(file);
    for (std::string line; std::getline(in, line);)
        if (line.compare(0, key.size(), key) == 0)
            return std::strtoull(line.c_str() + key.size(), nullptr, 10) * 1024;
    return otherwise;
}

std::uint64_t address_space_left()
{
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return unlimited_memory;
    std::ifstream in("/proc/self/statm");
    std::uint64_t pages = 0;
    if (!(in >> pages))
        return limit.rlim_cur;
    const std::uint64_t used = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    return limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, used);
}

} // namespace

std::uint64_t available_memory()
{
    const std::uint64_t machine = read_kilobytes("/proc/meminfo", "MemAvailable:", unlimited_memory);
    const std::uint64_t group = control_group_memory_left("/proc/self/cgroup", "/sys/fs/cgroup");
    return std::min({machine, group, address_space_left()});
}

void require_memory(std::uint64_t bytes, const std::string& what, const std::string& mend)
{
    const std::uint64_t available = available_memory();
    const std::uint64_t usable = available - available / 20;
    require(bytes <= usable, "{}: needs {} of memory, {} are available ({})", what, format_bytes(bytes),
            format_bytes(usable), mend);
}

std::uint64_t peak_resident_memory() { return read_kilobytes("/proc/self/status", "VmHWM:", 0); }

std::string format_bytes(std::uint64_t bytes)
{
    constexpr std::array units{"bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
    if (bytes < 1024)
        return fmt::format("{} bytes", bytes);
    double value = static_cast<double>(bytes);
    std::size_t unit = 0;
    // 1023.95 would be printed as 1024.0: the next unit already.
    while (value >= 1023.95 && unit + 1 < units.size()) {
        value /= 1024.0;
        ++unit;
    }
    return fmt::format("{:.1f} {}", value, units[unit]);
}

} // namespace lumisweep
