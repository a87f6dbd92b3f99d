// From `volume.files` of a scene to a list of files in the order of time.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace lumisweep {

/// Orders digit runs by their number: "frame2" before "frame10". Equal numbers: fewer leading zeros first.
bool natural_less(std::string_view a, std::string_view b);

/// Files that match a glob(7) pattern (*, ?, [a-z]), in natural order; a pattern that is the
/// name of an existing file stands for that file. Throws Error when there is none.
std::vector<std::filesystem::path> expand_files(const std::string& pattern);

} // namespace lumisweep
