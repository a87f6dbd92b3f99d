// The film: per-pixel sums over samples, and the image that they mean.
#pragma once

#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/image/image.h"
#include "lumisweep/render/pass.h"

namespace lumisweep {

/// Sums over samples, whole passes at a time. Stratified samples are independent between blocks only (samples_a_block),
/// so their variance comes from the blocks' sums. Memory: color_sum, color_sum_squares (of samples), block_sum_squares
/// (of whole blocks' sums) and block_begin (what color_sum was when the block under way began) [pixels][3] double;
/// features [pixels][8] float: albedo r g b, normal x y z (world), depth, and the part of the sample that met the
/// volume.
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
    /// How samples are drawn; of an empty film. Independent at first.
    Draws draws() const { return draws_; }
    void set_draws(Draws draws) { draws_ = draws; }
    void clear();

    /// Adds one sample of every pixel and sets `samples` back to zeros for the next pass.
    void add(const SampleView& samples);

    /// The sums, for checkpoints: written and read back whole.
    AlignedArray<double>& color_sum() { return color_sum_; }
    const AlignedArray<double>& color_sum() const { return color_sum_; }
    AlignedArray<double>& color_sum_squares() { return color_sum_squares_; }
    const AlignedArray<double>& color_sum_squares() const { return color_sum_squares_; }
    AlignedArray<double>& block_sum_squares() { return block_sum_squares_; }
    const AlignedArray<double>& block_sum_squares() const { return block_sum_squares_; }
    AlignedArray<double>& block_begin() { return block_begin_; }
    const AlignedArray<double>& block_begin() const { return block_begin_; }
    AlignedArray<float>& features() { return features_; }
    const AlignedArray<float>& features() const { return features_; }

    /// Estimated relative error of the image: √(mean over pixels of the luminance variance of the pixel's mean) / mean
    /// luminance. +infinity below two samples or for a black image whose variance is unknown.
    double noise() const;

    /// Layers as documented in docs/output.md: R G B A, Variance.*, albedo.*, normal.*, depth.Z.
    Image to_image() const;

    /// Estimated variance of element i (3 · pixel + colour) of the mean image; from two samples on. For one pixel: of
    /// stratified samples, few blocks tell little (a χ² of one degree of freedom less than there are), so below eight
    /// their variance is taken as if they were independent, which is too much rather than too little.
    double variance_of_mean(std::size_t i) const;
    /// The same for means over many pixels: from two blocks on without bias, however few they are.
    double unbiased_variance_of_mean(std::size_t i) const;

private:
    int width_ = 0, height_ = 0;
    std::int64_t samples_ = 0;
    AlignedArray<double> color_sum_, color_sum_squares_, block_sum_squares_, block_begin_;
    Draws draws_ = Draws::independent;
    AlignedArray<float> features_;
};

} // namespace lumisweep
