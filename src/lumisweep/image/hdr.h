// Radiance pictures (.hdr, RGBE), and reading an environment map of either format.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "lumisweep/image/image.h"

namespace lumisweep {

/// Reads a Radiance picture with 32-bit_rle_rgbe pixels as channels R, G, B: flat, old and new run-length coding;
/// EXPOSURE lines are divided out. A channel is mantissa · 2^(exponent − 136).
/// Only the usual orientation, -Y height +X width, is read. Throws Error, one line, for anything else, for broken or
/// truncated files and for images that do not fit into memory.
///
/// Not by stb_image, which fills up truncated files with zeros and takes old run-length codes for colours, silently.
Image read_hdr(const std::filesystem::path& path);

/// The same from a file's bytes; `name` is what errors call them.
Image read_hdr(std::span<const std::byte> bytes, const std::string& name);

/// Reads an environment map, OpenEXR or Radiance by its first bytes whatever its name says. R, G and B are there.
Image load_latlong(const std::filesystem::path& path);

} // namespace lumisweep
