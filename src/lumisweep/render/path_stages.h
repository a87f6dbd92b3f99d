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

namespace lumisweep {

/// Below this transmittance shadow segments play Russian roulette.
inline constexpr float roulette_threshold = 0.1F;

namespace stage {

template <class F>
LUMISWEEP_HD Vec3<F> broadcast(const Vec3f& v)
{
    return {F(v.x), F(v.y), F(v.z)};
}

/// Optical depth of a free flight.
template <class F>
LUMISWEEP_HD F exponential(const F& u)
{
    return F(0.0F) - log(F(1.0F) - u);
}

/// Where a path stands, in voxels.
template <class F>
LUMISWEEP_HD Vec3<F> position_of(const PathState<F>& path)
{
    return {fma(path.direction.x, path.t, path.origin.x), fma(path.direction.y, path.t, path.origin.y),
            fma(path.direction.z, path.t, path.origin.z)};
}

template <class F>
struct CellXYZ {
    int_of<F> x, y, z;
};

template <class F>
LUMISWEEP_HD int_of<F> pack_cell(const CellXYZ<F>& c)
{
    return c.x | shift_left<11>(c.y) | shift_left<22>(c.z);
}
template <class F>
LUMISWEEP_HD CellXYZ<F> unpack_cell(const int_of<F>& cell)
{
    using I = int_of<F>;
    return {cell & I(2047), shift_right<11>(cell) & I(2047), shift_right<22>(cell)};
}

/// Directions without exact zeros, so that reciprocals stay finite.
template <class F>
LUMISWEEP_HD F nonzero(const F& d)
{
    return select(abs(d) < F(1e-20F), copysign(F(1e-20F), d), d);
}

template <class F>
LUMISWEEP_HD int_of<F> cell_at(const SceneView& scene, const Vec3<F>& p_voxel)
{
    using I = int_of<F>;
    const auto axis = [](const F& p, int n) { return min(max(to_int(p * F(1.0F / majorant_cell)), I(0)), I(n - 1)); };
    return pack_cell<F>({axis(p_voxel.x, scene.majorants.nx), axis(p_voxel.y, scene.majorants.ny),
                         axis(p_voxel.z, scene.majorants.nz)});
}

template <class F>
LUMISWEEP_HD F majorant_at(const SceneView& scene, const int_of<F>& cell)
{
    using I = int_of<F>;
    const CellXYZ<F> c = unpack_cell<F>(cell);
    return gather(scene.majorants.majorant, c.x + (c.y + c.z * I(scene.majorants.ny)) * I(scene.majorants.nx));
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

template <class F>
struct Advanced {
    mask_of<F> candidate; ///< stands at a tentative collision
    mask_of<F> left;      ///< has left the volume
};

/// advance: through one majorant cell: to the tentative collision if the flight ends within it, else into the next
/// cell.
template <class F>
LUMISWEEP_HD Advanced<F> advance(const SceneView& scene, const mask_of<F>& on, PathState<F>& path)
{
    using I = int_of<F>;
    const CellXYZ<F> cell = unpack_cell<F>(path.cell);
    const F zero = F(0.0F);
    // The last cell may be larger than what is left of the volume: the volume's box ends the medium.
    const auto exit_at = [&](const F& origin, const F& direction, const I& c, int n) {
        const F edge = to_float(c + select(direction > zero, I(1), I(0))) * F(static_cast<float>(majorant_cell));
        return (min(edge, F(static_cast<float>(n))) - origin) / direction;
    };
    const F tx = exit_at(path.origin.x, path.direction.x, cell.x, scene.size.x);
    const F ty = exit_at(path.origin.y, path.direction.y, cell.y, scene.size.y);
    const F tz = exit_at(path.origin.z, path.direction.z, cell.z, scene.size.z);
    const F t_exit = max(min(min(tx, ty), tz), path.t);

    const F majorant = majorant_at<F>(scene, path.cell);
    const F depth = majorant * (t_exit - path.t);
    const mask_of<F> hit = path.optical_depth < depth;
    const mask_of<F> candidate = on & hit;
    const mask_of<F> moves = on & !hit;
    path.t = select(candidate, path.t + path.optical_depth / majorant, select(moves, t_exit, path.t));
    path.optical_depth = select(moves, path.optical_depth - depth, path.optical_depth);

    // Into the neighbour across the nearest side; ties go to x, then y.
    const mask_of<F> step_x = (tx <= ty) & (tx <= tz);
    const mask_of<F> step_y = (!step_x) & (ty <= tz);
    const mask_of<F> step_z = !(step_x | step_y);
    const auto next = [&](const I& c, const F& direction, const mask_of<F>& step) {
        return c + select(step, select(direction > zero, I(1), I(-1)), I(0));
    };
    const CellXYZ<F> to = {next(cell.x, path.direction.x, step_x), next(cell.y, path.direction.y, step_y),
                           next(cell.z, path.direction.z, step_z)};
    const mask_of<F> outside = (to.x < I(0)) | (to.y < I(0)) | (to.z < I(0)) | (to.x > I(scene.majorants.nx - 1)) |
                               (to.y > I(scene.majorants.ny - 1)) | (to.z > I(scene.majorants.nz - 1));
    const mask_of<F> left = moves & outside;
    path.cell = select(moves & !outside, pack_cell<F>(to), path.cell);
    return {candidate, left};
}

/// How many of a camera ray's k collisions lie before the place where its transmittance has fallen to T: those with
/// (n + u) / k < 1 − T, n = 0 … k − 1. `rest` is 1 − u, in (0, 1].
template <class F>
LUMISWEEP_HD int_of<F> collisions_before(const F& transmittance, const F& rest, int k)
{
    using I = int_of<F>;
    // ⌈k (1 − T) − u⌉, without losing small T and small 1 − u to rounding.
    const F beyond = F(0.0F) - floor(fma(transmittance, F(static_cast<float>(k)), F(0.0F) - rest));
    return max(I(k - 1) + to_int(beyond), I(0));
}

template <class F>
struct Judged {
    mask_of<F> collided; ///< camera segment: at least one collision is here
    mask_of<F> ended;    ///< camera segment: it was the last. shadow segment: roulette or an opaque voxel ended it
};

/// candidate: looks the extinction up at a tentative collision and multiplies the transmittance by 1 − σt / majorant
/// (ratio tracking). Camera segments collide where it passes their numbers, shadow segments go on. Draws the next free
/// flight.
template <class F, class Voxel>
LUMISWEEP_HD Judged<F> candidate(const SceneView& scene, const GridView<Voxel>& grid, const mask_of<F>& on,
                                 PathState<F>& path)
{
    using I = int_of<F>;
    const F ratio =
        extinction_at(scene.transfer_function, trilinear(grid, position_of(path))) / majorant_at<F>(scene, path.cell);
    const Random3<F> u = random3(path.key, path.dimension);
    const mask_of<F> is_shadow = on & (path.segment == I(shadow_segment));
    const mask_of<F> is_camera = on & !is_shadow;

    const F after = path.transmittance * max(F(1.0F) - ratio, F(0.0F));
    const mask_of<F> low = after < F(roulette_threshold);
    const mask_of<F> dies = low & !(u.a * F(roulette_threshold) < after);
    const I before = collisions_before(path.transmittance, path.collision_rest(), scene.shadow_rays);
    const I now = collisions_before(after, path.collision_rest(), scene.shadow_rays);
    path.weight.z = select(is_camera, path.transmittance, path.weight.z);
    path.transmittance = select(is_shadow & low, F(roulette_threshold), select(on, after, path.transmittance));
    path.optical_depth = select(on, exponential(u.b), path.optical_depth);
    path.dimension = select(on, path.dimension + I(1), path.dimension);
    const mask_of<F> collided = is_camera & (before < now), spent = is_camera & (I(scene.shadow_rays - 1) < now);
    const mask_of<F> ended = (is_shadow & dies) | spent;
    return {collided, ended};
}

} // namespace stage

} // namespace lumisweep
