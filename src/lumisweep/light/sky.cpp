#include "lumisweep/light/sky.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

void require_radiance(const Vec3d& v, std::string_view name)
{
    for (const double c : {v.x, v.y, v.z})
        require(c >= 0.0 && c <= 1e30, "sky: {} {} (each channel must be from 0 to 1e30)", name, c);
}

/// Means of (1 − z)³ = r⁶ over a texel's halves nearer to and farther from the pole, for the texels i + j = ring.
/// Over a texel r = |u'| + |v'| (in texels) is distributed as a tent, so both are polynomials.
struct RingMeans {
    double near, far;
};

RingMeans ring_means(int ring, int h)
{
    // ∫₀¹ s (a + s)⁶ ds by the binomial theorem (all terms positive: no cancellation); the far half runs back from a
    // + 2.
    constexpr std::array<double, 7> binomial{1, 6, 15, 20, 15, 6, 1};
    const double scale = std::pow(h, -6.0);
    RingMeans means{0.0, 0.0};
    for (int k = 0; k <= 6; ++k) {
        const double c = binomial[static_cast<std::size_t>(k)] * scale * 2.0 / (k + 2);
        means.near += c * std::pow(ring, 6 - k);
        means.far += c * std::pow(ring + 2.0, 6 - k) * (k % 2 == 0 ? 1.0 : -1.0);
    }
    return means;
}

AlignedArray<float> gradient(const SkySettings& sky, int n)
{
    const int h = n / 2;
    std::vector<RingMeans> rings(static_cast<std::size_t>(h));
    for (int ring = 0; ring < h; ++ring)
        rings[static_cast<std::size_t>(ring)] = ring_means(ring, h);
    AlignedArray<float> texels(3 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    parallel_for(0, n, [&](int y) {
        for (int x = 0; x < n; ++x) {
            const int ring = (x < h ? h - 1 - x : x - h) + (y < h ? h - 1 - y : y - h);
            Vec3d radiance = sky.ground;
            if (ring < h) {
                const RingMeans& mean = rings[static_cast<std::size_t>(ring)];
                const auto blend = [&](double f) { return sky.zenith * (1.0 - f) + sky.horizon * f; };
                radiance = ring == h - 1 ? (blend(mean.near) + sky.ground) * 0.5 // the horizon halves this texel
                                         : blend(0.5 * (mean.near + mean.far));
            }
            float* rgb = texels.data() + 3 * static_cast<std::size_t>(morton_encode(x, y));
            rgb[0] = static_cast<float>(radiance.x);
            rgb[1] = static_cast<float>(radiance.y);
            rgb[2] = static_cast<float>(radiance.z);
        }
    });
    return texels;
}

/// How much of each texel a disc on the sphere covers, by descent in the octahedral quadtree.
class DiscCoverage {
public:
    struct Texel {
        std::size_t morton;
        double fraction;
    };

    DiscCoverage(const Vec3d& centre, double angular_radius, int n)
        : centre_(centre), radius_(angular_radius), leaf_level_(std::countr_zero(static_cast<unsigned>(n)))
    {
        // Deep enough for 32 x 32 points in a texel on the rim and some 65536 in the disc, however small.
        const double disc_part = 0.5 * (1.0 - std::cos(angular_radius));
        const double half_sine = std::sin(0.5 * angular_radius);
        const double part = disc_part > 1e-8 ? disc_part : half_sine * half_sine;
        deepest_level_ = std::max(leaf_level_ + 5, static_cast<int>(std::ceil(0.5 * std::log2(65536.0 / part))));
        descend(0, 0.0, 0.0, 0);
    }

    const std::vector<Texel>& texels() const { return texels_; }

private:
    void descend(int level, double u, double v, std::size_t morton)
    {
        const double side = std::ldexp(1.0, -level);
        const Vec3d w = direction_from_oct(UV<double>{u + 0.5 * side, v + 0.5 * side});
        // By the chord, which is accurate for small angles where the cosine is not.
        const double angle = 2.0 * std::asin(std::min(1.0, 0.5 * length(w - centre_)));
        // The map's largest stretch is 3.1 rad per unit of u' = 2u − 1, so a cell reaches at most this far from its
        // centre.
        const double reach = 4.5 * side;
        if (angle - reach >= radius_)
            return;
        const bool inside = angle + reach <= radius_;
        if (inside || level == deepest_level_) {
            if (inside || angle < radius_)
                cover(level, morton);
            return;
        }
        for (std::size_t child = 0; child < 4; ++child)
            descend(level + 1, u + 0.5 * side * static_cast<double>(child % 2),
                    v + 0.5 * side * static_cast<double>(child / 2), level < leaf_level_ ? 4 * morton + child : morton);
    }

    /// `morton` counts cells at min(level, leaf level).
    void cover(int level, std::size_t morton)
    {
        if (level >= leaf_level_) {
            if (texels_.empty() || texels_.back().morton != morton)
                texels_.push_back({morton, 0.0});
            texels_.back().fraction += std::ldexp(1.0, -2 * (level - leaf_level_));
            return;
        }
        const std::size_t count = std::size_t{1} << (2 * (leaf_level_ - level));
        for (std::size_t i = 0; i < count; ++i)
            texels_.push_back({morton * count + i, 1.0});
    }

    Vec3d centre_;
    double radius_;
    int leaf_level_, deepest_level_ = 0;
    std::vector<Texel> texels_;
};

void add_sun(const SkySettings& sky, int n, AlignedArray<float>& texels)
{
    const double radius = sky.sun_angular_diameter_deg * (pi / 360.0);
    const DiscCoverage disc(normalized(sky.sun_direction), radius, n);
    double covered = 0.0;
    for (const DiscCoverage::Texel& texel : disc.texels())
        covered += texel.fraction;
    // ∫ L dω = L Ω with L = E / (π sin² radius) and Ω = 4π sin²(radius/2), shared out by coverage.
    const double sine_ratio = std::sin(0.5 * radius) / std::sin(radius);
    const Vec3d power = sky.sun_irradiance * (4.0 * sine_ratio * sine_ratio);
    const double texel_sr = 4.0 * pi / (static_cast<double>(n) * n);
    for (const DiscCoverage::Texel& texel : disc.texels()) {
        const Vec3d radiance = power * (texel.fraction / (covered * texel_sr));
        float* rgb = texels.data() + 3 * texel.morton;
        rgb[0] = static_cast<float>(rgb[0] + radiance.x);
        rgb[1] = static_cast<float>(rgb[1] + radiance.y);
        rgb[2] = static_cast<float>(rgb[2] + radiance.z);
    }
}

} // namespace

