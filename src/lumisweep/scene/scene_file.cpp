#include "lumisweep/scene/scene_file.h"

#include <unistd.h>

#include "lumisweep/base/error.h"
#include "lumisweep/scene/json_reader.h"
#include "lumisweep/scene/json_text.h"
#include "lumisweep/scene/overrides.h"
#include "lumisweep/scene/scene_sections.h"

namespace lumisweep {

namespace {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

bool has_wildcards(const fs::path& file) { return file.string().find_first_of("*?[") != std::string::npos; }

void require_readable(const fs::path& file, const char* key)
{
    std::error_code ignored;
    require(fs::exists(file, ignored), "{}: {}: no such file (check the path; it is relative to the scene file)", key,
            printable(file.string(), 400));
    require(::access(file.c_str(), R_OK) == 0, "{}: {}: cannot be read (check its permissions)", key,
            printable(file.string(), 400));
}

} // namespace

SceneDescription parse_scene(std::string_view text, const std::string& name, const fs::path& base_directory,
                             const std::vector<SceneOverride>& overrides)
{
    ordered_json json = parse_json(text, name);
    require(json.is_object(), "{}: a scene must be an object {{...}}", name);
    apply_overrides(json, overrides);

    const ObjectReader reader(
        json, JsonPlace{name, ""},
        {"version", "volume", "transfer_function", "environment", "camera", "image", "render", "visibility"});
    if (const ordered_json* version = reader.find("version"))
        require(*version == 1, "{}: this program reads version 1 only, not {}", reader.place("version").text(),
                printable(version->dump(-1, ' ', false, ordered_json::error_handler_t::replace), 40));
    SceneDescription scene;
    if (const ordered_json* section = reader.find("volume"))
        scene.volume = read_volume(*section, reader.place("volume"), base_directory);
    if (const ordered_json* section = reader.find("transfer_function"))
        scene.transfer_function = read_transfer_function(*section, reader.place("transfer_function"));
    if (const ordered_json* section = reader.find("environment"))
        scene.environment = read_environment(*section, reader.place("environment"), base_directory);
    if (const ordered_json* section = reader.find("camera"))
        scene.camera = read_camera(*section, reader.place("camera"));
    if (const ordered_json* section = reader.find("image"))
        scene.image = read_image(*section, reader.place("image"));
    if (const ordered_json* section = reader.find("render"))
        read_render(*section, reader.place("render"), scene.render, scene.stop);
    if (const ordered_json* section = reader.find("visibility"))
        scene.visibility = read_visibility(*section, reader.place("visibility"));
    return scene;
}

SceneDescription read_scene_file(const fs::path& file, const std::vector<SceneOverride>& overrides)
{
    return parse_scene(read_text_file(file), file.string(), fs::absolute(file).parent_path(), overrides);
}

std::string read_scene_text(const fs::path& file) { return read_text_file(file); }

TransferFunctionDescription read_transfer_function_file(const fs::path& file)
{
    const ordered_json json = parse_json(read_text_file(file), file.string());
    return read_transfer_function(json, JsonPlace{file.string(), ""});
}

std::string scene_to_json(const SceneDescription& scene)
{
    return json_of(scene).dump(2, ' ', false, ordered_json::error_handler_t::replace);
}

void require_files(const SceneDescription& scene)
{
    if (scene.volume)
        for (const fs::path& file : scene.volume->files)
            if (!has_wildcards(file))
                require_readable(file, "volume");
    if (const auto* file = std::get_if<fs::path>(&scene.environment.light))
        require_readable(*file, "environment");
}

} // namespace lumisweep
