// Generated volumes: what tests need of the CT head and of smoke, without any file.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>

#include "lumisweep/volume/grid_view.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::test {

/// world_from_voxel of voxels with these sides whose box is centred at `center`.
inline Affine3d centered(const Vec3i& size, const Vec3d& spacing, const Vec3d& center = {0.0, 0.0, 0.0})
{
    Affine3d a;
    a.column = {{{spacing.x, 0.0, 0.0}, {0.0, spacing.y, 0.0}, {0.0, 0.0, spacing.z}}};
    a.offset = center - Vec3d{0.5 * size.x * spacing.x, 0.5 * size.y * spacing.y, 0.5 * size.z * spacing.z};
    return a;
}

/// A grid whose voxel (i, j, k) is value(i, j, k), raw.
template <class T, class Function>
std::shared_ptr<ScalarGrid> make_grid(VoxelType type, const Vec3i& size, const Affine3d& world_from_voxel,
                                      Function&& value, double slope = 1.0, double intercept = 0.0)
{
    auto grid = std::make_shared<ScalarGrid>(type, size, world_from_voxel, slope, intercept);
    T* voxel = grid->voxels<T>();
    for (int k = 0; k < size.z; ++k)
        for (int j = 0; j < size.y; ++j)
            for (int i = 0; i < size.x; ++i)
                *voxel++ = static_cast<T>(value(i, j, k));
    return grid;
}

/// For lookups in all of it.
template <class T>
GridView<T> view_of(const ScalarGrid& grid)
{
    const Vec3i n = grid.size();
    return {grid.voxels<T>(), n.x, n.y, n.z, n.y > 1 ? n.x : 0, n.z > 1 ? n.x * n.y : 0, n.x > 1 ? 1 : 0};
}

/// One value everywhere.
inline std::shared_ptr<ScalarGrid> constant_grid(const Vec3i& size, const Affine3d& world_from_voxel, double raw = 1.0)
{
    return make_grid<float>(VoxelType::f32, size, world_from_voxel, [&](int, int, int) { return raw; });
}

/// Like a CT head: air, soft tissue within nested steep shells of bone, and thin wires of metal; values in HU.
inline std::shared_ptr<ScalarGrid> ct_like(const Vec3i& size, const Affine3d& world_from_voxel)
{
    return make_grid<std::int16_t>(VoxelType::i16, size, world_from_voxel, [&](int i, int j, int k) {
        const double x = (i + 0.5) / size.x * 2.0 - 1.0, y = (j + 0.5) / size.y * 2.0 - 1.0,
                     z = (k + 0.5) / size.z * 2.0 - 1.0;
        const double r = std::sqrt(x * x + 1.3 * y * y + z * z);
        double hu = -1000.0;
        if (r < 0.9)
            hu = 40.0 + 20.0 * std::sin(9.0 * x) * std::cos(7.0 * z);
        if ((r > 0.72 && r < 0.84 && z > -0.5) || (r > 0.3 && r < 0.4))
            hu = 1200.0;
        if (std::hypot(x - 0.5, y + 0.2) < 0.06 || std::hypot(y - 0.1, z - 0.55) < 0.06)
            hu = 3000.0;
        return std::lround(hu);
    });
}

/// A transfer function for ct_like: skin faint, bone and metal dense, with steep flanks. Extinction per voxel of
/// side 1.
inline TransferFunction ct_transfer_function(double scale = 1.0)
{
    return TransferFunction({{-300.0, 0.0, {0.9, 0.7, 0.6}},
                             {0.0, 0.02, {0.9, 0.7, 0.6}},
                             {300.0, 0.03, {0.9, 0.7, 0.6}},
                             {700.0, 2.0, {0.95, 0.9, 0.85}},
                             {1600.0, 2.5, {0.95, 0.9, 0.85}},
                             {2000.0, 8.0, {0.6, 0.65, 0.7}}},
                            scale);
}

/// Like smoke: soft blobs, 8 bits.
inline std::shared_ptr<ScalarGrid> smoke_like(const Vec3i& size, const Affine3d& world_from_voxel)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0.15, 0.85);
    struct Blob {
        double x, y, z, radius;
    };
    Blob blobs[12];
    for (Blob& b : blobs)
        b = {uniform(random), uniform(random), uniform(random), 0.08 + 0.12 * uniform(random)};
    return make_grid<std::uint8_t>(VoxelType::u8, size, world_from_voxel, [&](int i, int j, int k) {
        double density = 0.0;
        for (const Blob& b : blobs) {
            const double dx = (i + 0.5) / size.x - b.x, dy = (j + 0.5) / size.y - b.y, dz = (k + 0.5) / size.z - b.z;
            density += std::exp(-(dx * dx + dy * dy + dz * dz) / (b.radius * b.radius));
        }
        return std::min(std::lround(110.0 * density), 255L);
    });
}

inline TransferFunction smoke_transfer_function(double scale = 1.0)
{
    return TransferFunction({{10.0, 0.0, {0.8, 0.85, 0.9}}, {255.0, 0.6, {0.95, 0.95, 0.95}}}, scale);
}

} // namespace lumisweep::test
