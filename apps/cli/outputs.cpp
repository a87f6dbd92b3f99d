#include "outputs.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "commands.h"
#include "lumisweep/base/error.h"
#include "lumisweep/base/extension.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/image/exr.h"
#include "lumisweep/image/png.h"
#include "lumisweep/image/tonemap.h"
#include "lumisweep/render/annotate.h"
#include "lumisweep/render/backend.h"

namespace lumisweep::cli {

namespace {

namespace fs = std::filesystem;

Image image_with_header(const Session& session, const RenderResult& result, const RenderHeader& header)
{
    Image image = annotated_image(session, result.render_s);
    image.text["scene"] = header.scene_text;
    image.text["sceneInFull"] = header.effective_text;
    return image;
}

} // namespace

void require_image_extensions(const std::vector<std::string>& files)
{
    for (const std::string& file : files) {
        const std::string extension = lower_extension(file);
        if (extension != ".exr" && extension != ".png")
            throw UsageError(fmt::format("-o {}: unknown kind of image (give a name that ends in .exr or .png)", file));
    }
}

void require_writable(const fs::path& file)
{
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    std::error_code ignored;
    require(fs::is_directory(folder, ignored), "{}: the folder {} does not exist (create it first)", file.string(),
            folder.string());
    require(!fs::is_directory(file, ignored), "{}: is a directory (give a file's name)", file.string());
    const bool there = fs::exists(file, ignored);
    const bool plain = !there || fs::is_regular_file(file, ignored);
    require((!plain || ::access(folder.c_str(), W_OK | X_OK) == 0) && (!there || ::access(file.c_str(), W_OK) == 0),
            "{}: cannot be written (check the permissions)", file.string());
    if (there)
        return;
    // Permissions do not say all: some file systems take no new files, whoever asks. The trial has a name of its own:
    // nobody who waits for the file, and no kill in between, may take an empty one for it.
    fs::path trial = file;
    trial += fmt::format(".{}.trial", ::getpid());
    const int descriptor = ::open(trial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    require(descriptor >= 0, "{}: cannot be created, {} (check the folder)", file.string(), std::strerror(errno));
    ::close(descriptor);
    ::unlink(trial.c_str());
}

void write_images(const std::vector<std::string>& files, const Session& session, const RenderResult& result,
                  const RenderHeader& header)
{
    if (files.empty())
        return;
    const Image image = image_with_header(session, result, header);
    const ToneMapSettings display =
        display_settings(image, session.input().image.show_environment ? Background::opaque : Background::transparent);
    for (const std::string& file : files) {
        if (lower_extension(file) == ".exr")
            write_exr(file, image);
        else
            write_png(file, tone_map(image, display));
    }
}

void write_stats(const fs::path& file, const Session& session, const RenderResult& result, double load_s, int threads)
{
    const SessionStats& stats = session.stats();
    const RenderSettings render = session.input().render.resolved();
    const double noise = session.film().noise();
    nlohmann::ordered_json json;
    json["strategy"] = name_of(session.input().render.strategy);
    json["random_numbers"] = render.random_numbers == RandomNumbers::stratified ? "stratified" : "independent";
    json["samples_per_pixel"] = session.film().samples();
    json["paths"] = stats.counts.paths;
    json["shadow_rays"] = {{"per_camera_ray", render.shadow_rays}, {"traced", stats.counts.shadow_rays}};
    json["threads"] = threads;
    json["device"] = session.backend().device();
    json["isa"] = session.backend().isa();
    json["seconds"] = {
        {"load", load_s},         {"classify", stats.classify_s}, {"majorants", stats.bounds_s + stats.majorants_s},
        {"sweep", stats.sweep_s}, {"joint", stats.joint_s},       {"render", result.render_s}};
    json["memory_bytes"] = {{"volume", stats.volume_bytes},           {"visibility", stats.visibility_bytes},
                            {"environment", stats.environment_bytes}, {"joint", stats.joint_bytes},
                            {"majorants", stats.majorant_bytes},      {"film", stats.film_bytes},
                            {"peak_rss", peak_resident_memory()}};
    json["steps"] = {{"camera", stats.counts.camera_steps}, {"shadow", stats.counts.shadow_steps}};
    json["noise"] = std::isfinite(noise) ? nlohmann::ordered_json(noise) : nlohmann::ordered_json(nullptr);
    json["stopped_by_user"] = result.stopped_by_user;
    std::ofstream out(file);
    out << json.dump(2) << '\n';
    out.close();
    require(out.good(), "{}: cannot write the statistics (check the folder and the space on the disk)", file.string());
}

} // namespace lumisweep::cli
