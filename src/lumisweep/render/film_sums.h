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

/// The sums of one element, 3 · pixel + colour.
struct ColorSums {
    double sum, sum_squares, block_sum_squares, block_begin;

    LUMISWEEP_HD void add(float sample, BlockEnd block_end)
    {
        const double c = static_cast<double>(sample);
        sum += c;
        sum_squares += c * c;
        if (block_end == BlockEnd::no)
            return;
        const double block = sum - block_begin;
        block_sum_squares += block * block;
        block_begin = sum;
    }
};

LUMISWEEP_HD ColorSums load_sums(const FilmSums& film, std::size_t i)
{
    return {film.color_sum[i], film.color_sum_squares[i], film.block_sum_squares[i], film.block_begin[i]};
}
LUMISWEEP_HD void store_sums(const FilmSums& film, std::size_t i, const ColorSums& sums)
{
    film.color_sum[i] = sums.sum;
    film.color_sum_squares[i] = sums.sum_squares;
    film.block_sum_squares[i] = sums.block_sum_squares;
    film.block_begin[i] = sums.block_begin;
}

} // namespace lumisweep
