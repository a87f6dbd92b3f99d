#include "brute_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lumisweep/base/error.h"

namespace lumisweep::bench {
namespace {

constexpr double least_visibility = 1.0 / 512.0;

/// Rays in columns of one block; `spare` elements more than rays, so that lanes may read whole vectors.
class RayBlock {
public:
    explicit RayBlock(std::size_t count) : stride_(count + spare), floats_(columns * stride_, 0.0F), steps_(stride_, 0)
    {
    }

    float& operator()(std::size_t column, std::size_t ray) { return floats_[column * stride_ + ray]; }
    std::int32_t& steps(std::size_t ray) { return steps_[ray]; }
    RayArrays arrays()
    {
        const auto column = [&](std::size_t c) { return floats_.data() + c * stride_; };
        return {column(0), column(1), column(2),     column(3), column(4),
                column(5), column(6), steps_.data(), column(7), static_cast<int>(stride_ - spare)};
    }

private:
    static constexpr std::size_t spare = 16, columns = 8;
    std::size_t stride_;
    std::vector<float> floats_;
    std::vector<std::int32_t> steps_;
};

/// World length from p along w until outside of [0, size]; 0 when p is outside.
double distance_to_outside(const Vec3d& p, const Vec3d& w, const std::array<int, 3>& size)
{
    double t = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double x = component(p, axis), dx = component(w, axis), side = size[static_cast<std::size_t>(axis)];
        if (x < 0.0 || x > side)
            return 0.0;
        if (dx != 0.0)
            t = std::min(t, ((dx > 0.0 ? side : 0.0) - x) / dx);
    }
    return t;
}

} // namespace

std::uint64_t march_baseline(const GridView<std::uint8_t>& grid, const RayArrays& rays)
{
    return march_lanes<float>(grid, rays);
}

std::span<const BruteForceKernel> brute_force_kernels()
{
    static const std::vector<BruteForceKernel> kernels = [] {
        std::vector<BruteForceKernel> found;
#if defined(__x86_64__)
        const bool avx2 =
            __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
        if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
            found.push_back({"avx512", march_avx512});
        if (avx2)
            found.push_back({"avx2", march_avx2});
#endif
        found.push_back({"baseline", march_baseline});
        return found;
    }();
    return kernels;
}

BruteForce::BruteForce(const ExtinctionGrid& extinction, const BruteForceKernel& kernel, double samples_per_voxel)
    : kernel_(kernel), voxel_from_world_(inverse(extinction.world_from_voxel)),
      scale_(static_cast<double>(extinction.scale)), samples_per_voxel_(samples_per_voxel)
{
    const Vec3i size = extinction.size;
    require(scale_ > 0.0, "brute force: the volume is empty (there is nothing to march through)");
    grid_.voxels = extinction.stored.data();
    grid_.nx = size.x;
    grid_.ny = size.y;
    grid_.nz = size.z;
    grid_.stride_y = size.y > 1 ? size.x : 0;
    grid_.stride_z = size.z > 1 ? size.x * size.y : 0;
    grid_.x_step = size.x > 1 ? 1 : 0;
}

std::uint64_t BruteForce::visibility(std::span<const VisibilityQuery> queries, std::span<float> v) const
{
    LUMISWEEP_EXPECT(v.size() >= queries.size());
    RayBlock rays(queries.size());
    std::vector<double> step_world(queries.size(), 0.0);
    for (std::size_t r = 0; r < queries.size(); ++r) {
        const Vec3d& p = queries[r].p_voxel;
        const Vec3d w = voxel_from_world_.vector(queries[r].w_world); // voxels per world unit
        const double distance = distance_to_outside(p, w, {grid_.nx, grid_.ny, grid_.nz});
        const double steps = std::ceil(distance * length(w) * samples_per_voxel_);
        if (steps < 1.0)
            continue;
        step_world[r] = distance / steps;
        const Vec3f step = to_float(w * step_world[r]), first = to_float(p + w * (0.5 * step_world[r]));
        for (int axis = 0; axis < 3; ++axis) {
            rays(static_cast<std::size_t>(axis), r) = component(first, axis);
            rays(static_cast<std::size_t>(axis) + 3, r) = component(step, axis);
        }
        rays(6, r) = static_cast<float>(-std::log(least_visibility) / (scale_ * step_world[r]));
        rays.steps(r) = static_cast<std::int32_t>(steps);
    }
    const RayArrays arrays = rays.arrays();
    const std::uint64_t samples = kernel_.march(grid_, arrays);
    for (std::size_t r = 0; r < queries.size(); ++r)
        v[r] = static_cast<float>(std::exp(-static_cast<double>(arrays.sum[r]) * scale_ * step_world[r]));
    return samples;
}

} // namespace lumisweep::bench
