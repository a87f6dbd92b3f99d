#include "scenes.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "lumisweep/base/error.h"
#include "lumisweep/image/atomic_file.h"
#include "lumisweep/light/sky.h"
#include "lumisweep/scene/framing.h"
#include "lumisweep/scene/load_scene.h"
#include "lumisweep/scene/scene_file.h"
#include "lumisweep/scene/value_statistics.h"
#include "volumes.h"

namespace lumisweep::bench {
namespace {

namespace fs = std::filesystem;

std::optional<Specimen> generated(const std::string& name, SceneScale scale)
{
    const bool quick = scale == SceneScale::quick;
    const Vec3i shells = quick ? Vec3i{96, 96, 96} : Vec3i{384, 384, 384};
    if (name == "ct_like")
        return ct_like(quick ? Vec3i{64, 64, 57} : Vec3i{512, 512, 460});
    if (name == "smoke_like")
        return smoke_like(quick ? Vec3i{48, 48, 64} : Vec3i{384, 384, 512});
    if (name == "shells_2")
        return fractal_shells(shells, 2.0);
    if (name == "shells_400")
        return fractal_shells(shells, 400.0);
    return std::nullopt;
}

/// Of a scene with real data; nothing when they are not there.
std::optional<SceneDescription> described(const std::string& name, const SceneSources& sources)
{
    const fs::path scenes = sources.project / "scenes";
    fs::path file = name == "ch2better" ? scenes / "ch2.json" : scenes / (name + ".json");
    const fs::path volume = name == "ch2better" ? sources.data / "ch2better.nii.gz"
                            : name == "plume"   ? sources.project / "tests" / "data" / "plume_4d_density.nrrd"
                                                : sources.data / (name + ".nrrd");
    std::error_code ignored;
    if (!fs::exists(volume, ignored))
        return std::nullopt;
    const std::vector<SceneOverride> overrides{{"volume", fmt::format("{{\"file\": \"{}\"}}", volume.string())}};
    if (name == "plume")
        // Well into the sequence: the smoke has risen.
        return parse_scene(R"({"transfer_function": {"preset": "smoke"}})", name, sources.data,
                           {{"volume", fmt::format("{{\"file\": \"{}\", \"frame\": 24}}", volume.string())}});
    return read_scene_file(file, overrides);
}

EnvironmentDescription morning(const SceneSources& sources)
{
    EnvironmentDescription light;
    const fs::path file = sources.data / "environments" / "sunrise.exr";
    std::error_code ignored;
    if (fs::exists(file, ignored))
        light.light = file;
    return light;
}

/// As framed by the program, but with the box's corners beyond the image's: half of the image and more is volume.
Camera close_camera(const ScalarGrid& volume, const TransferFunction& transfer_function)
{
    const VoxelBox box = visible_box(volume, transfer_function, value_statistics(volume));
    Camera camera = frame_camera({}, volume, box, {512, 512, false});
    camera.vertical_fov_deg *= 0.7;
    return camera;
}

void look_closely(const ScalarGrid& volume, const TransferFunction& transfer_function, CameraDescription& description)
{
    const Camera camera = close_camera(volume, transfer_function);
    description.position = camera.position;
    description.target = camera.target;
    description.vertical_fov_deg = camera.vertical_fov_deg;
}

void write_nrrd(const fs::path& file, const ScalarGrid& volume)
{
    const Vec3i size = volume.size();
    const Affine3d& a = volume.world_from_voxel();
    const auto vector = [](const Vec3d& v) { return fmt::format("({:.17g},{:.17g},{:.17g})", v.x, v.y, v.z); };
    const std::string header = fmt::format(
        "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\nspace directions: {} {} "
        "{}\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: {}\n\n",
        volume.type() == VoxelType::u8 ? "uint8" : "int16", size.x, size.y, size.z, vector(a.column[0]),
        vector(a.column[1]), vector(a.column[2]), vector(a.point({0.5, 0.5, 0.5})));
    write_atomically(file, [&](std::ofstream& out) {
        out << header;
        out.write(reinterpret_cast<const char*>(volume.data()), static_cast<std::streamsize>(volume.bytes()));
    });
}

} // namespace

const std::vector<std::string>& scene_names()
{
    static const std::vector<std::string> names{"ct_head", "stent",      "ch2better", "plume",
                                                "ct_like", "smoke_like", "shells_2",  "shells_400"};
    return names;
}

std::optional<SessionInput> load_bench_scene(const std::string& name, const SceneSources& sources, SceneScale scale,
                                             ImageSettings image)
{
    image.show_environment = false;
    if (std::optional<Specimen> specimen = generated(name, scale)) {
        SessionInput input;
        input.transfer_function = specimen->transfer_function;
        input.environment = std::make_shared<const Environment>(load_environment(morning(sources)).environment);
        input.image = image;
        input.camera = close_camera(specimen->volume, input.transfer_function);
        input.volume = std::make_shared<const ScalarGrid>(std::move(specimen->volume));
        return input;
    }
    std::optional<SceneDescription> scene = described(name, sources);
    if (!scene)
        return std::nullopt;
    scene->environment = morning(sources);
    scene->image = image;
    SessionInput input = load_scene(*scene).input;
    if (name == "plume")
        input.camera = close_camera(*input.volume, input.transfer_function);
    return input;
}

bool write_bench_scene(const std::string& name, const SceneSources& sources, SceneScale scale, const fs::path& folder)
{
    SceneDescription scene;
    if (const std::optional<Specimen> specimen = generated(name, scale)) {
        const fs::path file = fs::absolute(folder / (name + ".nrrd"));
        write_nrrd(file, specimen->volume);
        scene.volume = VolumeDescription{{file}, 0};
        scene.transfer_function = TransferFunctionDescription{{}, specimen->transfer_function.points(), 1.0};
        look_closely(specimen->volume, specimen->transfer_function, scene.camera);
    } else if (std::optional<SceneDescription> found = described(name, sources)) {
        scene = std::move(*found);
        if (name == "plume") {
            const LoadedScene loaded = load_scene(scene);
            look_closely(*loaded.input.volume, loaded.input.transfer_function, scene.camera);
        }
    } else {
        return false;
    }
    scene.environment = morning(sources);
    write_atomically(folder / (name + ".json"), [&](std::ofstream& out) { out << scene_to_json(scene) << '\n'; });
    return true;
}

std::shared_ptr<const Environment> light_from_behind(const Camera& camera)
{
    SkySettings sky;
    sky.sun_direction = camera.target - camera.position;
    sky.sun_angular_diameter_deg = 10.0;
    sky.sun_irradiance = {100.0, 100.0, 100.0};
    return std::make_shared<const Environment>(environment_from_sky(sky));
}

} // namespace lumisweep::bench
