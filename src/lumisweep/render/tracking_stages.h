// The stages that every segment of a path goes through, once for every lane type: advance through majorant cells and
// empty space, candidate at tentative collisions.
#pragma once

#include "lumisweep/render/path_state.h"
#include "lumisweep/render/scene_view.h"

namespace lumisweep {

/// Below this transmittance shadow segments play Russian roulette.
inline constexpr float roulette_threshold = 0.25F;

namespace stage {

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

/// Directions without exact zeros, so that reciprocals stay finite.
template <class F>
LUMISWEEP_HD F nonzero(const F& d)
{
    return select(abs(d) < F(1e-20F), copysign(F(1e-20F), d), d);
}

template <class F>
LUMISWEEP_HD int_of<F> cell_at(const SceneView& scene, const Vec3<F>& p_voxel)
{
    return pack_cell<F>(scene.majorants, lumisweep::cell_at(scene.majorants, p_voxel));
}

/// What advance needs of a path beyond its state, for as long as its segment's cells are walked through. Positions are
/// in cells: c(t) = origin + t · direction.
template <class F>
struct Walk {
    Vec3<F> origin, direction, inverse;
    CellXYZ<F> cell;
    F t_leave;           ///< where the segment leaves the volume
    F majorant;          ///< of the cell, less the control
    F control;           ///< extinction in the cell that transmittance has in closed form
    mask_of<F> in_block; ///< it holds in the cell's whole block
};

template <class F>
LUMISWEEP_HD Walk<F> begin_walk(const SceneView& scene, const PathState<F>& path)
{
    constexpr float scale = 1.0F / majorant_cell;
    Walk<F> walk;
    walk.cell = unpack_cell<F>(scene.majorants, path.cell);
    walk.majorant = walk.control = F(0.0F);
    walk.in_block = mask_of<F>(false);
    const auto axis = [&](const F& origin, const F& direction, int n, F& o, F& d, F& inverse) {
        o = fma(origin, F(scale), F(0.5F * scale));
        d = direction * F(scale);
        inverse = reciprocal(d);
        const F end = select(direction > F(0.0F), F((static_cast<float>(n) + 0.5F) * scale), F(0.5F * scale));
        return (end - o) * inverse;
    };
    const F x = axis(path.origin.x, path.direction.x, scene.size.x, walk.origin.x, walk.direction.x, walk.inverse.x);
    const F y = axis(path.origin.y, path.direction.y, scene.size.y, walk.origin.y, walk.direction.y, walk.inverse.y);
    const F z = axis(path.origin.z, path.direction.z, scene.size.z, walk.origin.z, walk.direction.z, walk.inverse.z);
    walk.t_leave = min(min(x, y), z);
    return walk;
}

template <class F>
struct Advanced {
    mask_of<F> candidate; ///< the flight ends within the cell
    mask_of<F> left;      ///< has left the volume
};

/// Residual ratio tracking in thin media (Novák et al. 2014): the least extinction of a block is taken in closed form
/// and only what exceeds it is looked up. A control in the middle of the bounds would halve the lookups of even media,
/// but its factors of up to 2 pile up where blocks are mostly empty; this one keeps T's estimates in [0, 1].
template <class F>
LUMISWEEP_HD F control_at(const MajorantView& majorants, const CellXYZ<F>& cell, const Majorant<F>& majorant)
{
    const F smallest =
        to_float(gather(majorants.smallest, block_of_cell(majorants, cell))) * F(majorants.largest * 0x1p-8F);
    return select(majorant.in_block, smallest, F(0.0F));
}

/// advance: to the end of a majorant cell, or of the empty blocks around it, unless the flight ends before. Of a flight
/// that does, candidate() finds the end.
template <class F>
LUMISWEEP_HD Advanced<F> advance(const SceneView& scene, const mask_of<F>& on, PathState<F>& path, Walk<F>& walk)
{
    using I = int_of<F>;
    const F zero = F(0.0F);
    const Majorant<F> majorant = majorant_at<F>(scene.majorants, walk.cell);
    F residual = majorant.value;
    if (scene.majorants.smallest != nullptr) {
        const F control =
            select(path.segment == I(shadow_segment), control_at(scene.majorants, walk.cell, majorant), zero);
        walk.control = select(on, control, walk.control);
        residual = residual - control;
    }
    walk.majorant = select(on, residual, walk.majorant);
    walk.in_block = (on & majorant.in_block) | (walk.in_block & !on);

    // The box to cross reaches from `below` cells under its base to `above` cells over it.
    const I base_mask = select(majorant.in_block, I(-majorant_block), I(-1));
    const I reach = shift_left<2>(majorant.distance);
    const I above = select(majorant.in_block, reach, I(1));
    const I below = select(majorant.in_block, reach - I(majorant_block), I(0));

    struct Side {
        I base, edge;
        F t;
    };
    const auto side = [&](const I& c, const F& origin, const F& direction, const F& inverse) {
        Side s;
        s.base = c & base_mask;
        s.edge = select(direction > zero, s.base + above, s.base - below);
        s.t = (to_float(s.edge) - origin) * inverse;
        return s;
    };
    const Side x = side(walk.cell.x, walk.origin.x, walk.direction.x, walk.inverse.x);
    const Side y = side(walk.cell.y, walk.origin.y, walk.direction.y, walk.inverse.y);
    const Side z = side(walk.cell.z, walk.origin.z, walk.direction.z, walk.inverse.z);
    const F t_side = max(min(min(x.t, y.t), z.t), path.t), t_exit = min(t_side, walk.t_leave);

    const F depth = residual * (t_exit - path.t);
    const mask_of<F> hit = path.optical_depth < depth;
    const mask_of<F> candidate = on & hit, moves = on & !hit;
    const mask_of<F> left = moves & (t_side >= walk.t_leave), enters = moves & !left;
    if (scene.majorants.smallest != nullptr)
        path.transmittance =
            select(moves, path.transmittance * exp(walk.control * (path.t - t_exit)), path.transmittance);
    path.t = select(moves, t_exit, path.t);
    path.optical_depth = select(moves, path.optical_depth - depth, path.optical_depth);

    // Across the nearest side into the neighbour, exactly; ties go to x, then y. Along the other axes the position says
    // where, but rounding must not leave the box.
    const mask_of<F> over_x = (x.t <= y.t) & (x.t <= z.t);
    const mask_of<F> over_y = (!over_x) & (y.t <= z.t);
    const mask_of<F> over_z = !(over_x | over_y);
    const auto next = [&](I& c, const Side& s, const F& origin, const F& direction, const mask_of<F>& over) {
        const I across = s.edge - select(direction > zero, I(0), I(1));
        const I along = min(max(to_int(fma(direction, t_exit, origin)), s.base - below), s.base + above - I(1));
        c = select(enters, select(over, across, along), c);
    };
    next(walk.cell.x, x, walk.origin.x, walk.direction.x, over_x);
    next(walk.cell.y, y, walk.origin.y, walk.direction.y, over_y);
    next(walk.cell.z, z, walk.origin.z, walk.direction.z, over_z);
    return {candidate, left};
}

/// look_up: goes to the tentative collisions and returns extinction there over the majorant, both less the control.
template <class F, class Voxel>
LUMISWEEP_HD F look_up(const SceneView& scene, const GridView<Voxel>& grid, const mask_of<F>& on, PathState<F>& path,
                       const Walk<F>& walk)
{
    using I = int_of<F>;
    const F inverse_majorant = reciprocal(select(on, walk.majorant, F(1.0F)));
    if (scene.majorants.smallest != nullptr)
        path.transmittance =
            select(on, path.transmittance * exp(F(0.0F) - walk.control * path.optical_depth * inverse_majorant),
                   path.transmittance);
    path.t = select(on, fma(path.optical_depth, inverse_majorant, path.t), path.t);
    // The majorant bounds the extinction of its cell or block only, which rounding must not leave.
    const I base_mask = select(walk.in_block, I(-majorant_block), I(-1));
    const F side = select(walk.in_block, F(static_cast<float>(majorant_cell * majorant_block)),
                          F(static_cast<float>(majorant_cell)));
    const auto within = [&](const F& origin, const F& direction, const I& cell) {
        const F low = fma(to_float(cell & base_mask), F(static_cast<float>(majorant_cell)), F(-0.5F));
        const F p = fma(direction, path.t, origin);
        return select(on, min(max(p, low), low + side), F(0.0F)); // lanes that are off fetch nothing new
    };
    const Vec3<F> p_voxel = {within(path.origin.x, path.direction.x, walk.cell.x),
                             within(path.origin.y, path.direction.y, walk.cell.y),
                             within(path.origin.z, path.direction.z, walk.cell.z)};
    return (extinction_at(scene.transfer_function, trilinear(grid, p_voxel)) - walk.control) * inverse_majorant;
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

/// candidate: at a tentative collision the transmittance is multiplied by 1 − `ratio` (ratio tracking; residual where
/// there is a control). Camera segments collide where that passes their numbers, shadow segments go on. Draws the next
/// free flight.
template <class F>
LUMISWEEP_HD Judged<F> candidate(const SceneView& scene, const mask_of<F>& on, const F& ratio, PathState<F>& path)
{
    using I = int_of<F>;
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
