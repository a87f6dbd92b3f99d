#include <filesystem>
#include <optional>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "bindings.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep::python {

namespace {

namespace fs = std::filesystem;

const Vec3d first_centre{0.5, 0.5, 0.5}; // p_voxel of the sample of voxel 0

/// The library's map of voxel corners from a 4 × 4 matrix that maps indices of voxel centres.
Affine3d world_from_voxel(const py::object& matrix)
{
    const DoubleArray array = numbers(matrix, "affine");
    require(array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4,
            "affine: has shape {} (give 4 x 4 numbers)", text_of(shape_of(array)));
    require(array.at(3, 0) == 0.0 && array.at(3, 1) == 0.0 && array.at(3, 2) == 0.0 && array.at(3, 3) == 1.0,
            "affine: its last row is not 0 0 0 1");
    Affine3d a;
    for (int column = 0; column < 3; ++column)
        a.column[column] = {array.at(0, column), array.at(1, column), array.at(2, column)};
    const Vec3d offset{array.at(0, 3), array.at(1, 3), array.at(2, 3)};
    a.offset = offset - a.vector(first_centre);
    return a;
}

Affine3d world_from_voxel(const Vec3d& spacing, const Vec3d& origin)
{
    Affine3d a;
    a.column[0] = {spacing.x, 0.0, 0.0};
    a.column[1] = {0.0, spacing.y, 0.0};
    a.column[2] = {0.0, 0.0, spacing.z};
    a.offset = origin - a.vector(first_centre);
    return a;
}

Affine3d placed(const py::object& spacing, const py::object& origin, const py::object& affine)
{
    if (affine.is_none())
        return world_from_voxel(spacing.is_none() ? Vec3d{1.0, 1.0, 1.0} : vec3_of(spacing, "spacing"),
                                origin.is_none() ? Vec3d{0.0, 0.0, 0.0} : vec3_of(origin, "origin"));
    require(spacing.is_none() && origin.is_none(), "volume: affine says it all (leave out spacing and origin)");
    return world_from_voxel(affine);
}

StoredType stored_type(const py::dtype& type)
{
    const auto by_size = [&](StoredType one, StoredType two, StoredType four, StoredType eight) {
        switch (type.itemsize()) {
        case 1: return one;
        case 2: return two;
        case 4: return four;
        default: return eight;
        }
    };
    switch (type.kind()) {
    case 'b': return StoredType::u8;
    case 'u': return by_size(StoredType::u8, StoredType::u16, StoredType::u32, StoredType::u64);
    case 'i': return by_size(StoredType::i8, StoredType::i16, StoredType::i32, StoredType::i64);
    case 'f':
        if (type.itemsize() == 4)
            return StoredType::f32;
        if (type.itemsize() == 8)
            return StoredType::f64;
        break;
    default: break;
    }
    fail("voxels: of type {}, which is no scalar that a volume can have (convert them with astype)",
         py::str(static_cast<const py::object&>(type)).cast<std::string>());
}

/// Keeps a Python object alive from wherever the last copy is let go; at the interpreter's end nothing is freed.
std::shared_ptr<const void> keep(const py::object& object)
{
    return {object.inc_ref().ptr(), [](PyObject* held) {
                if (interpreter_is_ending())
                    return;
                const py::gil_scoped_acquire acquire;
                Py_DECREF(held);
            }};
}

/// Whether NumPy looks into an object's memory rather than filling an array from it.
bool has_memory_of_its_own(const py::object& object)
{
    return PyObject_CheckBuffer(object.ptr()) != 0 || py::hasattr(object, "__array_interface__") ||
           py::hasattr(object, "__array_struct__") || py::hasattr(object, "__array__");
}

Sharing sharing_of(std::optional<bool> copy)
{
    return !copy ? Sharing::where_possible : *copy ? Sharing::never : Sharing::required;
}

std::shared_ptr<VolumeHandle> from_array(const py::object& voxels, const py::object& spacing, const py::object& origin,
                                         const py::object& affine, double slope, double intercept,
                                         std::optional<bool> copy)
{
    require(!py::hasattr(voxels, "mask") || !py::hasattr(voxels, "filled"),
            "voxels: are masked (say what stands behind the mask: voxels.filled(value))");
    const py::array given = py::array::ensure(voxels);
    if (!given) {
        PyErr_Clear();
        fail("voxels: is no array of numbers");
    }
    require(given.ndim() == 3, "voxels: has shape {} (give [z, y, x])", text_of(shape_of(given)));
    const bool is_half = given.dtype().kind() == 'f' && given.itemsize() == 2;
    const py::array dense =
        py::array::ensure(is_half ? py::array(given.attr("astype")("float32")) : given, py::array::c_style);
    // A copy that was made on the way is the library's to keep.
    const bool made = !has_memory_of_its_own(voxels) || dense.data() != given.data();
    require(copy != false || !made, "voxels: cannot be shared, they are not C-contiguous [z, y, x] (allow a copy)");

    ArrayVoxels array;
    array.owner = keep(dense);
    array.data = static_cast<const std::byte*>(dense.data());
    array.type = stored_type(dense.dtype());
    array.order = dense.dtype().attr("isnative").cast<bool>() ? ByteOrder::native : ByteOrder::swapped;
    const auto side = [&](int axis) {
        require(dense.shape(axis) <= 8192, "voxels: has shape {}, more than 8192 along an axis (crop or downsample)",
                text_of(shape_of(dense)));
        return static_cast<int>(dense.shape(axis));
    };
    array.size = {side(2), side(1), side(0)};
    array.world_from_voxel = placed(spacing, origin, affine);
    array.slope = slope;
    array.intercept = intercept;
    const Sharing sharing = made ? Sharing::where_possible : sharing_of(copy);
    ArrayVolume volume;
    {
        const py::gil_scoped_release release;
        volume = volume_from_array(array, sharing);
    }
    auto handle = std::make_shared<VolumeHandle>();
    handle->shared = !made && !volume.grid.owns_voxels();
    handle->grid = std::make_shared<const ScalarGrid>(std::move(volume.grid));
    handle->warnings = std::move(volume.warnings);
    return handle;
}

std::vector<fs::path> paths_of(const py::object& files)
{
    try {
        return files.cast<std::vector<fs::path>>();
    } catch (const py::cast_error&) {
        fail("files: is neither a path nor a list of paths");
    }
}

std::shared_ptr<VolumeHandle> load(const py::object& files, int frame)
{
    VolumeRequest request;
    request.frame = frame;
    if (py::isinstance<py::str>(files) || py::hasattr(files, "__fspath__"))
        request.files = volume_request({{files.cast<fs::path>()}, frame}).files;
    else
        request.files = paths_of(files);
    const py::gil_scoped_release release;
    LoadedVolume loaded = load_volume(request);
    auto handle = std::make_shared<VolumeHandle>();
    handle->grid = std::make_shared<const ScalarGrid>(std::move(loaded.grid));
    handle->modality = loaded.modality;
    handle->frames = loaded.frames;
    handle->warnings = std::move(loaded.warnings);
    return handle;
}

py::dtype dtype_of(VoxelType type)
{
    switch (type) {
    case VoxelType::u8: return py::dtype::of<std::uint8_t>();
    case VoxelType::u16: return py::dtype::of<std::uint16_t>();
    case VoxelType::i16: return py::dtype::of<std::int16_t>();
    default: return py::dtype::of<float>();
    }
}

py::array voxels_of(const py::object& self)
{
    const ScalarGrid& grid = *self.cast<const VolumeHandle&>().grid;
    const Vec3i n = grid.size();
    py::array voxels(dtype_of(grid.type()), Shape{n.z, n.y, n.x}, grid.data(), self);
    voxels.attr("setflags")(py::arg("write") = false);
    return voxels;
}

py::array_t<double> affine_of(const Affine3d& world_from_voxel)
{
    return matrix_of(world_from_voxel, world_from_voxel.point(first_centre));
}

py::array_t<double> interpolate(const VolumeHandle& volume, const py::object& positions)
{
    const Vectors p = vectors_of(positions, "positions");
    py::array_t<double> values(p.shape);
    double* out = values.mutable_data();
    const py::gil_scoped_release release;
    parallel_for(
        std::size_t(0), p.size(),
        [&](std::size_t i) { out[i] = volume.grid->interpolate(volume.grid->voxel_from_world().point(p[i])); }, 256);
    return values;
}

py::dict inspect(const fs::path& file)
{
    const VolumeHeader header = inspect_volume(file);
    py::dict info;
    info["format"] = header.format;
    info["voxel_type"] = header.voxel_type;
    info["modality"] = header.modality;
    info["size"] = tuple_of(header.size);
    info["spacing"] = tuple_of(header.spacing);
    info["affine"] = affine_of(header.world_from_voxel);
    info["frames"] = header.frames;
    info["slope"] = header.slope;
    info["intercept"] = header.intercept;
    info["warnings"] = header.warnings;
    return info;
}

} // namespace

