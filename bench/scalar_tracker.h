// The yardstick: a plain scalar path tracker, as it is written in an afternoon. No SIMD, no stream, no visibility.
//
// Delta tracking (Woodcock 1965) through a grid of majorants, one direction towards the light by the environment's
// marginal and conditional distributions, ratio tracking with Russian roulette on the way there. One path at a time,
// independent random numbers (PCG32, O'Neill 2014). It estimates what Session estimates, by code of its own.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "lumisweep/render/session.h"

namespace lumisweep::bench {

class ScalarTracker {
public:
    /// Makes the majorants and the distributions. The background is black, whatever the input says, and the lens a
    /// pinhole.
    explicit ScalarTracker(const SessionInput& input);

    /// One sample of every pixel into color [pixels][3]. On the calling thread.
    void render_pass(std::uint64_t seed, std::span<float> color) const;

    /// Voxels along the side of a majorant cell. Over the scenes of bench/scenes.h cells of 8 take 1.12 times as
    /// long in the geometric mean and cells of 16 1.6 times; pbrt-v4 has 16 cells along each side of a volume.
    static constexpr int majorant_cell = 4;

private:
    struct Ray {
        Vec3f origin, direction; ///< voxels; voxels per world unit of distance
    };
    class Random;
    struct LightSample {
        Vec3f direction_world, radiance_over_pdf; ///< pdf relative to the uniform one
    };

    void build_majorants();
    void build_light(const Environment& environment);

    float extinction(float raw) const;
    template <class Voxel>
    float raw_value(const Voxel* voxels, const Vec3f& p_voxel) const;
    /// From the ray's start through the majorant cells: calls collide(p_voxel, majorant) at tentative collisions until
    /// it returns true. Returns whether it did.
    template <class Collide>
    bool track(const Ray& ray, Random& random, Collide&& collide) const;
    template <class Voxel>
    Vec3f trace(const Voxel* voxels, Ray ray, Random& random) const;
    LightSample sample_light(Random& random) const;

    std::shared_ptr<const ScalarGrid> volume_;
    TransferFunction transfer_function_;
    Camera camera_;
    ImageSettings image_;
    std::vector<float> values_, extinctions_, slopes_; // of the transfer function's points, and to the next point
    Vec3i cells_{0, 0, 0};
    std::vector<float> majorants_; // [z][y][x]
    int light_side_ = 0;
    double mean_luminance_ = 0.0;
    std::vector<float> radiance_;             // [row][column][3]
    std::vector<float> row_cdf_, cdf_in_row_; // row_cdf_ [side + 1]; cdf_in_row_ [side][side + 1]
};

} // namespace lumisweep::bench
