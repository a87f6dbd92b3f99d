// The direction strategies: sample(x, u) → ω with its pdf, and pdf(x, ω). Journal paper, section 7; conference
// paper, 3.4.
//
// Densities are over the octahedral unit square (pdf_uv); as the map preserves area, pdf_omega = pdf_uv / 4π per
// steradian.
//
// The papers interpolate the eight cells around x and descend the interpolated quadtree. The same density is had
// cheaper: J(x) = Σ w_c J_c is a mixture of the cells, so choose a cell with probability proportional to w_c · root_c
// and descend that cell alone; the density is that of the mixture, Σ w_c J_c(leaf) / Σ w_c root_c. Bias: none, whatever
// the grid holds, as J > 0 wherever the light is (ε > 0).
#pragma once

#include "lumisweep/light/environment_view.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/math/random.h"
#include "lumisweep/sampling/hierarchical_warp.h"
#include "lumisweep/sampling/joint_view.h"
#include "lumisweep/sampling/strategy.h"

namespace lumisweep {

/// What the strategies read.
struct DirectionSamplingView {
    Strategy strategy = Strategy::uniform;
    EnvironmentView environment; ///< levels ≥ joint.levels
    JointView joint;             ///< unused by uniform and environment
};

template <class F>
struct DirectionSample {
    UV<F> uv_oct;    ///< of the direction, world space
    F pdf_uv;        ///< per unit octahedral square; / 4π for steradians
    int_of<F> texel; ///< of the environment, Morton order
};

namespace detail {

/// Nodes of a quadtree before level l: (4^l − 1) / 3.
LUMISWEEP_HD int level_offset(int level) { return ((1 << (2 * level)) - 1) / 3; }

/// The eight cells around a position and their trilinear weights; beyond the outer centres the outer cells count.
template <class F>
struct CellCorners {
    int_of<F> base;
    int dx, dy, dz; ///< index steps to the second cell, 0 along sides of one cell
    Vec3<F> fraction;

