#include "lumisweep/base/control_group.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

#include <fmt/format.h>

namespace lumisweep {

namespace fs = std::filesystem;

namespace {

/// File names of one version of the interface.
struct Interface {
    const char* limit;
    const char* usage;
    const char* reclaimable; // key in memory.stat: page cache that the kernel drops before it refuses
};

constexpr Interface version1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};
constexpr Interface version2{"memory.max", "memory.current", "inactive_file"};

std::optional<std::uint64_t> read_number(const fs::path& file)
{
    std::ifstream in(file);
    std::uint64_t number = 0;
    if (in >> number)
        return number;
    return std::nullopt; // absent, or the word "max"
}

std::uint64_t read_statistic(const fs::path& file, const std::string& key)
{
    std::ifstream in(file);
    std::string name;
    std::uint64_t number = 0;
    while (in >> name >> number)
        if (name == key)
            return number;
    return 0;
}

std::uint64_t left_in(const fs::path& folder, const Interface& names)
{
    const auto limit = read_number(folder / names.limit);
    const auto usage = read_number(folder / names.usage);
    if (!limit || !usage)
        return unlimited_memory;
    const std::uint64_t reclaimable = read_statistic(folder / "memory.stat", names.reclaimable);
    const std::uint64_t used = *usage - std::min(*usage, reclaimable);
    return *limit - std::min(*limit, used);
}

/// The minimum over `group` and its ancestors. Inside a container the path in the membership file may not exist under
/// the mount; the mount's root, which is then the container's own group, is looked at in any case.
std::uint64_t left_along(const fs::path& root, const std::string& group, const Interface& names)
{
    std::uint64_t left = left_in(root, names);
    fs::path folder = root;
    for (const auto& part : fs::path(group).relative_path()) {
        folder /= part;
        left = std::min(left, left_in(folder, names));
    }
    return left;
}

} // namespace

std::uint64_t control_group_memory_left(const fs::path& membership, const fs::path& mount)
{
    // Lines are "id:controllers:path"; version 2 has no controllers.
    std::uint64_t left = unlimited_memory;
    std::ifstream in(membership);
    for (std::string line; std::getline(in, line);) {
        const auto first = line.find(':');
        const auto second = first == std::string::npos ? first : line.find(':', first + 1);
        if (second == std::string::npos)
            continue;
        const std::string controllers = fmt::format(",{},", line.substr(first + 1, second - first - 1));
        const std::string group = line.substr(second + 1);
        if (controllers == ",,")
            left = std::min(left, left_along(mount, group, version2));
        else if (controllers.find(",memory,") != std::string::npos)
            left = std::min(left, left_along(mount / "memory", group, version1));
    }
    return left;
}

} // namespace lumisweep
