// The stages at a collision: collide → aim, once for every lane type. Collide looks up what scatters, aim chooses a
// direction towards the light and makes the shadow ray.
#pragma once

#include "lumisweep/render/path_numbers.h"
#include "lumisweep/render/path_stages.h"

namespace lumisweep::stage {

/// What the film is told of a collision.
template <class F>
struct Features {
    Vec3<F> albedo;
    Vec3<F> normal; ///< unit, world, against the gradient of extinction; 0 where there is none
    F depth;        ///< from the lens, world units
};

/// collide: the material at a camera ray's collision.
template <class F, class Voxel>
LUMISWEEP_HD Features<F> collide(const SceneView& scene, const GridView<Voxel>& grid, const PathState<F>& path)
{
    const F zero = F(0.0F);
    const ValueAndGradient<F> local = trilinear_gradient(grid, position_of(path));
    const MaterialSample<F> material = material_at(scene.transfer_function, local.value);

    // ∇_world f = (∂p_voxel / ∂p_world)ᵀ ∇_voxel f; extinction falls along the normal.
    const Vec3<F> gradient = scene.voxel_from_world.apply_transposed(local.gradient);
    const F length2 = dot(gradient, gradient);
    const F rise = material.extinction_slope * F(scene.transfer_function.slope);
    const F outwards = select(rise < zero, F(1.0F), F(-1.0F));
    const F scale = select(length2 > zero, outwards / sqrt(max(length2, F(1e-37F))), zero);
    return {material.albedo, gradient * scale, path.lens_to_box() + path.t};
}

/// aim: turns the camera ray's collision number n (0 … shadow_rays − 1, the nearest first) into its shadow ray. Returns
/// the lanes whose light is not zero.
template <class F>
LUMISWEEP_HD mask_of<F> aim(const SceneView& scene, const PassNumbers& pass, const mask_of<F>& on, const int_of<F>& n,
                            const Vec3<F>& albedo, PathState<F>& path)
{
    using I = int_of<F>;
    const Vec3<F> p_voxel = position_of(path);
    path.key = shadow_key(path.key, n);
    const DirectionSample<F> light = sample_direction(
        scene.directions, p_voxel, numbers(scene, pass, path, I(pass.index * scene.shadow_rays) + n, NumberUse::light));
    const Vec3<F> radiance = texel_radiance<F>(scene.directions.environment, light.texel);
    // ρ · (1/4π) · L / pdf_omega with pdf_omega = pdf_uv / 4π; each of the collisions stands for an equal part.
    const F part = F(1.0F / static_cast<float>(scene.shadow_rays));
    path.weight = albedo * radiance * (part / light.pdf_uv);
    const Vec3<F> d = scene.voxel_from_world.apply(direction_from_oct(light.uv_oct));
    path.direction = {nonzero(d.x), nonzero(d.y), nonzero(d.z)};
    path.origin = p_voxel;
    path.t = F(0.0F);
    path.transmittance = F(1.0F);
    path.dimension = I(first_event_dimension);
    path.optical_depth = exponential(random3(path.key, path.dimension).a);
    path.segment = I(shadow_segment);
    path.dimension = path.dimension + I(1);
    return on & (max(max(path.weight.x, path.weight.y), path.weight.z) > F(0.0F));
}

} // namespace lumisweep::stage
