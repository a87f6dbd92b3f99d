#include <limits>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"

namespace lumisweep::python {

namespace {

TransferPoint point_of(const py::handle& object)
{
    const auto number = [](const py::handle& value, const char* name) {
        const DoubleArray array = numbers(value, name);
        require(array.size() == 1, "{}: is not one number", name);
        return *array.data();
    };
    if (py::isinstance<py::dict>(object)) {
        const auto entries = py::reinterpret_borrow<py::dict>(object);
        for (const auto& [key, value] : entries)
            require(py::str(key).cast<std::string>() == "value" || py::str(key).cast<std::string>() == "extinction" ||
                        py::str(key).cast<std::string>() == "albedo",
                    "transfer function: a point has the unknown entry {} (give value, extinction, albedo)",
                    py::str(key).cast<std::string>());
        require(entries.contains("value") && entries.contains("extinction"),
                "transfer function: a point lacks value or extinction");
        TransferPoint point;
        point.value = number(entries["value"], "value");
        point.extinction = number(entries["extinction"], "extinction");
        if (entries.contains("albedo"))
            point.albedo = vec3_of(entries["albedo"], "albedo");
        return point;
    }
    require(py::isinstance<py::sequence>(object) && py::len(object) == 3,
            "transfer function: a point is neither a dictionary nor (value, extinction, albedo)");
    const auto parts = py::reinterpret_borrow<py::sequence>(object);
    return {number(parts[0], "value"), number(parts[1], "extinction"), vec3_of(parts[2], "albedo")};
}

TransferFunction from_points(const py::iterable& points, double extinction_scale)
{
    std::vector<TransferPoint> all;
    for (const py::handle& point : points)
        all.push_back(point_of(point));
    return TransferFunction(std::move(all), extinction_scale);
}

py::tuple evaluate(const TransferFunction& function, const py::object& values)
{
    const DoubleArray v = numbers(values, "values");
    py::array_t<double> extinction(shape_of(v)), albedo(with(shape_of(v), 3));
    for (py::ssize_t i = 0; i < v.size(); ++i) {
        const TransferFunction::Material material = function.evaluate(v.data()[i]);
        extinction.mutable_data()[i] = material.extinction;
        for (int c = 0; c < 3; ++c)
            albedo.mutable_data()[3 * i + c] = component(material.albedo, c);
    }
    return py::make_tuple(extinction, albedo);
}

py::list points_of(const TransferFunction& function)
{
    py::list points;
    for (const TransferPoint& point : function.points())
        points.append(py::make_tuple(point.value, point.extinction, tuple_of(point.albedo)));
    return points;
}

} // namespace

TransferFunction preset_for(const VolumeHandle& volume, const std::string& name, double extinction_scale,
                            std::string* note)
{
    const PresetInput input =
        preset_input(*volume.grid, value_statistics(*volume.grid), volume.modality, volume.frames);
    if (name != "auto")
        return TransferFunction(preset_points(name, input), extinction_scale);
    const PresetChoice choice = choose_preset(input);
    if (note != nullptr)
        *note = choice.reason;
    return TransferFunction(preset_points(choice.name, input), extinction_scale);
}

void bind_transfer_function(py::module_& module)
{
    py::class_<TransferFunction>(module, "TransferFunction",
                                 "Value in data units to extinction (1 / world unit) and albedo, piecewise linear.")
        .def(py::init(&from_points), py::arg("points"), py::kw_only(), py::arg("extinction_scale") = 1.0,
             "Points by value, each {\"value\": v, \"extinction\": e, \"albedo\": [r, g, b]} or (v, e, (r, g, b)).")
        .def_static(
            "preset",
            [](const std::string& name, const VolumeHandle& volume, double extinction_scale) {
                const py::gil_scoped_release release;
                return preset_for(volume, name, extinction_scale);
            },
            py::arg("name"), py::arg("volume"), py::kw_only(), py::arg("extinction_scale") = 1.0,
            "By name (preset_names()), fitted to the volume's values; \"auto\" chooses from the data.")
        .def_property_readonly("points", &points_of, "[(value, extinction before extinction_scale, albedo), …].")
        .def_property_readonly("extinction_scale", &TransferFunction::extinction_scale)
        .def("__call__", &evaluate, py::arg("values"),
             "(extinction [...], albedo [..., 3]) of values [...]; NaN is empty.");
    module.def(
        "preset_names",
        [] {
            std::vector<std::string> names;
            for (const std::string_view name : preset_names())
                names.emplace_back(name);
            return names;
        },
        "Of transfer functions that give a good first picture.");
}

} // namespace lumisweep::python
