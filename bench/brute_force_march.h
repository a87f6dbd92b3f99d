// The ray march of brute_force.h, a template over the lane type; compiled by one file per instruction set.
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/volume/grid_view.h"

namespace lumisweep::bench {

/// Rays in structure-of-arrays form, in voxels. Behind the last there is one more with 0 steps, which idle lanes hold,
/// and a vector's width of readable elements.
struct RayArrays {
    const float *x, *y, *z;    ///< the first sample
    const float *dx, *dy, *dz; ///< from sample to sample
    const float* limit;        ///< a ray ends where its sum passes this
    const std::int32_t* steps;
    float* sum; ///< out: of the stored extinction at the samples
    int count;
};

std::uint64_t march_baseline(const GridView<std::uint8_t>& grid, const RayArrays& rays);
#if defined(__x86_64__)
std::uint64_t march_avx2(const GridView<std::uint8_t>& grid, const RayArrays& rays);
std::uint64_t march_avx512(const GridView<std::uint8_t>& grid, const RayArrays& rays);
#endif

template <class F>
LUMISWEEP_HD std::uint64_t march_lanes(const GridView<std::uint8_t>& grid, const RayArrays& rays)
{
    using I = int_of<F>;
    constexpr int width = lane_width<F>;
    alignas(64) std::int32_t ray[width];
    alignas(64) float sums[width];
    int next = 0;
    for (std::int32_t& r : ray)
        r = next < rays.count ? next++ : rays.count;
    const auto of_ray = [&](const float* array) { return gather(array, load<F>(ray)); };
    Vec3<F> p{of_ray(rays.x), of_ray(rays.y), of_ray(rays.z)};
    Vec3<F> step{of_ray(rays.dx), of_ray(rays.dy), of_ray(rays.dz)};
    F limit = of_ray(rays.limit), sum = F(0.0F);
    I left = gather(rays.steps, load<F>(ray));
    std::uint64_t samples = 0;
    for (;;) {
        mask_of<F> alive = (left > I(0)) & (sum < limit);
        if (next < rays.count ? 2 * count(alive) <= width : !any(alive)) {
            store(sums, sum);
            const std::uint32_t on = bits(alive);
            for (int lane = 0; lane < width; ++lane)
                if ((on >> lane & 1U) == 0) {
                    rays.sum[ray[lane]] = sums[lane];
                    ray[lane] = next < rays.count ? next++ : rays.count;
                }
            const auto refill = [&](F& value, const float* array) { value = select(alive, value, of_ray(array)); };
            refill(p.x, rays.x);
            refill(p.y, rays.y);
            refill(p.z, rays.z);
            refill(step.x, rays.dx);
            refill(step.y, rays.dy);
            refill(step.z, rays.dz);
            refill(limit, rays.limit);
            sum = select(alive, sum, F(0.0F));
            left = select(alive, left, gather(rays.steps, load<F>(ray)));
            alive = (left > I(0)) & (sum < limit);
            if (next >= rays.count && !any(alive))
                break;
        }
        sum = select(alive, sum + trilinear(grid, p), sum);
        p = p + step;
        left = left - I(1);
        samples += static_cast<std::uint64_t>(count(alive));
    }
    return samples;
}

} // namespace lumisweep::bench
