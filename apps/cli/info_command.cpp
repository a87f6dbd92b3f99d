// lumisweep info: what a volume, an environment map or a scene holds.
#include <cstdio>
#include <limits>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "info.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/extension.h"

namespace lumisweep::cli {

namespace {

namespace fs = std::filesystem;

struct InfoOptions {
    std::string path;
    int frame = 0;
    bool json = false;
};

void info(const InfoOptions& options)
{
    const fs::path path = options.path;
    std::error_code ignored;
    require(fs::exists(path, ignored), "{}: no such file or directory (check the path)", options.path);
    const std::string extension = fs::is_directory(path, ignored) ? "" : lower_extension(path);
    nlohmann::ordered_json found;
    void (*print_text)(const nlohmann::ordered_json&) = nullptr;
    if (extension == ".json") {
        found = scene_info(path);
        print_text = print_scene;
    } else if (extension == ".exr" || extension == ".hdr" || extension == ".pic") {
        found = environment_info(path);
        print_text = print_environment;
    } else {
        found = volume_info(path, options.frame);
        print_text = print_volume;
    }
    if (options.json)
        fmt::print("{}\n", found.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    else
        print_text(found);
}

} // namespace

void add_info(CLI::App& app, Command& command)
{
    CLI::App* sub = app.add_subcommand("info", "Says what a volume, an environment map or a scene holds");
    auto options = std::make_shared<InfoOptions>();
    sub->add_option("path", options->path, "Volume file, DICOM directory, .exr or .hdr map, or scene .json")
        ->required()
        ->type_name("FILE|DIR");
    sub->add_option("--frame", options->frame, "Frame of a time series")
        ->check(CLI::Range(0, std::numeric_limits<int>::max()));
    sub->add_flag("--json", options->json, "Print JSON");
    sub->callback([options, &command] { command = [options] { info(*options); }; });
}

} // namespace lumisweep::cli
