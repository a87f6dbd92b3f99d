// PNG files, for looking at.
#pragma once

#include <filesystem>

#include "lumisweep/image/tonemap.h"

namespace lumisweep {

/// Writes 8-bit sRGB, with straight alpha if the image has four channels. Replaces the file at once or not at all.
/// Throws Error if the image contradicts itself or the file cannot be written.
void write_png(const std::filesystem::path& path, const DisplayImage& image);

} // namespace lumisweep