void bind_volume(py::module_& module)
{
    const py::none none;

    py::class_<VolumeHandle, std::shared_ptr<VolumeHandle>>(module, "Volume",
                                                            "A regular grid of scalar voxels, placed in the world.")
        .def(py::init(&from_array), py::arg("voxels"), py::kw_only(), py::arg("spacing") = none,
             py::arg("origin") = none, py::arg("affine") = none, py::arg("slope") = 1.0, py::arg("intercept") = 0.0,
             py::arg("copy") = none,
             R"(From an array [z, y, x]; value = slope · voxel + intercept, in the data's own units.

spacing and origin (the first voxel's centre) are (x, y, z) in world units; affine (4 × 4) instead maps the index (i, j, k) of
a voxel's centre along x, y, z to the world. The array's memory is shared where its type (uint8, uint16, int16, float32) and
layout allow; copy=False insists on it, copy=True never does.)")
        .def_static(
            "load", &load, py::arg("files"), py::kw_only(), py::arg("frame") = 0,
            "NRRD, MetaImage, NIfTI, a DICOM folder, or several files: a time series, of which `frame` is read.")
        .def_property_readonly(
            "shape",
            [](const VolumeHandle& v) {
                const Vec3i n = v.grid->size();
                return py::make_tuple(n.z, n.y, n.x);
            },
            "(z, y, x) voxels.")
        .def_property_readonly("dtype", [](const VolumeHandle& v) { return dtype_of(v.grid->type()); })
        .def_property_readonly("voxels", &voxels_of, "[z, y, x], read-only, not copied.")
        .def_readonly("shared", &VolumeHandle::shared, "Whether the voxels are the caller's array.")
        .def_property_readonly(
            "affine", [](const VolumeHandle& v) { return affine_of(v.grid->world_from_voxel()); },
            "4 × 4: index (i, j, k) of a voxel's centre to the world.")
        .def_property_readonly(
            "spacing",
            [](const VolumeHandle& v) {
                const auto& columns = v.grid->world_from_voxel().column;
                return py::make_tuple(length(columns[0]), length(columns[1]), length(columns[2]));
            },
            "World units, (x, y, z).")
        .def_property_readonly("slope", [](const VolumeHandle& v) { return v.grid->slope(); })
        .def_property_readonly("intercept", [](const VolumeHandle& v) { return v.grid->intercept(); })
        .def_readonly("modality", &VolumeHandle::modality, "DICOM's code or empty.")
        .def_readonly("warnings", &VolumeHandle::warnings, "What reading or converting met, one line each.")
        .def("__repr__",
             [](const VolumeHandle& v) {
                 const Vec3i n = v.grid->size();
                 return fmt::format("<Volume of {} x {} x {} voxels (x, y, z), {}>", n.x, n.y, n.z,
                                    name_of(v.grid->type()));
             })
        .def("interpolate", &interpolate, py::arg("positions"),
             "Trilinear values in data units at world positions [..., 3]; NaN where a NaN voxel takes part.");
    module.def("inspect_volume", &inspect, py::arg("file"), "What a file's header says; no voxel is read.");
}

} // namespace lumisweep::python
