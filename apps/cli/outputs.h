// What a render leaves behind: images with their headers, and the statistics file.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "lumisweep/render/session.h"
#include "render_loop.h"

namespace lumisweep::cli {

/// Throws UsageError for an extension that is neither .exr nor .png.
void require_image_extensions(const std::vector<std::string>& files);

/// Throws Error unless the file could be written: its folder exists, and neither it nor the file is write-protected.
void require_writable(const std::filesystem::path& file);

struct RenderHeader {
    std::string scene_text;     ///< of the scene file, or the scene that the options amount to
    std::string effective_text; ///< with every override and default
};

/// Writes the film to every file: .exr with layers and attributes, .png tone-mapped.
void write_images(const std::vector<std::string>& files, const Session& session, const RenderResult& result,
                  const RenderHeader& header);

/// The keys are docs/output.md's.
void write_stats(const std::filesystem::path& file, const Session& session, const RenderResult& result, double load_s,
                 int threads);

} // namespace lumisweep::cli
