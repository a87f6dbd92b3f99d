#include <algorithm>
#include <optional>
#include <span>
#include <variant>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"

namespace lumisweep::python {

namespace {

template <class Enum>
Enum enum_of(const std::string& name, std::span<const std::string_view> names, const char* key)
{
    const auto found = std::find(names.begin(), names.end(), name);
    require(found != names.end(), "{}: \"{}\" is not one of {}", key, name, fmt::join(names, ", "));
    return static_cast<Enum>(found - names.begin());
}

template <class Enum>
std::string name_in(Enum value, std::span<const std::string_view> names)
{
    return std::string(names[static_cast<std::size_t>(value)]);
}

using NumberOrAuto = std::variant<int, std::string>;

/// 0 in the library.
int number_of(const NumberOrAuto& value, const char* key)
{
    if (const int* number = std::get_if<int>(&value)) {
        require(*number >= 1, "{}: {} is not 1 or more, nor \"auto\"", key, *number);
        return *number;
    }
    require(std::get<std::string>(value) == "auto", "{}: \"{}\" is no number, nor \"auto\"", key,
            std::get<std::string>(value));
    return 0;
}

NumberOrAuto number_or_auto(int number)
{
    return number == 0 ? NumberOrAuto(std::string("auto")) : NumberOrAuto(number);
}

/// replace(**entries), ==, repr() and pickling for a class whose entries, all that its constructor takes, are `names`.
/// Settings do not change: a session takes them whole, so a change of one that it gave would go nowhere.
template <class Settings>
void add_record_methods(py::class_<Settings>& cls, const std::vector<std::string>& names)
{
    const auto entries = [names](const py::handle& self) {
        py::dict all;
        for (const std::string& name : names)
            all[py::str(name)] = self.attr(name.c_str());
        return all;
    };
    cls.def(
        "replace",
        [entries](const py::object& self, const py::kwargs& changes) {
            py::dict all = entries(self);
            for (const auto& [name, value] : changes)
                all[name] = value;
            return py::type::of(self)(**all);
        },
        "A copy with these entries changed.");
    cls.def("__reduce__", [entries](const py::object& self) {
        const py::object make = py::module_::import("functools").attr("partial");
        return py::make_tuple(make(py::type::of(self), **entries(self)), py::tuple());
    });
    cls.def("__eq__", [entries](const py::object& self, const py::object& other) {
        return py::isinstance<Settings>(other) && entries(self).equal(entries(other));
    });
    cls.def("__repr__", [names](const py::object& self) {
        std::string text = py::str(py::type::of(self).attr("__name__")).cast<std::string>() + "(";
        for (const std::string& name : names)
            text +=
                (text.back() == '(' ? "" : ", ") + name + "=" + py::repr(self.attr(name.c_str())).cast<std::string>();
        return text + ")";
    });
}

void bind_camera(py::module_& module)
{
    const Camera standard;
    const auto vector = [](Vec3d Camera::*member) {
        return [member](const Camera& camera) { return tuple_of(camera.*member); };
    };
    const auto focus = [](const Camera& camera) {
        return camera.focus_distance > 0.0 ? std::optional(camera.focus_distance) : std::nullopt;
    };
    py::class_<Camera> cls(module, "Camera", "A thin-lens camera; lengths in world units.");
    cls.def(py::init([](const py::object& position, const py::object& target, const py::object& up,
                        double vertical_fov_deg, double lens_radius, std::optional<double> focus_distance) {
                Camera camera;
                camera.position = vec3_of(position, "camera.position");
                camera.target = vec3_of(target, "camera.target");
                camera.up = vec3_of(up, "camera.up");
                camera.vertical_fov_deg = vertical_fov_deg;
                camera.lens_radius = lens_radius;
                camera.focus_distance = focus_distance.value_or(0.0);
                require(!focus_distance || *focus_distance > 0.0, "camera.focus_distance: {} is not positive (or None)",
                        focus_distance.value_or(0.0));
                camera.validate();
                return camera;
            }),
            py::kw_only(), py::arg("position") = tuple_of(standard.position),
            py::arg("target") = tuple_of(standard.target), py::arg("up") = tuple_of(standard.up),
            py::arg("vertical_fov_deg") = standard.vertical_fov_deg, py::arg("lens_radius") = standard.lens_radius,
            py::arg("focus_distance") = py::none(), "focus_distance None is the target's distance.")
        .def_static(
            "framed",
            [](const VolumeHandle& volume, const TransferFunction& transfer_function, int width, int height,
               double vertical_fov_deg) {
                const ImageSettings image{width, height, true};
                image.validate();
                const py::gil_scoped_release release;
                return framed_camera(volume, transfer_function, image, vertical_fov_deg);
            },
            py::arg("volume"), py::arg("transfer_function"), py::kw_only(), py::arg("width") = 512,
            py::arg("height") = 512, py::arg("vertical_fov_deg") = standard.vertical_fov_deg,
            "In front of what the transfer function shows, at the distance at which it just fits.")
        .def_property_readonly("position", vector(&Camera::position))
        .def_property_readonly("target", vector(&Camera::target))
        .def_property_readonly("up", vector(&Camera::up))
        .def_readonly("vertical_fov_deg", &Camera::vertical_fov_deg)
        .def_readonly("lens_radius", &Camera::lens_radius)
        .def_property_readonly("focus_distance", focus)
        .def(
            "camera_from_world",
            [](const Camera& camera) {
                const std::array<double, 16> m = camera.camera_from_world();
                py::array_t<double> matrix(Shape{4, 4});
                std::copy(m.begin(), m.end(), matrix.mutable_data());
                return matrix;
            },
            "4 × 4, for column vectors: x to the right, y up, z along the view.");
    add_record_methods(cls, {"position", "target", "up", "vertical_fov_deg", "lens_radius", "focus_distance"});
}

void bind_image_settings(py::module_& module)
{
    const ImageSettings standard;
    py::class_<ImageSettings> cls(module, "ImageSettings", "The image, as in a scene file.");
    cls.def(py::init([](int width, int height, bool show_environment) {
                const ImageSettings settings{width, height, show_environment};
                settings.validate();
                return settings;
            }),
            py::kw_only(), py::arg("width") = standard.width, py::arg("height") = standard.height,
            py::arg("show_environment") = standard.show_environment)
        .def_readonly("width", &ImageSettings::width)
        .def_readonly("height", &ImageSettings::height)
        .def_readonly("show_environment", &ImageSettings::show_environment);
    add_record_methods(cls, {"width", "height", "show_environment"});
}

void bind_render_settings(py::module_& module)
{
    const auto numbers_of = [](const std::string& name) {
        return enum_of<RandomNumbers>(name, random_numbers_names, "render.random_numbers");
    };
    py::class_<RenderSettings> cls(module, "RenderSettings",
                                   "How directions and numbers are drawn, as in a scene file.");
    cls.def(py::init([numbers_of](const std::string& strategy, const std::string& random_numbers,
                                  const NumberOrAuto& shadow_rays, std::uint64_t seed) {
                RenderSettings settings;
                settings.strategy = strategy_of(strategy);
                settings.random_numbers = numbers_of(random_numbers);
                settings.shadow_rays = number_of(shadow_rays, "render.shadow_rays");
                settings.seed = seed;
                settings.validate();
                return settings;
            }),
            py::kw_only(), py::arg("strategy") = "auto", py::arg("random_numbers") = "auto",
            py::arg("shadow_rays") = "auto", py::arg("seed") = 0)
        .def_property_readonly("strategy", [](const RenderSettings& s) { return name_of(s.strategy); })
        .def_property_readonly("random_numbers",
                               [](const RenderSettings& s) { return name_in(s.random_numbers, random_numbers_names); })
        .def_property_readonly("shadow_rays", [](const RenderSettings& s) { return number_or_auto(s.shadow_rays); })
        .def_readonly("seed", &RenderSettings::seed);
    add_record_methods(cls, {"strategy", "random_numbers", "shadow_rays", "seed"});
}

void bind_visibility_settings(py::module_& module)
{
    const VisibilitySettings standard;
    const auto filter_of = [](const std::string& name) {
        return enum_of<SweepFilter>(name, filter_names, "visibility.filter");
    };
    py::class_<VisibilitySettings> cls(module, "VisibilitySettings", "The visibility grid, as in a scene file.");
    cls.def(py::init([filter_of](int directions, int cell, const NumberOrAuto& rays, const std::string& filter,
                                 int oversampling, double epsilon) {
                const VisibilitySettings settings{directions,        cell,         number_of(rays, "visibility.rays"),
                                                  filter_of(filter), oversampling, epsilon};
                settings.validate();
                return settings;
            }),
            py::kw_only(), py::arg("directions") = standard.directions, py::arg("cell") = standard.cell,
            py::arg("rays") = "auto", py::arg("filter") = name_in(standard.filter, filter_names),
            py::arg("oversampling") = standard.oversampling, py::arg("epsilon") = standard.epsilon)
        .def_readonly("directions", &VisibilitySettings::directions)
        .def_readonly("cell", &VisibilitySettings::cell)
        .def_property_readonly("rays", [](const VisibilitySettings& s) { return number_or_auto(s.rays); })
        .def_property_readonly("filter", [](const VisibilitySettings& s) { return name_in(s.filter, filter_names); })
        .def_readonly("oversampling", &VisibilitySettings::oversampling)
        .def_readonly("epsilon", &VisibilitySettings::epsilon);
    add_record_methods(cls, {"directions", "cell", "rays", "filter", "oversampling", "epsilon"});
}

} // namespace

Strategy strategy_of(const std::string& name) { return enum_of<Strategy>(name, strategy_names, "strategy"); }

Camera framed_camera(const VolumeHandle& volume, const TransferFunction& transfer_function, const ImageSettings& image,
                     double vertical_fov_deg)
{
    const VoxelBox box = visible_box(*volume.grid, transfer_function, value_statistics(*volume.grid));
    CameraDescription description;
    description.vertical_fov_deg = vertical_fov_deg;
    Camera camera = frame_camera(description, *volume.grid, box, image);
    camera.validate();
    return camera;
}

void bind_settings(py::module_& module)
{
    bind_camera(module);
    bind_image_settings(module);
    bind_render_settings(module);
    bind_visibility_settings(module);
}

} // namespace lumisweep::python
