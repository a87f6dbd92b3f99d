#include "lumisweep/render/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/parallel.h"
#include "lumisweep/light/environment.h"

namespace lumisweep {

namespace {

std::size_t pixels_of(int width, int height)
{
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

/// From the sum and the sum of squares of n equal, independent parts.
double variance_of_part(double sum, double sum_squares, double n)
{
    return std::max(sum_squares - sum * sum / n, 0.0) / (n - 1.0);
}

/// Blocks from which the variance of a single pixel is taken.
constexpr std::int64_t enough_blocks = 8;

} // namespace

std::uint64_t Film::bytes_needed(int width, int height)
{
    constexpr std::uint64_t film = 12 * sizeof(double) + feature_count * sizeof(float);
    constexpr std::uint64_t samples = (3 + feature_count) * sizeof(float);
    return pixels_of(width, height) * (film + samples);
}

Film::Film(int width, int height) : width_(width), height_(height)
{
    const std::size_t pixels = pixels_of(width, height);
    for (AlignedArray<double>* sums :
         {&arrays_.color_sum, &arrays_.color_sum_squares, &arrays_.block_sum_squares, &arrays_.block_begin})
        *sums = AlignedArray<double>(3 * pixels);
    arrays_.features = AlignedArray<float>(pixels * feature_count);
}

void Film::clear()
{
    samples_ = 0;
    late_ = nullptr;
    for (AlignedArray<double>* sums :
         {&arrays_.color_sum, &arrays_.color_sum_squares, &arrays_.block_sum_squares, &arrays_.block_begin})
        std::fill(sums->begin(), sums->end(), 0.0);
    std::fill(arrays_.features.begin(), arrays_.features.end(), 0.0F);
}

void Film::add(const SampleView& samples)
{
    const FilmSums sums = arrays().sums();
    const std::int64_t after = samples_ + 1;
    const BlockEnd block_end = after % samples_a_block == 0 ? BlockEnd::yes : BlockEnd::no;
    const std::size_t row = static_cast<std::size_t>(width_);
    parallel_for(0, height_, [&](int y) {
        const std::size_t first = static_cast<std::size_t>(y) * row;
        for (std::size_t i = first * 3; i < (first + row) * 3; ++i) {
            ColorSums of_element = load_sums(sums, i);
            of_element.add(samples.color[i], block_end);
            store_sums(sums, i, of_element);
            samples.color[i] = 0.0F;
        }
        for (std::size_t i = first * feature_count; i < (first + row) * feature_count; ++i) {
            sums.features[i] += samples.features[i];
            samples.features[i] = 0.0F;
        }
    });
    samples_ = after;
}

void Film::grown(std::int64_t samples, FilmSource& source)
{
    samples_ = samples;
    late_ = &source;
}

void Film::fetch() const
{
    if (late_ == nullptr)
        return;
    late_->fetch(arrays_);
    late_ = nullptr; // only when all went well
}

double Film::variance_of_mean(std::size_t i) const
{
    const FilmArrays& a = arrays();
    const auto n = static_cast<double>(samples_);
    if (draws_ == Draws::stratified && samples_ >= enough_blocks * samples_a_block)
        return unbiased_variance_of_mean(i);
    return variance_of_part(a.color_sum[i], a.color_sum_squares[i], n) / n;
}

double Film::unbiased_variance_of_mean(std::size_t i) const
{
    const std::int64_t blocks = samples_ / samples_a_block;
    if (draws_ == Draws::independent || blocks < 2)
        return variance_of_mean(i);
    // All samples make the mean, those of the block under way as well.
    const FilmArrays& a = arrays();
    return variance_of_part(a.block_begin[i], a.block_sum_squares[i], static_cast<double>(blocks)) /
           static_cast<double>(samples_a_block) / static_cast<double>(samples_);
}

double Film::noise() const
{
    if (samples_ < 2)
        return std::numeric_limits<double>::infinity();
    const double n = static_cast<double>(samples_);
    const AlignedArray<double>& sums = color_sum();
    double variance = 0.0, mean = 0.0;
    for (std::size_t i = 0; i < sums.size(); i += 3) {
        const double* s = sums.data() + i;
        // Channels of a sample are almost perfectly correlated, so standard deviations add, weighted by luminance.
        const double deviation =
            luminance(std::sqrt(unbiased_variance_of_mean(i)), std::sqrt(unbiased_variance_of_mean(i + 1)),
                      std::sqrt(unbiased_variance_of_mean(i + 2)));
        variance += deviation * deviation;
        mean += luminance(s[0], s[1], s[2]) / n;
    }
    const double pixels = static_cast<double>(sums.size() / 3);
    return mean > 0.0 ? std::sqrt(variance / pixels) / (mean / pixels) : std::numeric_limits<double>::infinity();
}

Image Film::to_image() const
{
    const AlignedArray<double>& sums = color_sum();
    const AlignedArray<float>& all_features = features();
    Image image;
    image.width = width_;
    image.height = height_;
    const std::size_t pixels = pixels_of(width_, height_);
    const double n = static_cast<double>(std::max<std::int64_t>(samples_, 1));
    const auto channel = [&](const char* name, auto&& value) {
        Channel c{name, std::vector<float>(pixels)};
        for (std::size_t p = 0; p < pixels; ++p)
            c.pixels[p] = static_cast<float>(value(p));
        image.channels.push_back(std::move(c));
    };
    const auto color = [&](const char* name, std::size_t i) {
        channel(name, [&](std::size_t p) { return sums[3 * p + i] / n; });
    };
    const auto variance = [&](const char* name, std::size_t i) {
        channel(name, [&](std::size_t p) { return samples_ < 2 ? 0.0 : variance_of_mean(3 * p + i); });
    };
    const auto feature = [&](const char* name, std::size_t i) {
        channel(name, [&](std::size_t p) { return all_features[feature_count * p + i] / n; });
    };
    color("R", 0), color("G", 1), color("B", 2);
    feature("A", 7);
    variance("Variance.R", 0), variance("Variance.G", 1), variance("Variance.B", 2);
    feature("albedo.R", 0), feature("albedo.G", 1), feature("albedo.B", 2);
    feature("normal.X", 3), feature("normal.Y", 4), feature("normal.Z", 5);
    // The mean over the samples that met the volume; 0 where none did.
    channel("depth.Z", [&](std::size_t p) {
        const float* f = all_features.data() + feature_count * p;
        return f[7] > 0.0F ? f[6] / f[7] : 0.0F;
    });
    return image;
}

} // namespace lumisweep
