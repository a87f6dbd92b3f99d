// Random numbers for dithered rounding, cheap enough for every voxel.
#pragma once

#include <cstdint>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

/// Neighbours along x that share a run of numbers.
inline constexpr int dither_run = 64;
inline constexpr int dither_count = (1 << 16) + dither_run;

/// dither_count numbers: every one of 16 bits once, shuffled, and the first dither_run of them again, so that a run may
/// start at any of the 2^16. As runs start at hashed places, rounding up is exactly as likely as the fraction says.
const std::uint16_t* dither_numbers();

/// Where run `run` of row `row` starts. It depends on nothing else, so results are the same for any number of threads.
LUMISWEEP_HD std::uint32_t dither_start(std::uint32_t row, std::uint32_t run)
{
    std::uint32_t h = row * 0x9e3779b1U + run * 0x632be5abU;
    h ^= h >> 15;
    h *= 0x85ebca77U;
    h ^= h >> 13;
    h *= 0xc2b2ae3dU;
    return h >> 16;
}

} // namespace lumisweep
