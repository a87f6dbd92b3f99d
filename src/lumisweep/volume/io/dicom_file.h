// DCMTK as the DICOM reader uses it. (GDCM, ITK's default, aborts on malformed files: Debian builds it with
// assertions.)
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace lumisweep {

/// Silences DCMTK and registers its decoders; to be called before any other use of it, as often as convenient.
void prepare_dcmtk();

/// All frames of a file's pixel data, decompressed, in native byte order, bits above the stored ones masked or
/// sign-extended. Throws Error when they cannot be decoded.
std::vector<std::byte> decode_dicom_pixels(const std::filesystem::path& file);

} // namespace lumisweep