    template <class Body>
    LUMISWEEP_HD void for_each(Body&& body) const
    {
        const Vec3<F> f = fraction, g = {F(1.0F) - f.x, F(1.0F) - f.y, F(1.0F) - f.z};
        for (int c = 0; c < 8; ++c) {
            const F w = ((c & 1) != 0 ? f.x : g.x) * ((c & 2) != 0 ? f.y : g.y) * ((c & 4) != 0 ? f.z : g.z);
            body(base + int_of<F>(((c & 1) != 0 ? dx : 0) + ((c & 2) != 0 ? dy : 0) + ((c & 4) != 0 ? dz : 0)), w);
        }
    }
};

template <class F>
LUMISWEEP_HD CellCorners<F> cell_corners(const JointView& joint, const Vec3<F>& p_voxel)
{
    using I = int_of<F>;
    const auto clamp_axis = [](const F& p, int n) {
        return min(max(p - F(0.5F), F(0.0F)), F(static_cast<float>(n - 1)));
    };
    const auto base_axis = [](const F& q, int n) { return min(to_int(q), I(n > 1 ? n - 2 : 0)); };
    const Vec3i n = joint.cells;
    const F qx = clamp_axis(p_voxel.x * F(joint.cells_per_voxel.x), n.x);
    const F qy = clamp_axis(p_voxel.y * F(joint.cells_per_voxel.y), n.y);
    const F qz = clamp_axis(p_voxel.z * F(joint.cells_per_voxel.z), n.z);
    const I ix = base_axis(qx, n.x), iy = base_axis(qy, n.y), iz = base_axis(qz, n.z);
    return {ix + (iy + iz * I(n.y)) * I(n.x),
            n.x > 1 ? 1 : 0,
            n.y > 1 ? n.x : 0,
            n.z > 1 ? n.x * n.y : 0,
            {qx - to_float(ix), qy - to_float(iy), qz - to_float(iz)}};
}

template <class F>
LUMISWEEP_HD F joint_value(const JointView& joint, const int_of<F>& cell, const int_of<F>& leaf)
{
    if (joint.levels == 0)
        return gather(joint.root, cell);
    const float* leaves = joint.nodes + level_offset(joint.levels) - 1;
    return gather(leaves, cell * int_of<F>(joint.node_count) + leaf);
}

/// The parts w_c · root_c that the eight cells have in the interpolated product, and their sum.
template <class F>
struct CellParts {
    F part[8];
    F total;
};

template <class F>
LUMISWEEP_HD CellParts<F> cell_parts(const JointView& joint, const CellCorners<F>& corners)
{
    CellParts<F> parts;
    parts.total = F(0.0F);
    int c = 0;
    corners.for_each([&](const int_of<F>& cell, const F& w) {
        parts.part[c] = w * gather(joint.root, cell);
        parts.total = parts.total + parts.part[c++];
    });
    return parts;
}

/// Σ w_c J_c(leaf) / Σ w_c root_c: the density of the interpolated product.
template <class F>
LUMISWEEP_HD F joint_pdf_uv(const JointView& joint, const CellCorners<F>& corners, const CellParts<F>& parts,
                            const int_of<F>& leaf)
{
    F value = F(0.0F);
    corners.for_each(
        [&](const int_of<F>& cell, const F& w) { value = fma(w, joint_value<F>(joint, cell, leaf), value); });
    return value / parts.total;
}

/// Chooses one of the eight cells with probability proportional to its part.
template <class F>
LUMISWEEP_HD int_of<F> choose_cell(const CellCorners<F>& corners, const CellParts<F>& parts, const F& u)
{
    const F target = u * parts.total;
    F sum = F(0.0F);
    int_of<F> chosen = corners.base;
    int c = 0;
    // The last cell of positive part at which the running sum is still at or below the target.
    corners.for_each([&](const int_of<F>& cell, const F&) {
        const F part = parts.part[c++];
        chosen = select((sum <= target) & (part > F(0.0F)), cell, chosen);
        sum = sum + part;
    });
    return chosen;
}

template <class F>
LUMISWEEP_HD Descent<F> descend_environment(const EnvironmentView& environment, int from_level, Descent<F> at)
{
    for (int level = from_level; level < environment.levels; ++level)
        at = warp_to_child(gather_quad<F>(environment.luminance + level_offset(level + 1), at.node), at);
    return at;
}

template <class F>
LUMISWEEP_HD Descent<F> descend_joint(const JointView& joint, const int_of<F>& cell, Descent<F> at)
{
    const int_of<F> first = cell * int_of<F>(joint.node_count);
    for (int level = 1; level <= joint.levels; ++level) {
        const float* nodes = joint.nodes + level_offset(level) - 1;
        const int_of<F> children = first + shift_left<2>(at.node);
        at = warp_to_child(Quad<F>{gather(nodes, children), gather(nodes + 1, children), gather(nodes + 2, children),
                                   gather(nodes + 3, children)},
                           at);
    }
    return at;
}

/// The octahedral point of a descent that ended in a node of the given level.
template <class F>
LUMISWEEP_HD UV<F> uv_of(const Descent<F>& at, int level)
{
    using I = int_of<F>;
    const auto xy = morton_decode(at.node);
    const F scale = F(1.0F / static_cast<float>(1 << level));
    // The sum may round up to the neighbour's edge: at most the number before it.
    const auto within = [&](const I& node, const F& fraction) {
        const F before_next = as_float(as_int(to_float(node + I(1))) - I(1));
        return min(to_float(node) + fraction, before_next) * scale;
    };
    return {within(xy.x, at.uv.u), within(xy.y, at.uv.v)};
}

/// The Morton index of the node of a level that holds an octahedral point.
template <class F>
LUMISWEEP_HD int_of<F> node_of(const UV<F>& uv_oct, int level)
{
    using I = int_of<F>;
    const int n = 1 << level;
    const F scale = F(static_cast<float>(n));
    const I x = min(max(to_int(uv_oct.u * scale), I(0)), I(n - 1));
    const I y = min(max(to_int(uv_oct.v * scale), I(0)), I(n - 1));
    return morton_encode(x, y);
}

/// Luminance of an environment node over that of the level's ancestor: the density below a node, per unit of its
/// square.
template <class F>
LUMISWEEP_HD F environment_pdf_below(const EnvironmentView& environment, const int_of<F>& texel,
                                     const F& node_luminance)
{
    return gather(environment.luminance + level_offset(environment.levels), texel) / node_luminance;
}

} // namespace detail

/// Draws a direction at p_voxel; u in [0, 1)³.
template <class F>
LUMISWEEP_HD DirectionSample<F> sample_direction(const DirectionSamplingView& view, const Vec3<F>& p_voxel,
                                                 const Random3<F>& u)
{
    using I = int_of<F>;
    const EnvironmentView& environment = view.environment;
    const Descent<F> root = {I(0), {u.a, u.b}};
    if (view.strategy == Strategy::uniform)
        return {root.uv, F(1.0F), detail::node_of(root.uv, environment.levels)};
    if (view.strategy == Strategy::environment) {
        const Descent<F> leaf = detail::descend_environment(environment, 0, root);
        return {detail::uv_of(leaf, environment.levels),
                detail::environment_pdf_below<F>(environment, leaf.node, F(environment.luminance[0])), leaf.node};
    }
    const JointView& joint = view.joint;
    const auto corners = detail::cell_corners(joint, p_voxel);
    const auto parts = detail::cell_parts(joint, corners);
    const Descent<F> node = detail::descend_joint(joint, detail::choose_cell(corners, parts, u.c), root);
    const F pdf_uv = detail::joint_pdf_uv(joint, corners, parts, node.node);
    if (view.strategy != Strategy::two_step) {
        const UV<F> uv = detail::uv_of(node, joint.levels);
        return {uv, pdf_uv, detail::node_of(uv, environment.levels)};
    }
    const F node_luminance = gather(environment.luminance + detail::level_offset(joint.levels), node.node);
    const Descent<F> leaf = detail::descend_environment(environment, joint.levels, node);
    return {detail::uv_of(leaf, environment.levels),
            pdf_uv * detail::environment_pdf_below<F>(environment, leaf.node, node_luminance), leaf.node};
}

/// The density of sample_direction() at an octahedral point, per unit square.
template <class F>
LUMISWEEP_HD F direction_pdf_uv(const DirectionSamplingView& view, const Vec3<F>& p_voxel, const UV<F>& uv_oct)
{
    if (view.strategy == Strategy::uniform)
        return F(1.0F);
    const EnvironmentView& environment = view.environment;
    const int_of<F> texel = detail::node_of(uv_oct, environment.levels);
    if (view.strategy == Strategy::environment)
        return detail::environment_pdf_below<F>(environment, texel, F(environment.luminance[0]));
    const JointView& joint = view.joint;
    const int_of<F> node = detail::node_of(uv_oct, joint.levels);
    const auto corners = detail::cell_corners(joint, p_voxel);
    const F pdf_uv = detail::joint_pdf_uv(joint, corners, detail::cell_parts(joint, corners), node);
    if (view.strategy != Strategy::two_step)
        return pdf_uv;
    const F node_luminance = gather(environment.luminance + detail::level_offset(joint.levels), node);
    return pdf_uv * select(node_luminance > F(0.0F),
                           detail::environment_pdf_below<F>(environment, texel, node_luminance), F(0.0F));
}

} // namespace lumisweep
