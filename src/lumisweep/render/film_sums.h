// What a film adds up, and how a sample is added: on the host, and on a device that keeps the sums itself.
#pragma once

#include <cstddef>

#include "lumisweep/base/host_device.h"

namespace lumisweep {

/// Numbers that a film keeps of a sample besides its colour.
inline constexpr int feature_count = 8;

/// Memory: color_sum, color_sum_squares (of samples), block_sum_squares (of whole blocks' sums) and block_begin (what
/// color_sum was when the block under way began) [pixels][3]; features [pixels][feature_count]: albedo r g b, normal
/// x y z (world), depth, and the part of the sample that met the volume.
struct FilmSums {
    double *color_sum, *color_sum_squares, *block_sum_squares, *block_begin;
    float* features;
};

/// Whether a sample is the last of its block of stratified samples (render/pass.h).
enum class BlockEnd { no, yes };

/// Adds a sample's element i, 3 · pixel + colour.
LUMISWEEP_HD void add_color(const FilmSums& film, std::size_t i, float sample, BlockEnd block_end)
{
    const double c = static_cast<double>(sample);
    film.color_sum[i] += c;
    film.color_sum_squares[i] += c * c;
    if (block_end == BlockEnd::no)
        return;
    const double block = film.color_sum[i] - film.block_begin[i];
    film.block_sum_squares[i] += block * block;
    film.block_begin[i] = film.color_sum[i];
}

} // namespace lumisweep
