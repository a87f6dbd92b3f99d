// The stages of a path, once for every lane type: start → advance → candidate → scatter, and the background where a
// camera segment leaves. Estimates interface "Radiometry": single scattering from the first collision along the camera
// ray,
//
//   L = ∫ T σt ρ [ ∫ (1/4π) V L_env dω ] dt + T(∞) L_env,
//
// by delta tracking for the collision (Woodcock 1965) and ratio tracking for V (Novák et al. 2014).
// No stage loops or returns by lane; each takes a mask and returns masks. Schedules belong to the backends.
// Bias: none. No step size, no cap on iterations.
#pragma once

#include "lumisweep/render/path_state.h"
#include "lumisweep/render/scene_view.h"
#include "lumisweep/render/tracking_stages.h"

namespace lumisweep {

/// Event numbers of random3(): 0 is the pixel and the lens, 1 the lens and the first free flight, then one per event.
inline constexpr int first_event_dimension = 2;

namespace stage {

template <class F>
LUMISWEEP_HD Vec3<F> broadcast(const Vec3f& v)
{
    return {F(v.x), F(v.y), F(v.z)};
}

/// Radiance of an environment texel.
template <class F>
LUMISWEEP_HD Vec3<F> texel_radiance(const EnvironmentView& environment, const int_of<F>& texel)
{
    const int_of<F> first = texel * int_of<F>(3);
    return {gather(environment.radiance, first), gather(environment.radiance + 1, first),
            gather(environment.radiance + 2, first)};
}

/// Radiance behind the volume in a path's direction. The lookup is shifted by up to half a texel at random, so that its
/// mean joins the texels' centres bilinearly: texels magnified many times would look like a staircase. Power is kept.
template <class F>
LUMISWEEP_HD Vec3<F> background_radiance(const SceneView& scene, const PathState<F>& path)
{
    const EnvironmentView& environment = scene.directions.environment;
    const Vec3<F> w = scene.world_from_voxel.apply(path.direction);
    const UV<F> uv = oct_from_direction(Vec3<F>(w * (F(1.0F) / sqrt(dot(w, w)))));
    const Random3<F> u = random3(path.key, path.dimension);
    const F texel = F(1.0F / static_cast<float>(1 << environment.levels));
    const UV<F> shifted = wrap_oct(UV<F>{fma(u.a - F(0.5F), texel, uv.u), fma(u.b - F(0.5F), texel, uv.v)});
    return texel_radiance<F>(environment, detail::node_of(shifted, environment.levels));
}

/// start: the camera ray of a pixel, clipped to the volume's box. Fills `path` for all lanes; returns which lanes meet
/// the box.
template <class F>
LUMISWEEP_HD mask_of<F> start(const SceneView& scene, const PassKey& pass, const int_of<F>& pixel_x,
                              const int_of<F>& pixel_y, PathState<F>& path)
{
    using I = int_of<F>;
    path.pixel = pixel_x + pixel_y * I(scene.camera.width);
    path.key = path_key<F>(path.pixel, pass.k0, pass.k1);
    const Random3<F> u = random3(path.key, I(0)), v = random3(path.key, I(1));
    const Ray<F> ray = camera_ray(scene.camera, to_float(pixel_x) + u.a, to_float(pixel_y) + u.b, u.c, v.a);

    const Vec3<F> d = scene.voxel_from_world.apply(ray.direction);
    path.direction = {nonzero(d.x), nonzero(d.y), nonzero(d.z)};
    const Vec3<F> o = scene.voxel_from_world.apply(ray.origin) + broadcast<F>(scene.camera.center_voxel);
    F enter = F(0.0F), leave = F(3.0e38F);
    const auto clip = [&](const F& origin, const F& direction, int n) {
        const F inverse = F(1.0F) / direction;
        const F a = (F(0.0F) - origin) * inverse, b = (F(static_cast<float>(n)) - origin) * inverse;
        enter = max(enter, min(a, b));
        leave = min(leave, max(a, b));
    };
    clip(o.x, path.direction.x, scene.size.x);
    clip(o.y, path.direction.y, scene.size.y);
    clip(o.z, path.direction.z, scene.size.z);
    const auto inside = [&](const F& origin, const F& direction, int n) {
        return min(max(fma(direction, enter, origin), F(0.0F)), F(static_cast<float>(n)));
    };
    path.origin = {inside(o.x, path.direction.x, scene.size.x), inside(o.y, path.direction.y, scene.size.y),
                   inside(o.z, path.direction.z, scene.size.z)};
    path.t = F(0.0F);
    path.optical_depth = exponential(v.b);
    path.transmittance = F(1.0F);
    path.weight = {enter, F(0.0F), F(0.0F)};
    path.cell = cell_at(scene, path.origin);
    path.segment = I(camera_segment);
    path.dimension = I(first_event_dimension);
    return enter < leave;
}

/// What the first collision tells the film.
template <class F>
struct Features {
    Vec3<F> albedo;
    Vec3<F> normal; ///< unit, world, against the gradient of extinction; 0 where there is none
    F depth;        ///< from the lens, world units
};

/// scatter: at a real collision, chooses the direction towards the light and turns the path into its shadow segment.
/// Returns the lanes whose light is not zero.
template <class F, class Voxel>
LUMISWEEP_HD mask_of<F> scatter(const SceneView& scene, const GridView<Voxel>& grid, const mask_of<F>& on,
                                PathState<F>& path, Features<F>& features)
{
    using I = int_of<F>;
    const F zero = F(0.0F);
    const Vec3<F> p_voxel = {fma(path.direction.x, path.t, path.origin.x), fma(path.direction.y, path.t, path.origin.y),
                             fma(path.direction.z, path.t, path.origin.z)};
    const ValueAndGradient<F> local = trilinear_gradient(grid, p_voxel);
    const MaterialSample<F> material = material_at(scene.transfer_function, local.value);

    // ∇_world f = (∂p_voxel / ∂p_world)ᵀ ∇_voxel f; extinction falls along the normal.
    const Vec3<F> gradient = scene.voxel_from_world.apply_transposed(local.gradient);
    const F length2 = dot(gradient, gradient);
    const F rise = material.extinction_slope * F(scene.transfer_function.slope);
    const F outwards = select(rise < zero, F(1.0F), F(-1.0F));
    const F scale = select(length2 > zero, outwards / sqrt(max(length2, F(1e-37F))), zero);
    features.albedo = material.albedo;
    features.normal = gradient * scale;
    features.depth = path.weight.x + path.t;

    const DirectionSample<F> light = sample_direction(scene.directions, p_voxel, random3(path.key, path.dimension));
    const Random3<F> flight = random3(path.key, path.dimension + I(1));
    const Vec3<F> radiance = texel_radiance<F>(scene.directions.environment, light.texel);
    // ρ · (1/4π) · L / pdf_omega with pdf_omega = pdf_uv / 4π.
    path.weight = material.albedo * radiance * (F(1.0F) / light.pdf_uv);
    const Vec3<F> d = scene.voxel_from_world.apply(direction_from_oct(light.uv_oct));
    path.direction = {nonzero(d.x), nonzero(d.y), nonzero(d.z)};
    path.origin = p_voxel;
    path.t = zero;
    path.transmittance = F(1.0F);
    path.optical_depth = exponential(flight.a);
    path.segment = I(shadow_segment);
    path.dimension = path.dimension + I(2);
    return on & (max(max(path.weight.x, path.weight.y), path.weight.z) > zero);
}

} // namespace stage

} // namespace lumisweep
