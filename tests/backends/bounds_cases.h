// Volumes and transfer functions over which bounds and majorants of the device are compared with the host's.
#pragma once

#include <limits>
#include <random>
#include <vector>

#include "lumisweep/backends/cuda/device_bounds.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep::test {

/// Odd sides, sides of 1, sides that end a block or a cell, more blocks along x than a block of threads takes.
inline const std::vector<Vec3i>& sizes_of_volumes()
{
    static const std::vector<Vec3i> sizes{{29, 14, 23}, {1, 1, 1},   {8, 8, 8},   {16, 7, 1},   {1, 17, 5},
                                          {6, 1, 40},   {64, 16, 9}, {65, 15, 8}, {150, 10, 24}};
    return sizes;
}

/// A scale of the world per voxel.
inline Affine3d voxels_of_side(double side)
{
    Affine3d a;
    for (Vec3d& column : a.column)
        column = column * side;
    return a;
}

template <class T, class Value>
ScalarGrid filled(VoxelType type, const Vec3i& size, const Affine3d& placement, double slope, double intercept,
                  Value&& value)
{
    ScalarGrid grid(type, size, placement, slope, intercept);
    for (std::size_t i = 0; i < grid.voxel_count(); ++i)
        grid.voxels<T>()[i] = static_cast<T>(value());
    return grid;
}

/// Volumes of that size in all types of voxels; values lie between −0.2 and 1.2 but for what fills and disturbs.
inline std::vector<ScalarGrid> volumes_of(const Vec3i& size, double side = 1.0)
{
    constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const Affine3d placement = voxels_of_side(side);
    std::mt19937 random(71);
    std::uniform_real_distribution<float> uniform;
    // Stretches of empty voxels, and of others.
    int left = 0;
    bool is_empty = false;
    const auto value = [&] {
        if (--left < 0) {
            left = static_cast<int>(random() % 400);
            is_empty = !is_empty;
        }
        return is_empty ? 0.0F : uniform(random);
    };
    std::vector<ScalarGrid> volumes;
    const auto add = [&](auto type_of, VoxelType type, double slope, double intercept, auto&& voxel) {
        volumes.push_back(filled<decltype(type_of)>(type, size, placement, slope, intercept, voxel));
    };
    add(std::uint8_t{}, VoxelType::u8, 1.0 / 255.0, 0.0, [&] { return 255.0F * value(); });
    add(std::uint16_t{}, VoxelType::u16, 1.0 / 65535.0, 0.0, [&] { return 65535.0F * value(); });
    add(std::uint16_t{}, VoxelType::u16, -1.0 / 3000.0, 1.1, [&] { return 3000.0F * value(); });
    add(std::int16_t{}, VoxelType::i16, 1.0 / 2000.0, 0.3, [&] { return 2000.0F * value() - 700.0F; });
    const auto add_floats = [&](double slope, auto&& voxel) { add(float{}, VoxelType::f32, slope, 0.0, voxel); };
    add_floats(1.0, value);
    add_floats(-0.37, [&] { return -2.0F * value(); });
    for (const float fill : {-9999.0F, -1e30F, 1e20F, nan})
        add_floats(1.0, [&] {
            const float v = value();
            return v == 0.0F ? fill : v;
        });
    add_floats(1.0, [&] { return random() % 50 == 0 ? inf : random() % 50 == 0 ? -inf : value(); });
    add_floats(1.0, [&] { return random() % 2 == 0 ? 3e38F : -3e38F; });
    add_floats(1.0, [&] { return random() % 2 == 0 ? -0.0F : 0.0F; });
    add_floats(1.0, [] { return nan; });
    add_floats(1.0, [] { return -inf; });
    add_floats(1.0, [] { return 0.4F; });
    return volumes;
}

/// Flanks, steps, none at all, many points.
inline std::vector<TransferFunction> transfer_functions()
{
    std::vector<TransferFunction> functions;
    functions.emplace_back();
    functions.emplace_back(std::vector<TransferPoint>{{0.0, 0.7}});
    functions.emplace_back(std::vector<TransferPoint>{{0.0, 0.0}, {1.0, 3.0}});
    functions.emplace_back(
        std::vector<TransferPoint>{{0.2, 0.0}, {0.25, 5.0}, {0.4, 1.0}, {0.4, 3.0}, {0.4, 2.0}, {0.95, 0.0}}, 0.3);
    functions.emplace_back(std::vector<TransferPoint>{{-0.1, 0.1}, {0.5, 0.4}, {0.5, 0.3}, {1.0, 1.0}}, 1e-3);
    functions.emplace_back(std::vector<TransferPoint>{{-1e4, 100.0}, {0.3, 0.0}, {0.9, 1e30}});
    std::mt19937 random(72);
    std::uniform_real_distribution<double> uniform;
    std::vector<TransferPoint> many;
    for (double v = -0.1; v < 1.1; v += uniform(random) * 1e-3)
        many.push_back({v, random() % 3 == 0 ? uniform(random) : 0.0});
    functions.emplace_back(many, 7.0);
    return functions;
}

/// A volume's voxels and its bounds on the device.
struct VolumeOnDevice {
    LUMISWEEP_CUDA::DeviceArray<std::byte> voxels;
    LUMISWEEP_CUDA::DeviceBounds bounds;

    VolumeOnDevice(const ScalarGrid& volume, const LUMISWEEP_CUDA::Stream& stream)
    {
        voxels.upload({volume.data(), volume.bytes()}, "voxels", stream);
        bounds.build(voxels.data(), volume, stream);
    }
};

} // namespace lumisweep::test
