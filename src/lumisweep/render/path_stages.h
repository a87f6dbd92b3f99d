// The stages of a path, once for every lane type: start → advance → candidate → (collide → aim, light_stages.h), and
// the background where a camera segment leaves. Estimates interface "Radiometry": single scattering from the first
// collision along the camera ray,
//
//   L = ∫ T σt ρ [ ∫ (1/4π) V L_env dω ] dt + T(∞) L_env,
//
// by tentative collisions (Woodcock 1965): along camera rays their ratios give an estimate of T (ratio tracking, Novák
// et al. 2014), and a collision is where 1 − T passes a number that is drawn once a ray. On average that is delta
// tracking to the last bit of its distribution, since the chance of ending at a tentative collision is the mean fall of
// T there; but being one number it can be stratified over a pixel's samples, and several of them spread over the
// opacity of one ray share its cost. Along shadow rays ratio tracking gives V. No stage loops or returns by lane; each
// takes a mask and returns masks. Schedules belong to the backends. Bias: none. No step size, no cap on iterations.
#pragma once

#include "lumisweep/render/path_numbers.h"
#include "lumisweep/render/path_state.h"
#include "lumisweep/render/scene_view.h"
#include "lumisweep/render/tracking_stages.h"

namespace lumisweep {

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
LUMISWEEP_HD mask_of<F> start(const SceneView& scene, const PassNumbers& pass, const int_of<F>& pixel_x,
                              const int_of<F>& pixel_y, PathState<F>& path)
{
    using I = int_of<F>;
    path.pixel = pixel_x + pixel_y * I(scene.camera.width);
    path.key = path_key<F>(path.pixel, pass.sample.k0, pass.sample.k1);
    const Random3<F> u = numbers(scene, pass, path, I(pass.index), NumberUse::pixel_and_depth);
    const Random3<F> v = numbers(scene, pass, path, I(pass.index), NumberUse::lens_and_flight);
    const Ray<F> ray = camera_ray(scene.camera, to_float(pixel_x) + u.a, to_float(pixel_y) + u.b, v.a, v.b);

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
    path.optical_depth = exponential(v.c);
    path.transmittance = F(1.0F);
    path.weight = {enter, F(1.0F) - u.c, F(1.0F)};
    path.cell = cell_at(scene, path.origin);
    path.segment = I(camera_segment);
    path.dimension = I(first_event_dimension);
    return enter < leave;
}

} // namespace stage

} // namespace lumisweep
