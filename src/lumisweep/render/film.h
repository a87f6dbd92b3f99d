// The film: per-pixel sums over samples, and the image that they mean.
#pragma once

#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/image/image.h"
#include "lumisweep/render/pass.h"

namespace lumisweep {

/// Sums over samples, whole passes at a time. The samples of a block (samples_a_block) may be stratified together, so
/// the variance is taken from the blocks' sums, which are independent; below two blocks from single samples, which for
/// stratified ones is too much rather than too little.
/// Memory: color_sum, color_sum_squares and block_begin [pixels][3] double, the squares of single samples up to two
/// blocks and of blocks' sums from there on, block_begin what color_sum was when the block began; features [pixels][8]
/// float: albedo r g b, normal x y z (world), depth, and the part of the sample that met the volume.
class Film {
public:
    static constexpr int feature_count = 8;
    /// The film itself and one pass's samples.
    static std::uint64_t bytes_needed(int width, int height);

    Film() = default;
    Film(int width, int height);

    int width() const { return width_; }
    int height() const { return height_; }
    std::int64_t samples() const { return samples_; } ///< per pixel
    void set_samples(std::int64_t samples) { samples_ = samples; }
    void clear();

    /// Adds one sample of every pixel and sets `samples` back to zeros for the next pass.
    void add(const SampleView& samples);

    /// The sums, for checkpoints: written and read back whole.
    AlignedArray<double>& color_sum() { return color_sum_; }
    const AlignedArray<double>& color_sum() const { return color_sum_; }
    AlignedArray<double>& color_sum_squares() { return color_sum_squares_; }
    const AlignedArray<double>& color_sum_squares() const { return color_sum_squares_; }
    AlignedArray<double>& block_begin() { return block_begin_; }
    const AlignedArray<double>& block_begin() const { return block_begin_; }
    AlignedArray<float>& features() { return features_; }
    const AlignedArray<float>& features() const { return features_; }

    /// Estimated relative error of the image: √(mean over pixels of the luminance variance of the pixel's mean) / mean
    /// luminance. +infinity below two samples or for a black image whose variance is unknown.
    double noise() const;

    /// Layers as documented in docs/output.md: R G B A, Variance.*, albedo.*, normal.*, depth.Z.
    Image to_image() const;

    /// Estimated variance of element i (3 · pixel + colour) of the mean image; from two samples on.
    double variance_of_mean(std::size_t i) const;

private:
    int width_ = 0, height_ = 0;
    std::int64_t samples_ = 0;
    AlignedArray<double> color_sum_, color_sum_squares_, block_begin_;
    AlignedArray<float> features_;
};

} // namespace lumisweep
