#include "lumisweep/image/tonemap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "lumisweep/base/error.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep {
namespace {

constexpr double key = 0.25;

double luminance_rec709(const std::array<double, 3>& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/// Straight (not premultiplied) colours of an image, with what cannot be shown taken out.
class Colours {
public:
    Colours(const Image& image, Background background)
    {
        const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
        require(image.width > 0 && image.height > 0, "tone mapping: the image is empty");
        for (std::size_t c = 0; c < 4; ++c) {
            const std::string name(1, "RGBA"[c]);
            const Channel* channel = image.find(name);
            require(c == 3 || channel, "tone mapping: no channel {} (R, G and B are needed)", name);
            if (!channel || (c == 3 && background == Background::opaque))
                continue;
            require(channel->pixels.size() == pixels, "tone mapping: channel {} has {} pixels where {} x {} are {}",
                    name, channel->pixels.size(), image.width, image.height, pixels);
            plane_[c] = channel->pixels.data();
        }
    }

    double alpha(std::size_t i) const { return plane_[3] ? std::clamp(finite(plane_[3][i]), 0.0, 1.0) : 1.0; }

    std::array<double, 3> colour(std::size_t i) const
    {
        const double a = alpha(i);
        if (a <= 0.0)
            return {0.0, 0.0, 0.0};
        return {std::max(finite(plane_[0][i]), 0.0) / a, std::max(finite(plane_[1][i]), 0.0) / a,
                std::max(finite(plane_[2][i]), 0.0) / a};
    }

private:
    static double finite(float value) { return std::isfinite(value) ? static_cast<double>(value) : 0.0; }

    std::array<const float*, 4> plane_{};
};

std::size_t pixel_count(const Image& image)
{
    return static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

double exposure_of(const Colours& colours, std::size_t pixels)
{
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < pixels; ++i) {
        const double l = luminance_rec709(colours.colour(i)), a = colours.alpha(i);
        if (l > 0.0) {
            sum += a * std::log(l);
            weight += a;
        }
    }
    return weight > 0.0 ? key / std::exp(sum / weight) : 1.0;
}

/// The 99.9th percentile of luminance, 0 included.
double white_luminance(const Colours& colours, std::size_t pixels)
{
    std::vector<float> values(pixels);
    for (std::size_t i = 0; i < pixels; ++i)
        values[i] = static_cast<float>(std::min(luminance_rec709(colours.colour(i)), 1e38));
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>((pixels - 1) * 999 / 1000);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

/// Displayed linear colour in [0, 1].
std::array<double, 3> compress(std::array<double, 3> colour, double white)
{
    const double l = luminance_rec709(colour);
    if (!(l > 0.0))
        return {0.0, 0.0, 0.0};
    const double shown = std::min(l * (1.0 + l / (white * white)) / (1.0 + l), 1.0);
    double largest = 0.0;
    for (double& c : colour) {
        c *= shown / l;
        largest = std::max(largest, c);
    }
    if (largest > 1.0) {
        const double keep = (1.0 - shown) / (largest - shown);
        for (double& c : colour)
            c = shown + keep * (c - shown);
    }
    return colour;
}

std::uint8_t to_byte(double value)
{
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

/// IEC 61966-2-1.
double srgb_from_linear(double c) { return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055; }

} // namespace

double automatic_exposure(const Image& image, Background background)
{
    return exposure_of(Colours(image, background), pixel_count(image));
}

ToneMapSettings display_settings(const Image& image, Background background)
{
    ToneMapSettings display;
    display.background = background;
    if (background == Background::opaque)
        display.exposure = std::sqrt(automatic_exposure(image, Background::transparent) *
                                     automatic_exposure(image, Background::opaque));
    return display;
}

DisplayImage tone_map(const Image& image, const ToneMapSettings& settings)
{
    const Colours colours(image, settings.background);
    const std::size_t pixels = pixel_count(image);
    const double exposure = settings.exposure ? *settings.exposure : exposure_of(colours, pixels);
    require(std::isfinite(exposure) && exposure > 0.0, "tone mapping: exposure {} (it must be positive)", exposure);
    const double white = std::max(1.0, exposure * white_luminance(colours, pixels));

    DisplayImage out{image.width, image.height, 3, {}};
    for (std::size_t i = 0; i < pixels && out.channels == 3; ++i)
        out.channels = colours.alpha(i) < 1.0 ? 4 : 3;
    const auto stride = static_cast<std::size_t>(out.channels);
    out.pixels.resize(pixels * stride);
    parallel_for(
        std::size_t{0}, pixels,
        [&](std::size_t i) {
            std::array<double, 3> colour = colours.colour(i);
            for (double& c : colour)
                c *= exposure;
            colour = compress(colour, white);
            for (std::size_t c = 0; c < 3; ++c)
                out.pixels[i * stride + c] = to_byte(srgb_from_linear(colour[c]));
            if (stride == 4)
                out.pixels[i * stride + 3] = to_byte(colours.alpha(i));
        },
        4096);
    return out;
}

} // namespace lumisweep
