#include <bit>
#include <filesystem>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep::python {

namespace {

std::shared_ptr<EnvironmentHandle> handle_of(Environment environment, std::vector<std::string> warnings = {})
{
    return std::make_shared<EnvironmentHandle>(
        EnvironmentHandle{std::make_shared<const Environment>(std::move(environment)), std::move(warnings)});
}

std::shared_ptr<EnvironmentHandle> load(const std::filesystem::path& file, double scale, double rotation_deg)
{
    const py::gil_scoped_release release;
    LoadedEnvironment loaded = load_environment({file, scale, rotation_deg});
    return handle_of(std::move(loaded.environment), std::move(loaded.warnings));
}

FloatArray radiance_array(const py::object& radiance)
{
    FloatArray array = numbers<FloatArray>(radiance, "radiance");
    require(array.ndim() == 3 && array.shape(2) == 3, "radiance: has shape {} (give [rows, columns, 3])",
            text_of(shape_of(array)));
    return array;
}

std::shared_ptr<EnvironmentHandle> from_latlong(const py::object& radiance, double scale, double rotation_deg)
{
    const FloatArray array = radiance_array(radiance);
    Image image;
    image.height = static_cast<int>(array.shape(0));
    image.width = static_cast<int>(array.shape(1));
    const auto pixels = static_cast<std::size_t>(array.size()) / 3;
    for (std::size_t c = 0; c < 3; ++c) {
        Channel channel{std::string(1, "RGB"[c]), std::vector<float>(pixels)};
        for (std::size_t i = 0; i < pixels; ++i)
            channel.pixels[i] = array.data()[3 * i + c];
        image.channels.push_back(std::move(channel));
    }
    const py::gil_scoped_release release;
    LatLongReport report;
    Environment environment = environment_from_latlong(image, scale, rotation_deg, &report);
    return handle_of(std::move(environment), warnings_of(report, "radiance"));
}

std::shared_ptr<EnvironmentHandle> from_octahedral(const py::object& radiance)
{
    const FloatArray array = radiance_array(radiance);
    const auto n = static_cast<int>(array.shape(0));
    require(array.shape(1) == n && std::has_single_bit(static_cast<unsigned>(n)),
            "radiance: has shape {} (give [n, n, 3], n a power of two)", text_of(shape_of(array)));
    AlignedArray<float> texels(static_cast<std::size_t>(array.size()));
    const auto at = array.unchecked<3>();
    for (int v = 0; v < n; ++v)
        for (int u = 0; u < n; ++u)
            for (int c = 0; c < 3; ++c)
                texels[3 * static_cast<std::size_t>(morton_encode(u, v)) + static_cast<std::size_t>(c)] = at(v, u, c);
    return handle_of(Environment(n, std::move(texels)));
}

py::array_t<float> radiance_of(const EnvironmentHandle& environment)
{
    const int n = environment.light->resolution();
    const EnvironmentView view = environment.light->view();
    py::array_t<float> array(Shape{n, n, 3});
    auto at = array.mutable_unchecked<3>();
    for (int v = 0; v < n; ++v)
        for (int u = 0; u < n; ++u)
            for (int c = 0; c < 3; ++c)
                at(v, u, c) =
                    view.radiance[3 * static_cast<std::size_t>(morton_encode(u, v)) + static_cast<std::size_t>(c)];
    return array;
}

py::array_t<double> radiance_from(const EnvironmentHandle& environment, const py::object& directions)
{
    const Vectors w = directions_of(directions, "directions");
    py::array_t<double> array(with(w.shape, 3));
    double* out = array.mutable_data();
    const py::gil_scoped_release release;
    parallel_for(
        std::size_t(0), w.size(),
        [&](std::size_t i) {
            const Vec3d radiance = environment.light->radiance(w.direction(i));
            for (int c = 0; c < 3; ++c)
                out[3 * i + static_cast<std::size_t>(c)] = component(radiance, c);
        },
        1024);
    return array;
}

py::array_t<double> octahedral_directions(int n)
{
    require(n >= 1 && n <= 16384, "octahedral_directions: {} is not 1 to 16384", n);
    py::array_t<double> array(Shape{n, n, 3});
    auto at = array.mutable_unchecked<3>();
    for (int v = 0; v < n; ++v)
        for (int u = 0; u < n; ++u) {
            const Vec3d w = direction_from_oct(UV<double>{(u + 0.5) / n, (v + 0.5) / n});
            for (int c = 0; c < 3; ++c)
                at(v, u, c) = component(w, c);
        }
    return array;
}

std::shared_ptr<EnvironmentHandle> sky(const py::object& zenith, const py::object& horizon, const py::object& ground,
                                       const py::object& sun_direction, double sun_angular_diameter_deg,
                                       const py::object& sun_irradiance, int resolution)
{
    const SkySettings settings{vec3_of(zenith, "zenith"), vec3_of(horizon, "horizon"),
                               vec3_of(ground, "ground"), vec3_of(sun_direction, "sun_direction"),
                               sun_angular_diameter_deg,  vec3_of(sun_irradiance, "sun_irradiance")};
    const py::gil_scoped_release release;
    return handle_of(environment_from_sky(settings, resolution));
}

} // namespace

