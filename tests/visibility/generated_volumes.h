// Small generated volumes that stand for what the sweeps meet.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/sweep.h"

namespace lumisweep::test {

inline Affine3d spaced(const Vec3d& voxel_sides)
{
    Affine3d a;
    for (int axis = 0; axis < 3; ++axis)
        a.column[static_cast<std::size_t>(axis)] =
            a.column[static_cast<std::size_t>(axis)] * component(voxel_sides, axis);
    return a;
}

/// Rotated, sheared, mirrored and moved.
inline Affine3d oblique()
{
    Affine3d a;
    a.column = {{{0.7, 0.5, -0.2}, {-0.6, 0.9, 0.1}, {0.1, 0.35, -1.4}}};
    a.offset = {-20.0, 3.0, 55.0};
    return a;
}

template <class Value>
ScalarGrid fill_i16(Vec3i size, const Affine3d& world_from_voxel, Value&& value)
{
    ScalarGrid grid(VoxelType::i16, size, world_from_voxel);
    std::int16_t* voxel = grid.voxels<std::int16_t>();
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                *voxel++ = static_cast<std::int16_t>(std::lround(value(i + 0.5, j + 0.5, k + 0.5)));
    return grid;
}

/// Soft tissue in a wobbly shell of bone, a tube, and two metal wires, in HU; sides of about 100 voxels.
inline ScalarGrid ct_volume(Vec3i size, const Affine3d& world_from_voxel)
{
    return fill_i16(size, world_from_voxel, [&](double i, double j, double k) {
        const double x = 2.0 * i / size.x - 1.0, y = 2.0 * j / size.y - 1.0, z = 2.0 * k / size.z - 1.0;
        const double radius = 0.78 + 0.05 * std::sin(9.0 * x + 3.0 * z) + 0.04 * std::sin(7.0 * y - 5.0 * x);
        const auto bump = [&](double distance, double width_voxels) {
            const double d = 0.5 * size.x * distance / width_voxels;
            return std::exp(-0.5 * d * d);
        };
        const double r = std::sqrt(x * x + y * y + z * z);
        double hu = r < radius ? 40.0 : -1000.0;
        hu = std::max(hu, -1000.0 + 2200.0 * bump(r - radius, 2.5));
        hu += 700.0 * bump(std::hypot(x - 0.2, y) - 0.3, 2.0) * (std::fabs(z) < 0.5 ? 1.0 : 0.0);
        hu += 1800.0 * bump(std::hypot(y + 0.4 - 0.2 * x, z - 0.3 * x), 1.2) +
              1800.0 * bump(std::hypot(x + 0.5, z + 0.1 * y), 1.2);
        return std::clamp(hu, -1024.0, 3000.0);
    });
}

inline ScalarGrid smoke_volume(Vec3i size, const Affine3d& world_from_voxel)
{
    return fill_i16(size, world_from_voxel, [&](double i, double j, double k) {
        const double x = 2.0 * i / size.x - 1.0, y = 2.0 * j / size.y - 1.0, z = 2.0 * k / size.z - 1.0;
        const double density = 500.0 + 300.0 * std::sin(5.0 * x + 2.0 * y) + 200.0 * std::sin(9.0 * z - 4.0 * x * y);
        return std::max(0.0, (1.0 - x * x - y * y - z * z) * density);
    });
}

/// Bone opaque within a few of ct_volume's voxels of 1 world unit, soft tissue empty.
inline TransferFunction bone() { return TransferFunction({{150.0, 0.0}, {600.0, 0.4}, {1500.0, 1.0}}); }
/// Optical depths of about 3 across smoke_volume of about 100 world units.
inline TransferFunction smoke() { return TransferFunction({{0.0, 0.0}, {1000.0, 0.12}}); }

/// With the volume's own range.
inline ExtinctionGrid classified(const ScalarGrid& volume, const TransferFunction& transfer_function, int mip_level = 0,
                                 ExtinctionLayouts layouts = ExtinctionLayouts::with_transposed)
{
    return classify(volume, raw_range(volume), transfer_function, mip_level, layouts);
}

/// Of all voxels, in stored steps.
inline double total(const ExtinctionGrid& grid) { return std::accumulate(grid.stored.begin(), grid.stored.end(), 0.0); }

/// A medium of one extinction.
inline ExtinctionGrid homogeneous(Vec3i size, const Affine3d& world_from_voxel, double sigma)
{
    const ScalarGrid volume = fill_i16(size, world_from_voxel, [](double, double, double) { return 7.0; });
    return classified(volume, TransferFunction({{7.0, sigma}}));
}

inline VisibilityGrid swept(const ExtinctionGrid& extinction, const VisibilitySettings& settings)
{
    VisibilityGrid grid(extinction.volume_size, settings.cell, settings.directions);
    sweep_visibility(grid, extinction, settings);
    return grid;
}

} // namespace lumisweep::test
