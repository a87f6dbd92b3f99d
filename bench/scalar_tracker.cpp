#include "scalar_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lumisweep/math/octahedral.h"
#include "lumisweep/render/camera.h"

namespace lumisweep::bench {

/// PCG32 (O'Neill 2014, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number
/// Generation").
class ScalarTracker::Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed + increment)
    {
        next();
        state_ += seed * 0x9e3779b97f4a7c15U;
        next();
    }
    /// In [0, 1).
    float uniform() { return static_cast<float>(next() >> 8) * 0x1p-24F; }
    /// Optical depth of a free flight.
    float flight() { return -std::log(1.0F - uniform()); }

private:
    static constexpr std::uint64_t increment = 1442695040888963407U;
    std::uint32_t next()
    {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005U + increment;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> turn) | (shifted << ((32 - turn) & 31));
    }
    std::uint64_t state_;
};

ScalarTracker::ScalarTracker(const SessionInput& input)
    : volume_(input.volume), transfer_function_(input.transfer_function), camera_(input.camera), image_(input.image)
{
    const std::vector<TransferPoint>& points = transfer_function_.points();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const TransferPoint &a = points[i], &b = points[std::min(i + 1, points.size() - 1)];
        const double scale = transfer_function_.extinction_scale();
        values_.push_back(static_cast<float>(a.value));
        extinctions_.push_back(static_cast<float>(a.extinction * scale));
        slopes_.push_back(
            b.value > a.value ? static_cast<float>((b.extinction - a.extinction) * scale / (b.value - a.value)) : 0.0F);
    }
    build_majorants();
    build_light(*input.environment);
}

float ScalarTracker::extinction(float raw) const
{
    const float value = raw * static_cast<float>(volume_->slope()) + static_cast<float>(volume_->intercept());
    if (value < values_.front())
        return extinctions_.front();
    std::size_t i = 0;
    while (i + 1 < values_.size() && value >= values_[i + 1])
        ++i;
    return std::max(extinctions_[i] + (value - values_[i]) * slopes_[i], 0.0F);
}

template <class Voxel>
float ScalarTracker::raw_value(const Voxel* voxels, const Vec3f& p_voxel) const
{
    const Vec3i size = volume_->size();
    const auto place = [](float p, int n, std::size_t& base) {
        const float q = std::clamp(p - 0.5F, 0.0F, static_cast<float>(n - 1));
        const int i = std::min(static_cast<int>(q), std::max(n - 2, 0));
        base = static_cast<std::size_t>(i);
        return q - static_cast<float>(i);
    };
    std::size_t x = 0, y = 0, z = 0;
    const float fx = place(p_voxel.x, size.x, x), fy = place(p_voxel.y, size.y, y), fz = place(p_voxel.z, size.z, z);
    const auto nx = static_cast<std::size_t>(size.x), ny = static_cast<std::size_t>(size.y);
    const std::size_t dx = size.x > 1 ? 1 : 0, dy = size.y > 1 ? nx : 0, dz = size.z > 1 ? nx * ny : 0;
    const Voxel* v = voxels + (z * ny + y) * nx + x;
    const auto row = [fx, dx](const Voxel* at) {
        const auto a = static_cast<float>(at[0]), b = static_cast<float>(at[dx]);
        return a + (b - a) * fx;
    };
    const float y0 = row(v) + (row(v + dy) - row(v)) * fy;
    const float y1 = row(v + dz) + (row(v + dy + dz) - row(v + dz)) * fy;
    return y0 + (y1 - y0) * fz;
}

template <class Collide>
bool ScalarTracker::track(const Ray& ray, Random& random, Collide&& collide) const
{
    // Amanatides and Woo 1987: the distances to the next side of the cell along each axis.
    std::array<int, 3> cell{}, step{}, end{};
    std::array<float, 3> next{}, delta{};
    float leave = 3.0e38F;
    for (int a = 0; a < 3; ++a) {
        const auto at = static_cast<std::size_t>(a);
        const float o = component(ray.origin, a), d = component(ray.direction, a), inverse = 1.0F / d;
        const int cells = component(cells_, a);
        cell[at] = std::clamp(static_cast<int>(o / majorant_cell), 0, cells - 1);
        step[at] = d > 0.0F ? 1 : -1;
        end[at] = d > 0.0F ? cells : -1;
        next[at] = (static_cast<float>((cell[at] + (d > 0.0F ? 1 : 0)) * majorant_cell) - o) * inverse;
        delta[at] = majorant_cell * std::fabs(inverse);
        leave = std::min(leave, ((d > 0.0F ? static_cast<float>(component(volume_->size(), a)) : 0.0F) - o) * inverse);
    }
    float t = 0.0F, flight = random.flight();
    for (;;) {
        const std::size_t axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
        const float exit = std::min(next[axis], leave);
        const float majorant =
            majorants_[static_cast<std::size_t>((cell[2] * cells_.y + cell[1]) * cells_.x + cell[0])];
        while (flight < majorant * (exit - t)) {
            t += flight / majorant;
            if (collide(ray.origin + ray.direction * t, majorant))
                return true;
            flight = random.flight();
        }
        flight -= majorant * std::max(exit - t, 0.0F);
        t = std::max(exit, t);
        cell[axis] += step[axis];
        if (cell[axis] == end[axis] || exit >= leave)
            return false;
        next[axis] += delta[axis];
    }
}