void bind_environment(py::module_& module)
{
    const SkySettings clear;
    py::class_<EnvironmentHandle, std::shared_ptr<EnvironmentHandle>>(
        module, "Environment", "Radiance from all directions, as an equal-area octahedral map; +Z is up.")
        .def_static("load", &load, py::arg("file"), py::kw_only(), py::arg("scale") = 1.0,
                    py::arg("rotation_deg") = 0.0, "A latitude-longitude map, OpenEXR or Radiance HDR.")
        .def_static(
            "from_latlong", &from_latlong, py::arg("radiance"), py::kw_only(), py::arg("scale") = 1.0,
            py::arg("rotation_deg") = 0.0,
            "[height, width, 3]: row 0 is +Z, the centre column looks along +X, columns run clockwise seen from above.")
        .def_static("from_octahedral", &from_octahedral, py::arg("radiance"),
                    "[n, n, 3], n a power of two, row v and column u as octahedral_directions(n).")
        .def_static(
            "constant",
            [](const py::object& radiance) { return handle_of(Environment::constant(vec3_of(radiance, "radiance"))); },
            py::arg("radiance") = py::make_tuple(1.0, 1.0, 1.0), "The same radiance from everywhere.")
        .def_static("sky", &sky, py::kw_only(), py::arg("zenith") = tuple_of(clear.zenith),
                    py::arg("horizon") = tuple_of(clear.horizon), py::arg("ground") = tuple_of(clear.ground),
                    py::arg("sun_direction") = tuple_of(clear.sun_direction),
                    py::arg("sun_angular_diameter_deg") = clear.sun_angular_diameter_deg,
                    py::arg("sun_irradiance") = tuple_of(clear.sun_irradiance), py::arg("resolution") = 512,
                    "The scene file's analytic sky, with its names and defaults.")
        .def_property_readonly(
            "resolution", [](const EnvironmentHandle& e) { return e.light->resolution(); }, "n of the n × n map.")
        .def_property_readonly("radiance", &radiance_of, "[n, n, 3], a copy.")
        .def_property_readonly("mean_luminance", [](const EnvironmentHandle& e) { return e.light->mean_luminance(); })
        .def_readonly("warnings", &EnvironmentHandle::warnings)
        .def("__call__", &radiance_from, py::arg("directions"),
             "Radiance [..., 3] from directions [..., 3], constant over a texel.");
    module.def("octahedral_directions", &octahedral_directions, py::arg("n"),
               "[n, n, 3]: unit directions of the texels' centres, row v, column u; every texel covers 4π / n² sr.");
}

} // namespace lumisweep::python
