#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/render/backend.h"
#include "sampler.h"

namespace lumisweep::python {

namespace {

namespace fs = std::filesystem;

using Progress = std::function<py::object(std::int64_t, double)>;

/// A session with the Python objects that it was made from. Everything that may wait for a background sweep is done
/// without the interpreter: that thread may let go of an array. Meanwhile signal handlers and other Python threads may
/// run, and find the session busy; while a progress callback runs it can be read.
class SessionHandle {
public:
    SessionHandle(std::shared_ptr<VolumeHandle> volume, std::shared_ptr<EnvironmentHandle> environment,
                  SessionInput input, StopCriterion stop, std::unique_ptr<tbb::task_arena> arena,
                  std::shared_ptr<Backend> backend)
        : volume_(std::move(volume)), environment_(std::move(environment)), stop_(stop), arena_(std::move(arena))
    {
        input.volume = volume_->grid;
        input.environment = environment_->light;
        const py::gil_scoped_release release;
        arena_->execute([&] {
            require_finite(*input.volume);
            session_ = std::make_unique<Session>(std::move(input), std::move(backend));
        });
    }

    ~SessionHandle()
    {
        const py::gil_scoped_release release;
        session_.reset();
    }
    SessionHandle(const SessionHandle&) = delete;
    SessionHandle& operator=(const SessionHandle&) = delete;

    const Session& session() const
    {
        require_free(Use::reading);
        return *session_;
    }
    const SessionInput& input() const { return session().input(); }
    const std::shared_ptr<VolumeHandle>& volume() const { return volume_; }
    const std::shared_ptr<EnvironmentHandle>& environment() const { return environment_; }
    const StopCriterion& stop() const { return stop_; }
    int threads() const { return arena_->max_concurrency(); }

    /// A call of a setter.
    template <class Call>
    void edit(Call&& call)
    {
        const Busy busy(*this);
        const py::gil_scoped_release release;
        arena_->execute([&] { call(*session_); });
        if (session_->film().samples() == 0)
            render_s_ = 0.0;
    }
    void set_volume(std::shared_ptr<VolumeHandle> volume)
    {
        require(volume != nullptr, "session: volume is None");
        edit([&](Session& s) {
            require_finite(*volume->grid);
            s.set_volume(volume->grid);
        });
        volume_ = std::move(volume);
        kept_visibility_.reset();
    }
    void set_environment(std::shared_ptr<EnvironmentHandle> environment)
    {
        require(environment != nullptr, "session: environment is None");
        edit([&](Session& s) { s.set_environment(environment->light); });
        environment_ = std::move(environment);
    }
    void set_transfer_function(const TransferFunction& transfer_function)
    {
        edit([&](Session& s) { s.set_transfer_function(transfer_function); });
        kept_visibility_.reset();
    }
    void set_visibility_settings(const VisibilitySettings& settings)
    {
        edit([&](Session& s) { s.set_visibility(settings); });
        kept_visibility_.reset();
    }
    void set_sweep_mode(SweepMode mode, int threads)
    {
        // oneTBB complains on stderr when more are asked for than the machine has.
        edit([&](Session& s) { s.set_sweep_mode(mode, threads <= 4096 ? std::min(threads, all_threads()) : threads); });
        mode_ = mode;
    }

    void prepare()
    {
        const Busy busy(*this);
        run_interruptible(*arena_, [this](const std::atomic<bool>& cancel) { session_->prepare(&cancel); });
    }

    void render(const StopCriterion& stop, const Progress& progress)
    {
        const Busy busy(*this);
        run_interruptible(*arena_, [&](const std::atomic<bool>& cancel) {
            if (mode_ == SweepMode::before_pass && !session_->prepare(&cancel))
                return;
            using Clock = std::chrono::steady_clock;
            const Clock::time_point begin = Clock::now();
            const double before = render_s_;
            const Stopping stopping(stop, session_->film());
            double elapsed_s = 0.0, told_s = -1.0;
            while (!stopping.met(elapsed_s) && session_->render_pass(&cancel) == PassEnd::complete) {
                elapsed_s = std::chrono::duration<double>(Clock::now() - begin).count();
                render_s_ = before + elapsed_s;
                if (progress && elapsed_s - told_s >= 0.1) {
                    told_s = elapsed_s;
                    tell(progress, elapsed_s);
                }
            }
        });
    }

    ImageHandle image() const
    {
        require(session().film().samples() > 0, "session: no pass has been rendered (call render)");
        const Background background = input().image.show_environment ? Background::opaque : Background::transparent;
        return {annotated_image(*session_, render_s_), background};
    }

