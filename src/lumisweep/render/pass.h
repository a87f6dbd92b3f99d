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

    PassCounts& operator+=(const PassCounts& other)
    {
        paths += other.paths;
        camera_steps += other.camera_steps;
        shadow_steps += other.shadow_steps;
        return *this;
    }
};

enum class PassEnd { complete, cancelled };

} // namespace lumisweep
