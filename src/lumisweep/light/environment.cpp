#include "lumisweep/light/environment.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

constexpr std::size_t grain = 16384;

/// Nodes of all levels above level l, that is, where level l begins.
std::size_t level_begin(int l) { return ((std::size_t{1} << (2 * l)) - 1) / 3; }

/// Leaves first, then each level from the one below; averages are taken in double and rounded once a level, so that
/// a parent is the mean of its children to float rounding whatever the number of threads.
AlignedArray<float> luminance_quadtree(int levels, const AlignedArray<float>& radiance)
{
    AlignedArray<float> tree(level_begin(levels + 1));
    float* leaves = tree.data() + level_begin(levels);
    parallel_for(
        std::size_t{0}, std::size_t{1} << (2 * levels),
        [&](std::size_t m) {
            const float* rgb = radiance.data() + 3 * m;
            leaves[m] = static_cast<float>(luminance(rgb[0], rgb[1], rgb[2]));
        },
        grain);
    for (int l = levels - 1; l >= 0; --l) {
        float* parents = tree.data() + level_begin(l);
        const float* children = tree.data() + level_begin(l + 1);
        parallel_for(
            std::size_t{0}, std::size_t{1} << (2 * l),
            [&](std::size_t m) {
                const float* c = children + 4 * m;
                parents[m] = static_cast<float>(0.25 * ((double{c[0]} + c[1]) + (double{c[2]} + c[3])));
            },
            grain);
    }
    return tree;
}

} // namespace

Environment::Environment(int n, AlignedArray<float> radiance_rgb) : n_(n), radiance_(std::move(radiance_rgb))
{
    require(n >= 1 && n <= 16384 && std::has_single_bit(static_cast<unsigned>(n)),
            "environment: resolution {} is not a power of two from 1 to 16384 (choose one)", n);
    const std::size_t expected = 3 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
    require(radiance_.size() == expected, "environment: {} numbers given where {} x {} RGB texels need {}",
            radiance_.size(), n, n, expected);
    parallel_for(
        std::size_t{0}, expected,
        [&](std::size_t i) {
            require(radiance_[i] >= 0.0F && radiance_[i] <= 1e30F,
                    "environment: radiance {} in texel {} (radiance must be from 0 to 1e30)", radiance_[i], i / 3);
        },
        grain);
    luminance_ = luminance_quadtree(std::countr_zero(static_cast<unsigned>(n)), radiance_);
}

Environment Environment::constant(const Vec3d& radiance)
{
    constexpr int n = 8;
    AlignedArray<float> texels(3 * n * n);
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = static_cast<float>(component(radiance, static_cast<int>(i % 3)));
    return Environment(n, std::move(texels));
}

Environment Environment::refined(int n) const
{
    LUMISWEEP_EXPECT(n >= n_ && std::has_single_bit(static_cast<unsigned>(n)));
    // In Morton order the descendants of a texel are consecutive.
    const std::size_t descendants = static_cast<std::size_t>(n / n_) * static_cast<std::size_t>(n / n_);
    AlignedArray<float> texels(radiance_.size() * descendants);
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = radiance_[i / 3 / descendants * 3 + i % 3];
    return Environment(n, std::move(texels));
}

EnvironmentView Environment::view() const
{
    return {std::countr_zero(static_cast<unsigned>(n_)), radiance_.data(), luminance_.data()};
}

Vec3d Environment::radiance(const Vec3d& w_world) const
{
    const UV<double> uv_oct = oct_from_direction(w_world);
    const int x = std::clamp(static_cast<int>(uv_oct.u * n_), 0, n_ - 1);
    const int y = std::clamp(static_cast<int>(uv_oct.v * n_), 0, n_ - 1);
    const float* rgb = radiance_.data() + 3 * static_cast<std::size_t>(morton_encode(x, y));
    return {rgb[0], rgb[1], rgb[2]};
}

} // namespace lumisweep
