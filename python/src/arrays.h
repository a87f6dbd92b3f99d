// NumPy arrays from and to what the library takes.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "lumisweep/base/error.h"
#include "lumisweep/math/vec.h"

namespace lumisweep::python {

namespace py = pybind11;

/// C-contiguous, converted where that is needed.
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Shape = std::vector<py::ssize_t>;

inline Shape shape_of(const py::array& array) { return Shape(array.shape(), array.shape() + array.ndim()); }

inline std::string text_of(const Shape& shape)
{
    std::string text = "[";
    for (std::size_t i = 0; i < shape.size(); ++i)
        text += (i > 0 ? ", " : "") + std::to_string(shape[i]);
    return text + "]";
}

/// Numbers from anything that NumPy takes for an array. Throws Error that names what was meant.
template <class Array = DoubleArray>
Array numbers(const py::handle& object, const char* name)
{
    Array array = Array::ensure(object);
    if (!array) {
        PyErr_Clear();
        fail("{}: is no array of numbers", name);
    }
    return array;
}

inline Vec3d vec3_of(const py::handle& object, const char* name)
{
    const DoubleArray array = numbers(object, name);
    require(array.ndim() == 1 && array.shape(0) == 3, "{}: has shape {} (give three numbers)", name,
            text_of(shape_of(array)));
    const Vec3d v{array.at(0), array.at(1), array.at(2)};
    require(std::isfinite(length(v)), "{}: is not finite", name);
    return v;
}

inline py::tuple tuple_of(const Vec3d& v) { return py::make_tuple(v.x, v.y, v.z); }
inline py::tuple tuple_of(const Vec3i& v) { return py::make_tuple(v.x, v.y, v.z); }

/// Vectors [..., 3] with the shape of what is before the last axis.
struct Vectors {
    DoubleArray array;
    Shape shape;

    std::size_t size() const { return static_cast<std::size_t>(array.size()) / 3; }
    Vec3d operator[](std::size_t i) const
    {
        return {array.data()[3 * i], array.data()[3 * i + 1], array.data()[3 * i + 2]};
    }
    /// Of unit length.
    Vec3d direction(std::size_t i) const { return normalized((*this)[i]); }
};

inline Vectors vectors_of(const py::handle& object, const char* name)
{
    Vectors vectors{numbers(object, name), {}};
    vectors.shape = shape_of(vectors.array);
    require(!vectors.shape.empty() && vectors.shape.back() == 3, "{}: has shape {} (give [..., 3])", name,
            text_of(vectors.shape));
    vectors.shape.pop_back();
    return vectors;
}

/// Likewise, all of them finite.
inline Vectors positions_of(const py::handle& object, const char* name)
{
    Vectors vectors = vectors_of(object, name);
    for (std::size_t i = 0; i < vectors.size(); ++i)
        require(std::isfinite(length(vectors[i])), "{}: number {} is not finite", name, i);
    return vectors;
}

/// Likewise, none of them zero or not finite.
inline Vectors directions_of(const py::handle& object, const char* name)
{
    Vectors vectors = vectors_of(object, name);
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const double l = length(vectors[i]);
        require(std::isfinite(l) && l > 0.0, "{}: number {} has the length {} (give unit vectors)", name, i, l);
    }
    return vectors;
}

/// Positions and directions brought to one shape by NumPy's rules.
inline std::pair<Vectors, Vectors> rays_of(const py::object& positions, const py::object& directions)
{
    const py::sequence both = py::module_::import("numpy").attr("broadcast_arrays")(
        positions_of(positions, "positions").array, directions_of(directions, "directions").array);
    return {vectors_of(both[0], "positions"), directions_of(both[1], "directions")};
}

inline Shape with(Shape shape, py::ssize_t last)
{
    shape.push_back(last);
    return shape;
}

inline py::array_t<double> matrix_of(const Affine3d& a, const Vec3d& offset)
{
    py::array_t<double> matrix(Shape{4, 4});
    auto m = matrix.mutable_unchecked<2>();
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            m(row, column) = component(a.column[column], row);
        m(row, 3) = component(offset, row);
        m(3, row) = 0.0;
    }
    m(3, 3) = 1.0;
    return matrix;
}

} // namespace lumisweep::python