ScalarTracker::LightSample ScalarTracker::sample_light(Random& random) const
{
    const auto pick = [](const float* cdf, int n, float u) {
        const float* above = std::upper_bound(cdf + 1, cdf + n, u);
        return static_cast<int>(above - cdf) - 1;
    };
    const auto side = static_cast<std::size_t>(light_side_);
    const int y = pick(row_cdf_.data(), light_side_, random.uniform());
    const int x = pick(cdf_in_row_.data() + static_cast<std::size_t>(y) * (side + 1), light_side_, random.uniform());
    const float* rgb = radiance_.data() + 3 * (static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x));
    const double y709 = luminance(rgb[0], rgb[1], rgb[2]);
    if (!(y709 > 0.0))
        return {{0.0F, 0.0F, 1.0F}, {0.0F, 0.0F, 0.0F}};
    const auto weight = static_cast<float>(mean_luminance_ / y709);
    const UV<float> uv{(static_cast<float>(x) + random.uniform()) / static_cast<float>(light_side_),
                       (static_cast<float>(y) + random.uniform()) / static_cast<float>(light_side_)};
    return {direction_from_oct(uv), Vec3f{rgb[0], rgb[1], rgb[2]} * weight};
}

template <class Voxel>
Vec3f ScalarTracker::trace(const Voxel* voxels, Ray ray, Random& random) const
{
    constexpr Vec3f black{0.0F, 0.0F, 0.0F};
    // The volume's box.
    float enter = 0.0F, leave = 3.0e38F;
    for (int a = 0; a < 3; ++a) {
        const float inverse = 1.0F / component(ray.direction, a), o = component(ray.origin, a);
        const float t0 = -o * inverse, t1 = (static_cast<float>(component(volume_->size(), a)) - o) * inverse;
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
    }
    if (!(enter < leave))
        return black;
    ray.origin = ray.origin + ray.direction * enter;

    Vec3f p_voxel = black;
    float raw = 0.0F;
    const bool collided = track(ray, random, [&](const Vec3f& p, float majorant) {
        raw = raw_value(voxels, p);
        p_voxel = p;
        return random.uniform() * majorant < extinction(raw);
    });
    if (!collided)
        return black;

    const LightSample light = sample_light(random);
    if (light.radiance_over_pdf == black)
        return black;
    float transmittance = 1.0F;
    const Ray shadow{p_voxel, to_float(volume_->voxel_from_world().vector(to_double(light.direction_world)))};
    const bool stopped = track(shadow, random, [&](const Vec3f& p, float majorant) {
        transmittance *= std::max(1.0F - extinction(raw_value(voxels, p)) / majorant, 0.0F);
        constexpr float threshold = 0.1F;
        if (transmittance >= threshold)
            return false;
        if (random.uniform() * threshold >= transmittance)
            return true;
        transmittance = threshold;
        return false;
    });
    if (stopped)
        return black;
    const double value = volume_->slope() * static_cast<double>(raw) + volume_->intercept();
    return to_float(transfer_function_.evaluate(value).albedo) * light.radiance_over_pdf * transmittance;
}

void ScalarTracker::render_pass(std::uint64_t seed, std::span<float> color) const
{
    const CameraFrame frame = camera_frame(camera_);
    const double half_height = std::tan(camera_.vertical_fov_deg * (pi / 360.0));
    const double half_width = half_height * image_.width / image_.height;
    const Vec3f origin = to_float(volume_->voxel_from_world().point(camera_.position));
    Random random(seed);
    visit_voxels(*volume_, [&](const auto* voxels) {
        std::size_t at = 0;
        for (int y = 0; y < image_.height; ++y)
            for (int x = 0; x < image_.width; ++x) {
                const double sx = 2.0 * (x + static_cast<double>(random.uniform())) / image_.width - 1.0;
                const double sy = 1.0 - 2.0 * (y + static_cast<double>(random.uniform())) / image_.height;
                const Vec3d d =
                    normalized(frame.forward + frame.right * (sx * half_width) + frame.up * (sy * half_height));
                const Vec3f c = trace(voxels, {origin, to_float(volume_->voxel_from_world().vector(d))}, random);
                color[at++] = c.x;
                color[at++] = c.y;
                color[at++] = c.z;
            }
    });
}

} // namespace lumisweep::bench