void SkySettings::validate() const
{
    require_radiance(zenith, "zenith");
    require_radiance(horizon, "horizon");
    require_radiance(ground, "ground");
    require_radiance(sun_irradiance, "sun_irradiance");
    const double size = length(sun_direction);
    require(std::isfinite(size) && size > 1e-6, "sky: sun_direction of length {} (give the direction towards the sun)",
            size);
    require(sun_angular_diameter_deg >= 0.001 && sun_angular_diameter_deg <= 180.0,
            "sky: sun_angular_diameter_deg {} (it must be from 0.001 to 180)", sun_angular_diameter_deg);
}

Environment environment_from_sky(const SkySettings& settings, int n)
{
    settings.validate();
    require(n >= 8 && n <= 16384 && std::has_single_bit(static_cast<unsigned>(n)),
            "sky: resolution {} (it must be a power of two from 8 to 16384)", n);
    const std::uint64_t texel_count = static_cast<std::uint64_t>(n) * static_cast<std::uint64_t>(n);
    require_memory(12 * texel_count + 16 * texel_count / 3, fmt::format("a sky of {0} x {0} texels", n),
                   "choose a lower resolution");
    AlignedArray<float> texels = gradient(settings, n);
    if (settings.sun_irradiance.x + settings.sun_irradiance.y + settings.sun_irradiance.z > 0.0)
        add_sun(settings, n, texels);
    return Environment(n, std::move(texels));
}

} // namespace lumisweep
