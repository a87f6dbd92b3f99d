#include <cmath>
#include <cstring>

#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/base/stopwatch.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/visibility/sweep_memory.h"

namespace lumisweep::python {

namespace {

std::shared_ptr<VisibilityHandle> handle_of(VisibilityGrid grid)
{
    return std::make_shared<VisibilityHandle>(
        VisibilityHandle{std::make_shared<const VisibilityGrid>(std::move(grid)), {}});
}

std::shared_ptr<VisibilityHandle> from_values(const py::object& values, const VolumeHandle& volume, int cell)
{
    const bool bytes = py::isinstance<py::array_t<std::uint8_t>>(values);
    const DoubleArray array = numbers(values, "values");
    require(array.ndim() == 5 && array.shape(0) == array.shape(1), "visibility: has shape {} (give [n, n, z, y, x])",
            text_of(shape_of(array)));
    VisibilitySettings settings;
    settings.directions = static_cast<int>(array.shape(0));
    settings.cell = cell;
    settings.validate();
    VisibilityGrid grid(volume.grid->size(), cell, settings.directions);
    const Vec3i n = grid.cells();
    require(array.shape(2) == n.z && array.shape(3) == n.y && array.shape(4) == n.x,
            "visibility: has shape {}, but cells of {} voxels are [z, y, x] = [{}, {}, {}]", text_of(shape_of(array)),
            cell, n.z, n.y, n.x);
    const double scale = bytes ? 1.0 : 255.0;
    const double* from = array.data();
    for (int v = 0; v < settings.directions; ++v)
        for (int u = 0; u < settings.directions; ++u) {
            std::uint8_t* to = grid.direction(morton_encode(u, v));
            for (std::size_t i = 0; i < grid.cell_count(); ++i, ++from) {
                const double value = *from * scale;
                require(value >= 0.0 && value <= 255.0, "visibility: {} is not in 0 to 1", *from);
                to[i] = static_cast<std::uint8_t>(std::lround(value));
            }
        }
    return handle_of(std::move(grid));
}

py::array_t<std::uint8_t> values_of(const VisibilityHandle& handle)
{
    const VisibilityGrid& grid = *handle.grid;
    const Vec3i cells = grid.cells();
    const int n = grid.directions_per_side();
    py::array_t<std::uint8_t> array(Shape{n, n, cells.z, cells.y, cells.x});
    std::uint8_t* to = array.mutable_data();
    for (int v = 0; v < n; ++v)
        for (int u = 0; u < n; ++u, to += grid.cell_count())
            std::memcpy(to, grid.direction(morton_encode(u, v)), grid.cell_count());
    return array;
}

py::dict stats_of(const SweepStats& stats, double classify_s)
{
    py::dict seconds, parts, all;
    seconds["classify"] = classify_s;
    seconds["sweep"] = stats.total_s;
    parts["layouts"] = stats.layout_s;
    parts["march"] = stats.march_s;
    parts["lookup"] = stats.lookup_s;
    parts["filter"] = stats.filter_s;
    all["seconds"] = seconds;
    all["processor_seconds"] = parts;
    all["voxel_steps"] = stats.voxel_steps;
    all["bytes_read"] = stats.bytes_read;
    all["rays"] = stats.rays;
    all["mip_level"] = stats.mip_level;
    return all;
}

/// Before it is taken.
void require_memory_for(Vec3i size, const VisibilitySettings& settings, int threads)
{
    const Vec3i n = VisibilityGrid::cells_of(size, settings.cell);
    const auto cells = static_cast<std::size_t>(n.x) * static_cast<std::size_t>(n.y) * static_cast<std::size_t>(n.z);
    require_memory(VisibilityGrid::bytes_needed(cells, settings.directions) + extinction_bytes(size, settings) +
                       sweep_scratch_bytes(size, settings, threads),
                   "visibility", "a larger cell or fewer directions need less");
}

enum class Reference { classified, exact };

Reference reference_of(const std::string& name)
{
    require(name == "classified" || name == "exact", "reference: \"{}\" is neither classified nor exact", name);
    return name == "exact" ? Reference::exact : Reference::classified;
}

std::shared_ptr<VisibilityHandle> brute_force(const VolumeHandle& volume, const TransferFunction& transfer_function,
                                              const VisibilitySettings& settings, const std::string& reference,
                                              double step_voxels, int threads)
{
    settings.validate();
    const Reference wanted = reference_of(reference);
    require_memory_for(volume.grid->size(), settings, 1);
    VisibilityGrid grid;
    run_interruptible(*make_arena(threads), [&](const std::atomic<bool>& cancel) {
        if (wanted == Reference::exact)
            grid = brute_force_visibility_exact(*volume.grid, transfer_function, settings.cell, settings.directions,
                                                step_voxels, &cancel);
        else
            grid = brute_force_visibility(
                classify_level(*volume.grid, transfer_function, 0, ExtinctionLayouts::straight, cancel), settings.cell,
                settings.directions, &cancel);
    });
    return handle_of(std::move(grid));
}

py::array_t<double> transmittance(const VolumeHandle& volume, const TransferFunction& transfer_function,
                                  const py::object& positions, const py::object& directions,
                                  const std::string& reference, double step_voxels, int threads)
{
    const Reference wanted = reference_of(reference);
    const auto [p, w] = rays_of(positions, directions);
    py::array_t<double> result(p.shape);
    double* out = result.mutable_data();
    const ScalarGrid& grid = *volume.grid;
    run_interruptible(*make_arena(threads), [&, &p = p, &w = w](const std::atomic<bool>& cancel) {
        ExtinctionGrid extinction;
        if (wanted == Reference::classified)
            extinction = classify_level(grid, transfer_function, 0, ExtinctionLayouts::straight, cancel);
        parallel_for(std::size_t(0), p.size(), [&](std::size_t i) {
            if (cancel)
                return;
            const Vec3d p_voxel = grid.voxel_from_world().point(p[i]);
            out[i] = wanted == Reference::exact
                         ? transmittance_exact(grid, transfer_function, p_voxel, w.direction(i), step_voxels)
                         : transmittance_classified(extinction, p_voxel, w.direction(i));
        });
    });
    return result;
}

py::array_t<double> cell_centres(const VolumeHandle& volume, int cell)
{
    require(cell >= 1 && cell <= 64, "cell: {} is not in 1 to 64 voxels", cell);
    const Vec3i size = volume.grid->size(), n = VisibilityGrid::cells_of(size, cell);
    py::array_t<double> array(Shape{n.z, n.y, n.x, 3});
    auto at = array.mutable_unchecked<4>();
    for (int k = 0; k < n.z; ++k)
        for (int j = 0; j < n.y; ++j)
            for (int i = 0; i < n.x; ++i) {
                const Vec3d p = volume.grid->world_from_voxel().point(
                    {(i + 0.5) * size.x / n.x, (j + 0.5) * size.y / n.y, (k + 0.5) * size.z / n.z});
                for (int axis = 0; axis < 3; ++axis)
                    at(k, j, i, axis) = component(p, axis);
            }
    return array;
}

} // namespace

ExtinctionGrid classify_level(const ScalarGrid& volume, const TransferFunction& transfer_function, int mip_level,
                              ExtinctionLayouts layouts, const std::atomic<bool>& cancel)
{
    return classify(volume, raw_range(volume), transfer_function, mip_level, layouts, &cancel);
}

std::shared_ptr<VisibilityHandle> sweep(const ScalarGrid& volume, const TransferFunction& transfer_function,
                                        const VisibilitySettings& settings, tbb::task_arena& arena)
{
    settings.validate();
    require_memory_for(volume.size(), settings, arena.max_concurrency());
    VisibilityGrid grid;
    SweepStats stats;
    double classify_s = 0.0;
    run_interruptible(arena, [&](const std::atomic<bool>& cancel) {
        ExtinctionGrid extinction;
        {
            const Stopwatch watch(classify_s);
            extinction = classify_level(volume, transfer_function, sweep_mip_level(volume.size(), settings.rays),
                                        ExtinctionLayouts::with_transposed, cancel);
        }
        if (cancel)
            return;
        grid = VisibilityGrid(volume.size(), settings.cell, settings.directions);
        stats = sweep_visibility(grid, extinction, settings, {}, &cancel);
    });
    std::shared_ptr<VisibilityHandle> handle = handle_of(std::move(grid));
    handle->stats = stats_of(stats, classify_s);
    return handle;
}

VisibilityGrid copy_of(const VisibilityGrid& grid, Vec3i volume_size, int cell)
{
    VisibilityGrid copy(volume_size, cell, grid.directions_per_side());
    require(copy.same_shape(grid), "visibility: {} x {} x {} cells do not fit cells of {} voxels", grid.cells().x,
            grid.cells().y, grid.cells().z, cell);
    for (int d = 0; d < grid.direction_count(); ++d)
        std::memcpy(copy.direction(d), grid.direction(d), grid.cell_count());
    return copy;
}

void bind_visibility(py::module_& module)
{
    const VisibilitySettings standard;
    py::class_<VisibilityHandle, std::shared_ptr<VisibilityHandle>>(
        module, "VisibilityGrid",
        "V [v, u, z, y, x] of 8 bits: row v and column u of the octahedral map, then the cell.")
        .def(py::init(&from_values), py::arg("values"), py::arg("volume"), py::kw_only(), py::arg("cell"),
             "values: uint8 (255 is visible) or floating point in [0, 1].")
        .def_property_readonly("values", &values_of,
                               "uint8 [n, n, cells z, cells y, cells x], a copy; V = values / 255.")
        .def_property_readonly(
            "cells", [](const VisibilityHandle& h) { return tuple_of(h.grid->cells()); }, "(x, y, z).")
        .def_property_readonly(
            "directions", [](const VisibilityHandle& h) { return h.grid->directions_per_side(); },
            "n of the n × n directions.")
        .def_readonly("stats", &VisibilityHandle::stats, "Of the sweep that made it, else empty.");
    module.def(
        "sweep_visibility",
        [](const VolumeHandle& volume, const TransferFunction& transfer_function, const VisibilitySettings& settings,
           int threads) { return sweep(*volume.grid, transfer_function, settings, *make_arena(threads)); },
        py::arg("volume"), py::arg("transfer_function"), py::arg("settings") = standard, py::kw_only(),
        py::arg("threads") = 0, "Journal paper, sections 6 and 8.");
    module.def("brute_force_visibility", &brute_force, py::arg("volume"), py::arg("transfer_function"),
               py::arg("settings") = standard, py::kw_only(), py::arg("reference") = "classified",
               py::arg("step_voxels") = 0.5, py::arg("threads") = 0,
               "One ray for every cell and direction, in double precision, rounded to 8 bits: slow.");
    module.def(
        "transmittance", &transmittance, py::arg("volume"), py::arg("transfer_function"), py::arg("positions"),
        py::arg("directions"), py::kw_only(), py::arg("reference") = "exact", py::arg("step_voxels") = 0.5,
        py::arg("threads") = 0,
        R"(From world positions [..., 3] along directions [..., 3] (broadcast) to the outside, in double precision.

"exact": the renderer's volume, interpolated and then classified, by midpoint steps of step_voxels. "classified": the sweeps'
volume, classified to 8 bits and then interpolated, integrated exactly. 1 from positions outside of the volume.)");
    module.def("cell_centres", &cell_centres, py::arg("volume"), py::kw_only(), py::arg("cell") = 4,
               "[z, y, x, 3]: where in the world a visibility grid's values are meant.");
}

} // namespace lumisweep::python
