// The scene file: JSON text ↔ SceneDescription, strictly.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "lumisweep/scene/scene_description.h"

namespace lumisweep {

/// One entry that replaces the file's: "transfer_function.points.0.value" = "250". The value is read as JSON, and as a
/// string where it is no JSON. Of entries that exclude each other (volume.file and volume.files; environment.file,
/// .radiance and .sky; render.samples, .time and .noise; transfer_function.points and .preset) the one set last stays.
struct SceneOverride {
    std::string key_path;
    std::string value;
};

/// Parses and validates. `name` begins every message; relative paths are taken from `base_directory`. Throws Error with
/// one line that names the key's path (or line and column) and the mend.
SceneDescription parse_scene(std::string_view text, const std::string& name,
                             const std::filesystem::path& base_directory,
                             const std::vector<SceneOverride>& overrides = {});

/// Reads, overrides, parses and validates a scene file; paths are relative to it.
SceneDescription read_scene_file(const std::filesystem::path& file, const std::vector<SceneOverride>& overrides = {});

/// The file's text as it is. Throws Error when it cannot be read or is larger than a scene can be.
std::string read_scene_text(const std::filesystem::path& file);

/// A file that holds the JSON of the section "transfer_function" alone.
TransferFunctionDescription read_transfer_function_file(const std::filesystem::path& file);

/// Canonical JSON text with every default written out; parse_scene of it gives the same description.
std::string scene_to_json(const SceneDescription& scene);

/// Throws Error unless every file and directory that the scene names exists and can be read.
void require_files(const SceneDescription& scene);

} // namespace lumisweep
