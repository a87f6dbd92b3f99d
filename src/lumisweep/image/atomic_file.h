// Writing files so that a reader, a full disk or a kill never meets half a file: write beside it, then rename.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>

namespace lumisweep {

/// Calls write(stream) on a new binary file in the folder of `path`, then renames it to `path`. If anything fails the
/// new file is removed, whatever was at `path` stays, and the error is an Error or what `write` threw.
void write_atomically(const std::filesystem::path& path, const std::function<void(std::ofstream&)>& write);

} // namespace lumisweep
