// What one pass takes and gives: a sample of every pixel, and counts.
#pragma once

#include <cstdint>

#include "lumisweep/math/random.h"

namespace lumisweep {

/// How a pixel's samples are drawn (RenderSettings, resolved).
enum class Draws { independent, stratified };

/// Shadow rays a camera ray at most.
inline constexpr int most_shadow_rays = 64;

/// Samples of a pixel that are stratified together; between such blocks they are independent, which is what the film's
/// variance is taken from. At 4 shadow rays a camera ray, 16 leave 3 % more squared error than 128 (CT head, 128
/// samples).
inline constexpr std::int64_t samples_a_block = 16;

/// What a pass draws its random numbers from.
struct PassNumbers {
    PassKey sample;     ///< of independent numbers
    PassKey block;      ///< of stratified numbers: the same for all samples of a block
    std::int32_t index; ///< of the sample within its block
};

inline PassNumbers pass_numbers(std::uint64_t seed, std::int64_t sample)
{
    constexpr std::uint64_t of_blocks = 0xd1b54a32d192ed03ULL; // another stream than that of samples
    return {pass_key(seed, static_cast<std::uint64_t>(sample)),
            pass_key(seed ^ of_blocks, static_cast<std::uint64_t>(sample / samples_a_block)),
            static_cast<std::int32_t>(sample % samples_a_block)};
}

/// One pass's samples, one per pixel, zero where a path brought nothing.
/// Memory: color [pixels][3] float; features [pixels][8] float, the order of Film's.
struct SampleView {
    float* color = nullptr;
    float* features = nullptr;
};

/// Counts of a pass, for --stats.
struct PassCounts {
    std::uint64_t paths = 0;        ///< camera rays
    std::uint64_t shadow_rays = 0;  ///< directions towards light that is not black
    std::uint64_t camera_steps = 0; ///< tentative collisions of camera segments
    std::uint64_t shadow_steps = 0; ///< tentative collisions of shadow segments
    /// Lanes that went through a cell, a block or empty space, and all lanes of the groups that they were in; and all
    /// lanes of the groups that tentative collisions were in. Utilisation is advance_steps / advance_lanes, and
    /// (camera_steps + shadow_steps) / candidate_lanes.
    std::uint64_t advance_steps = 0, advance_lanes = 0, candidate_lanes = 0;

    PassCounts& operator+=(const PassCounts& other)
    {
        paths += other.paths;
        shadow_rays += other.shadow_rays;
        camera_steps += other.camera_steps;
        shadow_steps += other.shadow_steps;
        advance_steps += other.advance_steps;
        advance_lanes += other.advance_lanes;
        candidate_lanes += other.candidate_lanes;
        return *this;
    }
};

enum class PassEnd { complete, cancelled };

} // namespace lumisweep
