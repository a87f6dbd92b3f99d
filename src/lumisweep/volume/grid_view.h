// The volume as kernels read it: trilinear interpolation for every lane type.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

/// Memory: voxels [nz][ny][nx] of Voxel, x fastest, at least 4 readable bytes behind the end. A stride is 0 where its
/// side is 1 voxel, so that the second neighbour is the voxel itself; x_step likewise.
template <class Voxel>
struct GridView {
    const Voxel* voxels = nullptr;
    int nx = 0, ny = 0, nz = 0;
    int stride_y = 0, stride_z = 0; ///< to the next neighbour, 0 along sides of 1 voxel
    int x_step = 1;
};

/// The eight raw values around p_voxel and where p lies between them.
template <class F>
struct Corners {
    Pair<F> v00, v10, v01, v11; ///< v<y><z>, each a pair along x
    Vec3<F> fraction;           ///< in [0, 1]
};

template <class F, class Voxel>
LUMISWEEP_HD Corners<F> corners_at(const GridView<Voxel>& grid, const Vec3<F>& p_voxel)
{
    using I = int_of<F>;
    const auto clamp_axis = [](const F& p, int n) {
        return min(max(p - F(0.5F), F(0.0F)), F(static_cast<float>(n - 1)));
    };
    const auto base_axis = [](const F& q, int n) { return min(to_int(q), I(n > 1 ? n - 2 : 0)); };
    const F qx = clamp_axis(p_voxel.x, grid.nx), qy = clamp_axis(p_voxel.y, grid.ny),
            qz = clamp_axis(p_voxel.z, grid.nz);
    const I ix = base_axis(qx, grid.nx), iy = base_axis(qy, grid.ny), iz = base_axis(qz, grid.nz);
    const I index = ix + (iy + iz * I(grid.ny)) * I(grid.nx);
    const auto row = [&](int offset) {
        Pair<F> pair = gather_pair(grid.voxels + offset, index);
        if (grid.x_step == 0)
            pair.second = pair.first;
        return pair;
    };
    return {row(0),
            row(grid.stride_y),
            row(grid.stride_z),
            row(grid.stride_y + grid.stride_z),
            {qx - to_float(ix), qy - to_float(iy), qz - to_float(iz)}};
}

template <class F>
LUMISWEEP_HD F lerp(const F& a, const F& b, const F& t)
{
    return fma(b - a, t, a);
}

/// The raw (not yet scaled) trilinear value at p_voxel, clamped to the edge voxels' centres.
template <class F, class Voxel>
LUMISWEEP_HD F trilinear(const GridView<Voxel>& grid, const Vec3<F>& p_voxel)
{
    const Corners<F> c = corners_at<F>(grid, p_voxel);
    const F y0 = lerp(lerp(c.v00.first, c.v00.second, c.fraction.x), lerp(c.v10.first, c.v10.second, c.fraction.x),
                      c.fraction.y);
    const F y1 = lerp(lerp(c.v01.first, c.v01.second, c.fraction.x), lerp(c.v11.first, c.v11.second, c.fraction.x),
                      c.fraction.y);
    return lerp(y0, y1, c.fraction.z);
}

template <class F>
struct ValueAndGradient {
    F value;
    Vec3<F> gradient; ///< of the raw value, per voxel
};

/// The trilinear value and the interpolant's own gradient, from the same eight voxels.
template <class F, class Voxel>
LUMISWEEP_HD ValueAndGradient<F> trilinear_gradient(const GridView<Voxel>& grid, const Vec3<F>& p_voxel)
{
    const Corners<F> c = corners_at<F>(grid, p_voxel);
    const Vec3<F>& f = c.fraction;
    const F x00 = lerp(c.v00.first, c.v00.second, f.x), x10 = lerp(c.v10.first, c.v10.second, f.x);
    const F x01 = lerp(c.v01.first, c.v01.second, f.x), x11 = lerp(c.v11.first, c.v11.second, f.x);
    const F y0 = lerp(x00, x10, f.y), y1 = lerp(x01, x11, f.y);
    const F dx0 = lerp(c.v00.second - c.v00.first, c.v10.second - c.v10.first, f.y);
    const F dx1 = lerp(c.v01.second - c.v01.first, c.v11.second - c.v11.first, f.y);
    return {lerp(y0, y1, f.z), {lerp(dx0, dx1, f.z), lerp(x10 - x00, x11 - x01, f.z), y1 - y0}};
}

} // namespace lumisweep
