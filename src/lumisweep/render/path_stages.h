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

namespace lumisweep {

/// Below this transmittance shadow segments play Russian roulette.
inline constexpr float roulette_threshold = 0.1F;

/// Event numbers of random3(): 0 is the pixel and the lens, 1 the lens and the first free flight, then one per event.
inline constexpr int first_event_dimension = 2;

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

template <class F>
struct Judged {
    mask_of<F> scattered; ///< camera segment: a real collision
    mask_of<F> ended;     ///< shadow segment: roulette or an opaque voxel ended it
};

/// candidate: looks the extinction up at a tentative collision. Camera segments collide really with probability σt /
/// majorant (delta tracking); shadow segments multiply by 1 − σt / majorant (ratio tracking). Draws the next free
/// flight.
template <class F, class Voxel>
LUMISWEEP_HD Judged<F> candidate(const SceneView& scene, const GridView<Voxel>& grid, const mask_of<F>& on,
                                 PathState<F>& path)
{
    using I = int_of<F>;
    const Vec3<F> p_voxel = {fma(path.direction.x, path.t, path.origin.x), fma(path.direction.y, path.t, path.origin.y),
                             fma(path.direction.z, path.t, path.origin.z)};
    const F ratio = extinction_at(scene.transfer_function, trilinear(grid, p_voxel)) / majorant_at<F>(scene, path.cell);
    const Random3<F> u = random3(path.key, path.dimension);
    const mask_of<F> is_shadow = on & (path.segment == I(shadow_segment));
    const mask_of<F> scattered = on & !is_shadow & (u.a < ratio);

    const F after = path.transmittance * max(F(1.0F) - ratio, F(0.0F));
    const mask_of<F> low = after < F(roulette_threshold);
    const mask_of<F> dies = low & !(u.a * F(roulette_threshold) < after);
    path.transmittance = select(is_shadow, select(low, F(roulette_threshold), after), path.transmittance);
    path.optical_depth = select(on, exponential(u.b), path.optical_depth);
    path.dimension = select(on, path.dimension + I(1), path.dimension);
    const mask_of<F> ended = is_shadow & dies;
    return {scattered, ended};
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
