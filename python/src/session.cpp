#include <cmath>
#include <filesystem>
#include <optional>

#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "lumisweep/backends/make_backend.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/render/backend.h"
#include "session_handle.h"

namespace lumisweep::python {

namespace {

namespace fs = std::filesystem;

std::shared_ptr<SessionHandle> session_from_parts(const std::shared_ptr<VolumeHandle>& volume,
                                                  const std::optional<TransferFunction>& transfer_function,
                                                  std::shared_ptr<EnvironmentHandle> environment,
                                                  const std::optional<Camera>& camera, const ImageSettings& image,
                                                  const RenderSettings& render, const VisibilitySettings& visibility,
                                                  int threads, const std::string& isa, const std::string& device)
{
    require(volume != nullptr, "session: volume is None");
    ChosenBackend chosen = make_backend(device_of(device), isa);
    std::unique_ptr<tbb::task_arena> arena = make_arena(threads);
    std::vector<std::string> notes;
    SessionInput input;
    input.image = image;
    input.render = render;
    input.visibility = visibility;
    {
        const py::gil_scoped_release release;
        arena->execute([&] {
            std::string note;
            input.transfer_function = transfer_function ? *transfer_function : preset_for(*volume, "auto", 1.0, &note);
            if (!note.empty())
                notes.push_back(note);
            if (!environment)
                environment = std::make_shared<EnvironmentHandle>(
                    EnvironmentHandle{std::make_shared<const Environment>(environment_from_sky({})), {}});
            input.camera =
                camera ? *camera : framed_camera(*volume, input.transfer_function, image, Camera{}.vertical_fov_deg);
        });
    }
    auto handle = std::make_shared<SessionHandle>(volume, environment, std::move(input), StopSamples{},
                                                  std::move(arena), std::move(chosen.backend));
    if (!chosen.note.empty())
        notes.push_back(chosen.note);
    handle->notes = std::move(notes);
    handle->warnings = volume->warnings;
    handle->warnings.insert(handle->warnings.end(), environment->warnings.begin(), environment->warnings.end());
    return handle;
}

/// JSON text of anything that Python's json knows, arrays and paths included.
std::string json_text(const py::handle& object)
{
    const py::cpp_function other([](const py::object& value) -> py::object {
        if (py::hasattr(value, "tolist"))
            return value.attr("tolist")();
        return py::module_::import("os").attr("fspath")(value);
    });
    return py::module_::import("json").attr("dumps")(object, py::arg("default") = other).cast<std::string>();
}

SceneDescription described(const py::object& scene, const py::dict& overrides, const fs::path& base_directory)
{
    std::vector<SceneOverride> replaced;
    for (const auto& [key, value] : overrides) {
        if (!py::isinstance<py::str>(key))
            throw py::type_error("overrides: keys are strings, such as \"visibility.cell\"");
        replaced.push_back({key.cast<std::string>(), json_text(value)});
    }
    if (py::isinstance<py::str>(scene) || py::hasattr(scene, "__fspath__"))
        return read_scene_file(scene.cast<fs::path>(), replaced);
    return parse_scene(json_text(scene), "scene", fs::absolute(base_directory), replaced);
}

std::shared_ptr<SessionHandle> session_from_scene(const py::object& scene, const py::dict& overrides,
                                                  const fs::path& base_directory, int threads, const std::string& isa,
                                                  const std::string& device)
{
    ChosenBackend chosen = make_backend(device_of(device), isa);
    std::unique_ptr<tbb::task_arena> arena = make_arena(threads);
    const SceneDescription description = described(scene, overrides, base_directory);
    LoadedScene loaded;
    {
        const py::gil_scoped_release release;
        arena->execute([&] { loaded = load_scene(description); });
    }
    auto volume =
        std::make_shared<VolumeHandle>(VolumeHandle{loaded.input.volume, loaded.modality, loaded.frames, false, {}});
    auto environment = std::make_shared<EnvironmentHandle>(EnvironmentHandle{loaded.input.environment, {}});
    auto handle = std::make_shared<SessionHandle>(std::move(volume), std::move(environment), std::move(loaded.input),
                                                  description.stop, std::move(arena), std::move(chosen.backend));
    if (!chosen.note.empty())
        loaded.notes.push_back(chosen.note);
    handle->notes = std::move(loaded.notes);
    handle->warnings = std::move(loaded.warnings);
    return handle;
}

StopCriterion stop_of(const SessionHandle& handle, std::optional<std::int64_t> samples, std::optional<double> time,
                      std::optional<double> noise)
{
    require(int(samples.has_value()) + int(time.has_value()) + int(noise.has_value()) <= 1,
            "render: give one of samples, time and noise");
    if (samples) {
        require(*samples >= 1 && *samples <= 2147483647, "render: samples {} is not 1 to 2147483647", *samples);
        return StopSamples{*samples};
    }
    if (time) {
        require(std::isfinite(*time) && *time > 0.0, "render: time {} is not positive", *time);
        return StopTime{*time};
    }
    if (noise) {
        require(std::isfinite(*noise) && *noise > 0.0, "render: noise {} is not positive", *noise);
        return StopNoise{*noise};
    }
    return handle.stop();
}

py::dict stats_of(const SessionHandle& handle)
{
    const SessionStats& stats = handle.session().stats();
    py::dict seconds, memory, steps, shadow_rays, all;
    seconds["classify"] = stats.classify_s;
    seconds["majorants"] = stats.bounds_s + stats.majorants_s;
    seconds["sweep"] = stats.sweep_s;
    seconds["joint"] = stats.joint_s;
    seconds["render"] = stats.render_s;
    memory["volume"] = stats.volume_bytes;
    memory["visibility"] = stats.visibility_bytes;
    memory["environment"] = stats.environment_bytes;
    memory["joint"] = stats.joint_bytes;
    memory["majorants"] = stats.majorant_bytes;
    memory["film"] = stats.film_bytes;
    memory["peak_rss"] = peak_resident_memory();
    steps["camera"] = stats.counts.camera_steps;
    steps["shadow"] = stats.counts.shadow_steps;
    shadow_rays["per_camera_ray"] = handle.input().render.resolved().shadow_rays;
    shadow_rays["traced"] = stats.counts.shadow_rays;
    all["seconds"] = seconds;
    all["memory_bytes"] = memory;
    all["steps"] = steps;
    all["shadow_rays"] = shadow_rays;
    all["paths"] = stats.counts.paths;
    return all;
}

} // namespace

void bind_session(py::module_& module)
{
    const py::none none;
    using Handle = SessionHandle;
    py::class_<Handle, std::shared_ptr<Handle>>(module, "Session",
                                                R"(A progressive render: volume, majorants, sweeps, film.

Set attributes between passes; only what depends on them is redone. render, prepare and sweeps let other Python threads run
and end at Ctrl-C with KeyboardInterrupt, with the passes so far in the film. Meanwhile the session refuses other calls.)")
        .def(py::init(&session_from_parts), py::arg("volume"), py::arg("transfer_function") = none,
             py::arg("environment") = none, py::kw_only(), py::arg("camera") = none,
             py::arg("image_settings") = ImageSettings{}, py::arg("render_settings") = RenderSettings{},
             py::arg("visibility_settings") = VisibilitySettings{}, py::arg("threads") = 0, py::arg("isa") = "auto",
             py::arg("device") = "cpu",
             "What is None is chosen as for the command line: a preset, the sky, a camera that frames the volume.")
        .def_static("load", &session_from_scene, py::arg("scene"), py::kw_only(), py::arg("overrides") = py::dict(),
                    py::arg("base_directory") = ".", py::arg("threads") = 0, py::arg("isa") = "auto",
                    py::arg("device") = "cpu",
                    R"(From a scene file, or a dictionary with a scene file's entries.

overrides {"visibility.cell": 8} are put in before; paths are relative to the file, or to base_directory.)")
        .def_readonly("notes", &Handle::notes, "What was chosen where the scene left it open.")
        .def_readonly("warnings", &Handle::warnings, "What the data made necessary.")
        .def_property("volume", &Handle::volume, &Handle::set_volume)
        .def_property("environment", &Handle::environment, &Handle::set_environment)
        .def_property(
            "transfer_function", [](const Handle& h) { return h.input().transfer_function; },
            &Handle::set_transfer_function)
        .def_property(
            "camera", [](const Handle& h) { return h.input().camera; },
            [](Handle& h, const Camera& c) { h.edit([&](Session& s) { s.set_camera(c); }); })
        .def_property(
            "image_settings", [](const Handle& h) { return h.input().image; },
            [](Handle& h, const ImageSettings& i) { h.edit([&](Session& s) { s.set_image(i); }); })
        .def_property(
            "render_settings", [](const Handle& h) { return h.input().render; },
            [](Handle& h, const RenderSettings& r) { h.edit([&](Session& s) { s.set_render(r); }); })
        .def_property(
            "visibility_settings", [](const Handle& h) { return h.input().visibility; },
            &Handle::set_visibility_settings)
        .def_property_readonly(
            "samples", [](const Handle& h) { return h.session().film().samples(); }, "A pixel, in the film.")
        .def_property_readonly(
            "noise", [](const Handle& h) { return h.session().film().noise(); },
            "Estimated relative error of the image; infinite while unknown.")
        .def_property_readonly("device", [](const Handle& h) { return h.session().backend().device(); })
        .def_property_readonly("isa", [](const Handle& h) { return h.session().backend().isa(); })
        .def_property_readonly("threads", [](const Handle& h) { return h.threads(); })
        .def_property_readonly("stats", &stats_of, "As --stats of the command line.")
        .def("prefetch", &Handle::prefetch, py::arg("volume"),
             "The volume that will be set next, as of a time series: a GPU begins to copy it while passes go on.")
        .def("prepare", &Handle::prepare, "Majorants, sweeps, joint grid: what the next pass would begin with.")
        .def(
            "render",
            [](Handle& h, std::optional<std::int64_t> samples, std::optional<double> time, std::optional<double> noise,
               const Progress& progress) {
                h.render(stop_of(h, samples, time, noise), progress);
                return h.image();
            },
            py::kw_only(), py::arg("samples") = none, py::arg("time") = none, py::arg("noise") = none,
            py::arg("progress") = none,
            R"(Adds passes until the film has `samples` a pixel, `time` seconds have passed or the relative error is `noise`.

Without any of them, what the scene says (64 samples). progress(samples, seconds) is called after passes, at most ten times a
second.)")
        .def("image", &Handle::image, "The film as it is.")
        .def(
            "sweep_in_background", [](Handle& h, int threads) { h.set_sweep_mode(SweepMode::in_background, threads); },
            py::arg("threads") = 0, "Edits do not wait for sweeps from now on. threads 0: half of the machine's.")
        .def(
            "sweep_before_pass", [](Handle& h) { h.set_sweep_mode(SweepMode::before_pass, 0); }, "The default.")
        .def_property_readonly("sweeping", [](const Handle& h) { return h.session().sweeping(); })
        .def_property("visibility", &Handle::visibility, &Handle::set_visibility,
                      "A copy of the grid that directions are drawn by, after prepare(); set one to replace it.")
        .def("sampler", &Handle::sampler, py::arg("strategy") = none,
             "How directions are drawn with this session's light and visibility.");
}

} // namespace lumisweep::python
