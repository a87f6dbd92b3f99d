#include <optional>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/octahedral.h"
#include "sampler.h"

namespace lumisweep::python {

namespace {

SamplerHandle from_parts(const std::string& strategy, const VolumeHandle& volume, const EnvironmentHandle& environment,
                         const std::shared_ptr<VisibilityHandle>& visibility, double epsilon)
{
    const py::gil_scoped_release release;
    return make_sampler(strategy_of(strategy), volume.grid, environment.light,
                        visibility ? visibility->grid.get() : nullptr, epsilon);
}

py::array_t<double> pdf(const SamplerHandle& handle, const py::object& positions, const py::object& directions)
{
    const auto [p, w] = rays_of(positions, directions);
    py::array_t<double> result(p.shape);
    double* out = result.mutable_data();
    const py::gil_scoped_release release;
    parallel_for(
        std::size_t(0), p.size(),
        [&, &p = p, &w = w](std::size_t i) {
            out[i] = handle.sampler->pdf_omega(handle.volume->voxel_from_world().point(p[i]), w.direction(i));
        },
        256);
    return result;
}

py::array_t<double> pdf_map(const SamplerHandle& handle, const py::object& position, std::optional<int> n)
{
    const Vec3d p_voxel = handle.volume->voxel_from_world().point(vec3_of(position, "position"));
    const int side = n.value_or(handle.sampler->resolution());
    require(side >= 1 && side <= 16384, "pdf_map: n is {}, not 1 to 16384", side);
    py::array_t<double> map(Shape{side, side});
    double* out = map.mutable_data();
    const py::gil_scoped_release release;
    parallel_for(0, side, [&](int v) {
        for (int u = 0; u < side; ++u)
            out[static_cast<std::ptrdiff_t>(v) * side + u] =
                handle.sampler->pdf_omega(p_voxel, direction_from_oct(UV<double>{(u + 0.5) / side, (v + 0.5) / side}));
    });
    return map;
}

py::tuple sample(const SamplerHandle& handle, const py::object& position, const py::object& uniform)
{
    const Vec3d p_voxel = handle.volume->voxel_from_world().point(vec3_of(position, "position"));
    const Vectors u = vectors_of(uniform, "numbers");
    for (std::size_t i = 0; i < u.size(); ++i)
        require(u[i].x >= 0.0 && u[i].x < 1.0 && u[i].y >= 0.0 && u[i].y < 1.0 && u[i].z >= 0.0 && u[i].z < 1.0,
                "numbers: number {} is not in [0, 1)", i);
    py::array_t<double> directions(with(u.shape, 3)), densities(u.shape);
    double* w = directions.mutable_data();
    double* density = densities.mutable_data();
    {
        const py::gil_scoped_release release;
        parallel_for(
            std::size_t(0), u.size(),
            [&](std::size_t i) {
                const DirectionSampler::Sample drawn = handle.sampler->sample(p_voxel, u[i]);
                for (int c = 0; c < 3; ++c)
                    w[3 * i + static_cast<std::size_t>(c)] = component(drawn.w_world, c);
                density[i] = drawn.pdf_omega;
            },
            256);
    }
    return py::make_tuple(directions, densities);
}

} // namespace

SamplerHandle make_sampler(Strategy strategy, std::shared_ptr<const ScalarGrid> volume,
                           std::shared_ptr<const Environment> environment, const VisibilityGrid* visibility,
                           double epsilon)
{
    auto sampler =
        std::make_shared<const DirectionSampler>(strategy, std::move(environment), visibility, volume->size(), epsilon);
    return {std::move(sampler), std::move(volume)};
}

void bind_sampler(py::module_& module)
{
    py::class_<SamplerHandle>(module, "DirectionSampler", "A strategy's density of directions, at any point.")
        .def(py::init(&from_parts), py::arg("strategy"), py::arg("volume"), py::arg("environment"),
             py::arg("visibility") = py::none(), py::kw_only(), py::arg("epsilon") = VisibilitySettings{}.epsilon,
             "uniform and environment need no visibility. \"auto\" has two-step's density.")
        .def_property_readonly("strategy", [](const SamplerHandle& h) { return name_of(h.sampler->strategy()); })
        .def("pdf", &pdf, py::arg("positions"), py::arg("directions"),
             "Per steradian, of directions [..., 3] at world positions [..., 3] (broadcast).")
        .def("pdf_map", &pdf_map, py::arg("position"), py::arg("n") = py::none(),
             "[n, n] per steradian at one world position, at the texels' centres; n defaults to the environment's "
             "resolution.")
        .def("sample", &sample, py::arg("position"), py::arg("numbers"),
             "(directions [..., 3], pdf per steradian [...]) of numbers [..., 3] in [0, 1) at one world position.");
}

} // namespace lumisweep::python
