// The film: per-pixel sums over samples, and the image that they mean.
#pragma once

#include <cstdint>

#include "lumisweep/base/aligned.h"
#include "lumisweep/image/image.h"
#include "lumisweep/render/film_sums.h"
#include "lumisweep/render/pass.h"

namespace lumisweep {

/// The arrays that FilmSums points to.
struct FilmArrays {
    AlignedArray<double> color_sum, color_sum_squares, block_sum_squares, block_begin;
    AlignedArray<float> features;

    FilmSums sums()
    {
        return {color_sum.data(), color_sum_squares.data(), block_sum_squares.data(), block_begin.data(),
                features.data()};
    }
};

/// Where the sums are that a film has not got yet: on a device that adds samples by itself.
class FilmSource {
public:
    FilmSource() = default;
    FilmSource(const FilmSource&) = delete;
    FilmSource& operator=(const FilmSource&) = delete;
    virtual ~FilmSource() = default;

    /// Waits for all passes that were begun, and copies their sums.
    virtual void fetch(FilmArrays& arrays) = 0;
};

/// Sums over samples, whole passes at a time. Stratified samples are independent between blocks only (samples_a_block),
/// so their variance comes from the blocks' sums. Memory: as FilmSums says.
class Film {
public:
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

    /// `samples` samples a pixel are now in the sums of `source`, which are fetched when they are asked for. It must
    /// live until then.
    void grown(std::int64_t samples, FilmSource& source);

    /// The sums, for checkpoints: written and read back whole.
    FilmArrays& arrays()
    {
        fetch();
        return arrays_;
    }
    const FilmArrays& arrays() const
    {
        fetch();
        return arrays_;
    }
    const AlignedArray<double>& color_sum() const { return arrays().color_sum; }
    const AlignedArray<float>& features() const { return arrays().features; }

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
    void fetch() const;

    int width_ = 0, height_ = 0;
    std::int64_t samples_ = 0;
    Draws draws_ = Draws::independent;
    mutable FilmArrays arrays_;
    mutable FilmSource* late_ = nullptr; // has the sums
};

} // namespace lumisweep
