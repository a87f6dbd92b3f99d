// What an image depends on, by name: two renders with the same fingerprint give the same samples to the bit.
#pragma once

#include <map>
#include <string>

#include "lumisweep/render/session.h"

namespace lumisweep {

/// From "camera", "volume", "seed" and so on to a value or a hash of the content.
using Fingerprint = std::map<std::string, std::string>;

/// Of everything that changes a sample: contents of volume and environment, transfer function, camera, image, strategy,
/// seed, visibility settings, instruction set and program version. Not of when to stop.
Fingerprint fingerprint_of(const SessionInput& input, const std::string& isa, const std::string& program_version);

/// "camera, seed (3, not 4)": the entries that differ between two fingerprints; empty when they agree.
std::string difference(const Fingerprint& found, const Fingerprint& expected);

} // namespace lumisweep
