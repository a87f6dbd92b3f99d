// What reading and writing OpenEXR files share; not for use outside of this folder.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace lumisweep::exr_detail {

/// The attributes by which OpenEXR describes the file itself: not the image's own.
inline constexpr std::array<std::string_view, 14> structural_attributes{
    "channels",           "compression",        "dataWindow", "displayWindow", "lineOrder", "pixelAspectRatio",
    "screenWindowCenter", "screenWindowWidth",  "tiles",      "name",          "type",      "version",
    "chunkCount",         "dwaCompressionLevel"};

/// Sizes beyond which a file is taken as broken, here and by OpenEXR itself, before it allocates anything.
inline constexpr int max_size = 65536;

/// How many threads OpenEXR may use: those of the calling arena. Makes sure that its pool has as many.
int threads();

/// A library's message as one printable line.
std::string one_line(const char* message);

bool is_structural(std::string_view attribute);

} // namespace lumisweep::exr_detail
