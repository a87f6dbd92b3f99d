// Any bytes as a volume file: a volume or an Error, nothing else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

#include <unistd.h>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/io/load_volume.h"

namespace lumisweep::fuzz {

/// Larger volumes are left unread: reading them tells nothing new and takes time.
constexpr std::uint64_t max_bytes = std::uint64_t(1) << 26;

/// Reads `data` as a file with the given extension; aborts where the reader breaks its contract.
inline void load(const std::uint8_t* data, std::size_t size, const std::string& extension)
{
    static const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("lumisweep-fuzz-" + std::to_string(getpid()) + extension);
    static const int registered = std::atexit([] { std::filesystem::remove(file); });
    (void)registered;
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    try {
        const VolumeHeader header = inspect_volume(file);
        if (header.bytes_needed > max_bytes)
            return;
        const LoadedVolume volume = load_volume({{file}, header.frames - 1});
        if (!(volume.grid.size() == header.size) || volume.frames != header.frames)
            std::abort();
    } catch (const Error& e) {
        if (std::string(e.what()).find('\n') != std::string::npos)
            std::abort();
    } catch (const std::bad_alloc&) {
        // May pass through: the caller reports it.
    }
}

} // namespace lumisweep::fuzz
