// Options that say what to render: those that `render` and `sweep` share.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lumisweep/scene/scene_description.h"

namespace CLI {
class App;
}

namespace lumisweep {
class Backend;
}

namespace lumisweep::cli {

struct SceneOptions {
    std::string scene_file, volume, transfer_function, environment;
    std::vector<std::string> overrides; ///< KEY.PATH=VALUE
    std::string device = "cpu", isa = "auto";
    int threads = 0; ///< 0: all that the machine offers
    bool quiet = false;
};

void add_scene_options(CLI::App& app, SceneOptions& options);

/// The scene file with its overrides and the other options put in; validated, and its files are there. Throws
/// UsageError when there is neither a scene nor a volume, Error for what is wrong with them and for an instruction set
/// that is not there.
SceneDescription read_scene(const SceneOptions& options);

/// Throws Error for a device that is not there; auto that falls back to the CPU says so.
std::shared_ptr<Backend> backend_of(const SceneOptions& options);

/// Runs `work` with options.threads threads.
void run_with_threads(int threads, const std::function<void()>& work);

} // namespace lumisweep::cli
