// OpenEXR files: linear radiance, named layers, and header attributes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "lumisweep/image/image.h"

namespace lumisweep {

/// Reads all channels, whatever their type, compression and tiling, of a file's first part as floats, over its display
/// window: pixels outside of the data window are 0. Luminance alone (Y) comes as R = G = B, luminance and chroma
/// (Y, RY, BY) as R, G, B. String, number (int, float, double) and matrix (m33 excepted) attributes come along.
/// Throws Error, one line, for anything that is not a sound, flat OpenEXR image or does not fit into memory.
Image read_exr(const std::filesystem::path& path);

/// The same from a file's bytes; `name` is what errors call them.
Image read_exr(std::span<const std::byte> bytes, const std::string& name);

/// Writes all channels as 32-bit floats with lossless ZIP compression, and the attributes (numbers as doubles); channel
/// names with dots make layers ("Variance.R"). Replaces the file at once or not at all (image/atomic_file.h).
/// Throws Error if the image contradicts itself or the file cannot be written.
void write_exr(const std::filesystem::path& path, const Image& image);

} // namespace lumisweep
