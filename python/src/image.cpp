#include <filesystem>
#include <optional>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"

namespace lumisweep::python {

namespace {

namespace fs = std::filesystem;

ImageHandle from_channels(const py::dict& channels)
{
    ImageHandle handle;
    Image& image = handle.image;
    for (const auto& [key, value] : channels) {
        if (!py::isinstance<py::str>(key))
            throw py::type_error("image: names of channels are strings");
        const auto name = key.cast<std::string>();
        const FloatArray array = numbers<FloatArray>(value, name.c_str());
        require(array.ndim() == 2, "image: channel {} has shape {} (give [height, width])", name,
                text_of(shape_of(array)));
        const auto height = static_cast<int>(array.shape(0)), width = static_cast<int>(array.shape(1));
        require(image.channels.empty() || (height == image.height && width == image.width),
                "image: channel {} is {} x {}, another {} x {}", name, width, height, image.width, image.height);
        image.width = width;
        image.height = height;
        image.channels.push_back({name, std::vector<float>(array.data(), array.data() + array.size())});
    }
    require(image.width >= 1 && image.height >= 1, "image: has no pixels (give {{\"R\": array, ...}})");
    return handle;
}

const Channel& channel(const Image& image, const std::string& name)
{
    const Channel* found = image.find(name);
    if (found == nullptr)
        throw py::key_error(name);
    return *found;
}

py::array_t<float> pixels(const ImageHandle& handle, const std::string& name)
{
    py::array_t<float> array(Shape{handle.image.height, handle.image.width});
    const std::vector<float>& from = channel(handle.image, name).pixels;
    std::copy(from.begin(), from.end(), array.mutable_data());
    return array;
}

/// [height, width, 3] of three channels.
auto layer(const char* a, const char* b, const char* c)
{
    return [names = std::array<std::string, 3>{a, b, c}](const ImageHandle& handle) {
        py::array_t<float> array(Shape{handle.image.height, handle.image.width, 3});
        for (std::size_t i = 0; i < 3; ++i) {
            const std::vector<float>& from = channel(handle.image, names[i]).pixels;
            for (std::size_t p = 0; p < from.size(); ++p)
                array.mutable_data()[3 * p + i] = from[p];
        }
        return array;
    };
}

py::dict attributes(const ImageHandle& handle)
{
    py::dict all;
    for (const auto& [name, text] : handle.image.text)
        all[py::str(name)] = text;
    for (const auto& [name, number] : handle.image.numbers)
        all[py::str(name)] = number;
    for (const auto& [name, matrix] : handle.image.matrices) {
        const auto side = static_cast<py::ssize_t>(matrix.size() == 16 ? 4 : 3);
        py::array_t<double> array(Shape{side, side});
        std::copy(matrix.begin(), matrix.begin() + side * side, array.mutable_data());
        all[py::str(name)] = array;
    }
    return all;
}

DisplayImage displayed(const ImageHandle& handle, std::optional<double> exposure, std::optional<bool> show_environment)
{
    const Background background = !show_environment   ? handle.background
                                  : *show_environment ? Background::opaque
                                                      : Background::transparent;
    ToneMapSettings settings = display_settings(handle.image, background);
    if (exposure)
        settings.exposure = exposure;
    return tone_map(handle.image, settings);
}

py::array_t<std::uint8_t> toned(const ImageHandle& handle, std::optional<double> exposure,
                                std::optional<bool> show_environment)
{
    DisplayImage shown;
    {
        const py::gil_scoped_release release;
        shown = displayed(handle, exposure, show_environment);
    }
    py::array_t<std::uint8_t> array(Shape{shown.height, shown.width, shown.channels});
    std::copy(shown.pixels.begin(), shown.pixels.end(), array.mutable_data());
    return array;
}

py::dict comparison(const ImageHandle& image, const ImageHandle& reference)
{
    const Comparison c = compare_images(image.image, reference.image);
    py::dict result;
    result["mse"] = c.mse;
    result["relmse"] = c.relmse;
    result["rmse"] = c.rmse;
    result["psnr"] = c.psnr;
    result["mean_image"] = c.mean_image;
    result["mean_reference"] = c.mean_reference;
    return result;
}

} // namespace

void bind_image(py::module_& module)
{
    const py::none none;
    const py::call_guard<py::gil_scoped_release> without_interpreter;
    py::class_<ImageHandle>(module, "Image",
                            "Float channels by name, row 0 at the top, with an EXR header's attributes.")
        .def(py::init(&from_channels), py::arg("channels"), "{\"R\": [height, width], …}.")
        .def_property_readonly("width", [](const ImageHandle& h) { return h.image.width; })
        .def_property_readonly("height", [](const ImageHandle& h) { return h.image.height; })
        .def_property_readonly("channels",
                               [](const ImageHandle& h) {
                                   std::vector<std::string> names;
                                   for (const Channel& c : h.image.channels)
                                       names.push_back(c.name);
                                   return names;
                               })
        .def_property_readonly("attributes", &attributes)
        .def("__getitem__", &pixels, py::arg("channel"), "[height, width].")
        .def("__contains__",
             [](const ImageHandle& h, const py::object& name) {
                 return py::isinstance<py::str>(name) && h.image.find(name.cast<std::string>()) != nullptr;
             })
        .def_property_readonly("radiance", layer("R", "G", "B"), "[height, width, 3], linear.")
        .def_property_readonly(
            "alpha", [](const ImageHandle& h) { return pixels(h, "A"); },
            "1 − mean transmittance along the camera ray.")
        .def_property_readonly("variance", layer("Variance.R", "Variance.G", "Variance.B"), "Of the pixel's mean.")
        .def_property_readonly("albedo", layer("albedo.R", "albedo.G", "albedo.B"), "Of the first collision.")
        .def_property_readonly("normal", layer("normal.X", "normal.Y", "normal.Z"), "The data's gradient, world space.")
        .def_property_readonly(
            "depth", [](const ImageHandle& h) { return pixels(h, "depth.Z"); },
            "Distance of the first collision along the camera ray, mean over samples.")
        .def(
            "write_exr", [](const ImageHandle& h, const fs::path& file) { write_exr(file, h.image); }, py::arg("file"),
            without_interpreter)
        .def("tone_map", &toned, py::kw_only(), py::arg("exposure") = none, py::arg("show_environment") = none,
             "[height, width, 3 or 4], sRGB, as the command line's PNG.")
        .def(
            "write_png",
            [](const ImageHandle& h, const fs::path& file, std::optional<double> exposure,
               std::optional<bool> show_environment) { write_png(file, displayed(h, exposure, show_environment)); },
            py::arg("file"), py::kw_only(), py::arg("exposure") = none, py::arg("show_environment") = none,
            without_interpreter);
    module.def(
        "read_exr", [](const fs::path& file) { return ImageHandle{read_exr(file)}; }, py::arg("file"),
        without_interpreter);
    module.def("compare", &comparison, py::arg("image"), py::arg("reference"),
               "mse, relmse, rmse, psnr, mean_image, mean_reference over all pixels and R, G, B.");
}

} // namespace lumisweep::python
