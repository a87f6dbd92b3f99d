// Judging an OpenEXR file by its headers, before the library allocates what they ask for.
#pragma once

#include <cstdint>
#include <string>

#include <OpenEXR/ImfIO.h>

namespace lumisweep::exr_detail {

/// Reads all headers of the file from its beginning and throws Error if one claims sizes, or so many pieces that the
/// file cannot hold their directory, or if decoding the first part would not fit into memory. Leaves the stream
/// anywhere.
void check_headers(Imf::IStream& stream, std::uint64_t file_bytes, const std::string& name);

} // namespace lumisweep::exr_detail
