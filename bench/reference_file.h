// References as OpenEXR files, so that they are rendered once.
#pragma once

#include <filesystem>

#include "efficiency.h"

namespace lumisweep::bench {

void write_reference(const std::filesystem::path& file, const Reference& reference);
/// Throws Error unless the file is a whole reference.
Reference read_reference(const std::filesystem::path& file);

} // namespace lumisweep::bench
