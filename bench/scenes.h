// The scenes on which rendering is measured: real data where they have been fetched, and generated volumes.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lumisweep/render/session.h"

namespace lumisweep::bench {

/// Where real data and the scene files of the project are.
struct SceneSources {
    std::filesystem::path project, data;
};

enum class SceneScale { full, quick }; ///< quick: generated volumes are small

/// ct_head, stent, ch2better, plume (a simulated flame's smoke), ct_like, smoke_like, and shells_2 and shells_400:
/// fractal shells of that mean optical depth.
const std::vector<std::string>& scene_names();

/// The scene under the morning sun of the fetched lights, or under the analytic sky without them; the background is
/// hidden. Nothing when its data have not been fetched.
std::optional<SessionInput> load_bench_scene(const std::string& name, const SceneSources& sources, SceneScale scale,
                                             ImageSettings image);

/// Writes NAME.json, and NAME.nrrd for a generated volume, for the programs that read scene files. False when its data
/// have not been fetched.
bool write_bench_scene(const std::string& name, const SceneSources& sources, SceneScale scale,
                       const std::filesystem::path& folder);

/// The sky with a bright sun of 10° exactly behind the camera's target: hardly any of its light reaches what is seen of
/// an opaque object.
std::shared_ptr<const Environment> light_from_behind(const Camera& camera);

} // namespace lumisweep::bench
