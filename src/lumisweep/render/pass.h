// What one pass takes and gives: a sample of every pixel, and counts.
#pragma once

#include <cstdint>

namespace lumisweep {

/// One pass's samples, one per pixel, zero where a path brought nothing.
/// Memory: color [pixels][3] float; features [pixels][8] float, the order of Film's.
struct SampleView {
    float* color = nullptr;
    float* features = nullptr;
};

/// Counts of a pass, for --stats.
struct PassCounts {
    std::uint64_t paths = 0;        ///< camera rays
    std::uint64_t camera_steps = 0; ///< tentative collisions of camera segments
    std::uint64_t shadow_steps = 0; ///< tentative collisions of shadow segments
    /// Lanes that went through a cell, a block or empty space, and all lanes of the groups that they were in; and all
    /// lanes of the groups that tentative collisions were in. Utilisation is advance_steps / advance_lanes, and
    /// (camera_steps + shadow_steps) / candidate_lanes.
    std::uint64_t advance_steps = 0, advance_lanes = 0, candidate_lanes = 0;

    PassCounts& operator+=(const PassCounts& other)
    {
        paths += other.paths;
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
