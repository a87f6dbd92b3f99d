// The scene as kernels read it: plain structs of pointers and numbers that a session fills and a device may mirror.
#pragma once

#include <cstdint>

#include "lumisweep/math/random.h"
#include "lumisweep/render/camera_view.h"
#include "lumisweep/render/pass.h"
#include "lumisweep/sampling/direction_sampling.h"
#include "lumisweep/volume/grid_view.h"
#include "lumisweep/volume/majorant_view.h"
#include "lumisweep/volume/transfer_function_view.h"
#include "lumisweep/volume/voxel_type.h"

namespace lumisweep {

/// A linear map of vectors in single precision, by columns.
struct Linear3f {
    Vec3f x, y, z;

    template <class F>
    LUMISWEEP_HD Vec3<F> apply(const Vec3<F>& v) const
    {
        return {fma(F(x.x), v.x, fma(F(y.x), v.y, F(z.x) * v.z)), fma(F(x.y), v.x, fma(F(y.y), v.y, F(z.y) * v.z)),
                fma(F(x.z), v.x, fma(F(y.z), v.y, F(z.z) * v.z))};
    }
    /// The transposed map: what a gradient needs.
    template <class F>
    LUMISWEEP_HD Vec3<F> apply_transposed(const Vec3<F>& v) const
    {
        return {fma(F(x.x), v.x, fma(F(x.y), v.y, F(x.z) * v.z)), fma(F(y.x), v.x, fma(F(y.y), v.y, F(y.z) * v.z)),
                fma(F(z.x), v.x, fma(F(z.y), v.y, F(z.z) * v.z))};
    }
};

enum class BackgroundLight { shown, hidden };

struct SceneView {
    VoxelType voxel_type = VoxelType::u8;
    const void* voxels = nullptr; ///< [size.z][size.y][size.x], see volume/grid_view.h
    Vec3i size{0, 0, 0};
    Linear3f voxel_from_world, world_from_voxel; ///< of vectors
    TransferFunctionView transfer_function;
    MajorantView majorants;
    DirectionSamplingView directions;
    CameraView camera;
    BackgroundLight background = BackgroundLight::shown;
    Draws draws = Draws::independent;
    int shadow_rays = 1; ///< collisions a camera ray
    std::uint64_t seed = 0;
};

template <class Voxel>
LUMISWEEP_HD GridView<Voxel> grid_view(const SceneView& scene)
{
    GridView<Voxel> view;
    view.voxels = static_cast<const Voxel*>(scene.voxels);
    view.nx = scene.size.x;
    view.ny = scene.size.y;
    view.nz = scene.size.z;
    view.stride_y = scene.size.y > 1 ? scene.size.x : 0;
    view.stride_z = scene.size.z > 1 ? scene.size.x * scene.size.y : 0;
    view.x_step = scene.size.x > 1 ? 1 : 0;
    return view;
}

} // namespace lumisweep