    /// The grid that directions are drawn by. Where the strategy draws by none: the one that was set, or swept before.
    std::shared_ptr<VisibilityHandle> visibility()
    {
        const Strategy strategy = input().render.strategy;
        if (strategy == Strategy::uniform || strategy == Strategy::environment ||
            !(input().environment->mean_luminance() > 0.0)) {
            if (!kept_visibility_)
                kept_visibility_ = sweep(*input().volume, input().transfer_function, input().visibility, *arena_);
            return kept_visibility_;
        }
        prepare();
        VisibilityGrid copy = copy_of(session().visibility(), input().volume->size(), input().visibility.cell);
        return std::make_shared<VisibilityHandle>(
            VisibilityHandle{std::make_shared<const VisibilityGrid>(std::move(copy)), {}});
    }
    void set_visibility(const std::shared_ptr<VisibilityHandle>& visibility)
    {
        require(visibility != nullptr, "session: visibility is None");
        VisibilityGrid grid = copy_of(*visibility->grid, input().volume->size(), input().visibility.cell);
        edit([&](Session& s) { s.replace_visibility(std::move(grid)); });
        kept_visibility_ = visibility;
    }

    SamplerHandle sampler(const std::optional<std::string>& name)
    {
        const Strategy strategy = name ? strategy_of(*name) : input().render.strategy;
        std::shared_ptr<VisibilityHandle> grid;
        if (strategy != Strategy::uniform && strategy != Strategy::environment)
            grid = visibility();
        const Busy busy(*this);
        const py::gil_scoped_release release;
        SamplerHandle made;
        arena_->execute([&] {
            const SessionInput& present = session_->input();
            made = make_sampler(strategy, present.volume, present.environment, grid ? grid->grid.get() : nullptr,
                                present.visibility.epsilon);
        });
        return made;
    }

    std::vector<std::string> notes, warnings;

private:
    enum class Use { none, reading, all };

    void require_free(Use wanted) const
    {
        require(free_for_ == Use::all || (free_for_ == Use::reading && wanted == Use::reading),
                "session: is busy with another call (change it when that has returned)");
    }
    /// Begins and ends with the interpreter's lock held, which is what guards free_for_.
    class Busy {
    public:
        explicit Busy(SessionHandle& handle) : handle_(handle)
        {
            handle.require_free(Use::all);
            handle.free_for_ = Use::none;
        }
        ~Busy() { handle_.free_for_ = Use::all; }
        Busy(const Busy&) = delete;
        Busy& operator=(const Busy&) = delete;

    private:
        SessionHandle& handle_;
    };

    void tell(const Progress& progress, double elapsed_s)
    {
        const py::gil_scoped_acquire acquire;
        free_for_ = Use::reading;
        try {
            progress(session_->film().samples(), elapsed_s);
        } catch (...) {
            free_for_ = Use::none;
            throw;
        }
        free_for_ = Use::none;
    }

    /// A borrowed array may have been written to since it was looked at.
    static void require_finite(const ScalarGrid& volume)
    {
        require(volume.owns_voxels() || !any_infinite(volume),
                "session: the volume's array has infinite values by now (make a Volume of it again)");
    }

    std::shared_ptr<VolumeHandle> volume_;
    std::shared_ptr<EnvironmentHandle> environment_;
    std::shared_ptr<VisibilityHandle>
        kept_visibility_; // of the present volume, transfer function and settings, or null
    StopCriterion stop_;
    SweepMode mode_ = SweepMode::before_pass;
    double render_s_ = 0.0; // of the passes in the film
    Use free_for_ = Use::all;
    std::unique_ptr<tbb::task_arena> arena_;
    std::unique_ptr<Session> session_;
};

std::shared_ptr<SessionHandle> from_parts(const std::shared_ptr<VolumeHandle>& volume,
                                          const std::optional<TransferFunction>& transfer_function,
                                          std::shared_ptr<EnvironmentHandle> environment,
                                          const std::optional<Camera>& camera, const ImageSettings& image,
                                          const RenderSettings& render, const VisibilitySettings& visibility,
                                          int threads, const std::string& isa)
{
    require(volume != nullptr, "session: volume is None");
    std::shared_ptr<Backend> backend = make_cpu_backend(isa);
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
                                                  std::move(arena), std::move(backend));
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

std::shared_ptr<SessionHandle> load(const py::object& scene, const py::dict& overrides, const fs::path& base_directory,
                                    int threads, const std::string& isa)
{
    std::shared_ptr<Backend> backend = make_cpu_backend(isa);
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
                                                  description.stop, std::move(arena), std::move(backend));
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
        .def(py::init(&from_parts), py::arg("volume"), py::arg("transfer_function") = none,
             py::arg("environment") = none, py::kw_only(), py::arg("camera") = none,
             py::arg("image_settings") = ImageSettings{}, py::arg("render_settings") = RenderSettings{},
             py::arg("visibility_settings") = VisibilitySettings{}, py::arg("threads") = 0, py::arg("isa") = "auto",
             "What is None is chosen as for the command line: a preset, the sky, a camera that frames the volume.")
        .def_static("load", &load, py::arg("scene"), py::kw_only(), py::arg("overrides") = py::dict(),
                    py::arg("base_directory") = ".", py::arg("threads") = 0, py::arg("isa") = "auto",
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
        .def_property_readonly("isa", [](const Handle& h) { return h.session().backend().isa(); })
        .def_property_readonly("threads", [](const Handle& h) { return h.threads(); })
        .def_property_readonly("stats", &stats_of, "As --stats of the command line.")
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
