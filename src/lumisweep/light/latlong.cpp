// Why this is exact: in the equal-area octahedral square, lines of constant z are |u'| + |v'| = const and lines of
// constant azimuth are straight through the centre (Clarberg 2008), and areas are solid angles. So each pixel of the
// latitude-longitude image is, in each quadrant of each hemisphere, a trapezoid between two parallel lines and two
// rays, and its share of a texel is the area of a convex polygon.
//
// The hemispheres mirror each other: texel (i, j) of a quadrant in the upper one covers the same rows and columns,
// counted from its pole, as texel (h−1−j, h−1−i) in the lower one. If the image's width is a multiple of four, so do
// the quadrants, and one set of areas serves eight texels. Each texel gathers, so threads share nothing and the sums
// have one order.
#include "lumisweep/light/latlong.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lumisweep/base/error.h"
#include "lumisweep/base/memory.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/light/convex_polygon.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"

namespace lumisweep {
namespace {

/// The image's pixels, RGB interleaved, finite and ≥ 0.
struct Pixels {
    int width, height;
    std::vector<float> rgb;

    const float* at(int column, int row) const
    {
        return rgb.data() +
               3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column));
    }
};

Pixels clean_pixels(const Image& image, LatLongReport& report)
{
    std::array<const float*, 3> source{};
    for (std::size_t c = 0; c < 3; ++c) {
        const std::string name(1, "RGB"[c]);
        const Channel* channel = image.find(name);
        require(channel, "environment map: no channel {} (an image with R, G and B is needed)", name);
        source[c] = channel->pixels.data();
    }
    const auto width = static_cast<std::size_t>(image.width);
    Pixels pixels{image.width, image.height, std::vector<float>(3 * width * static_cast<std::size_t>(image.height))};
    std::atomic<std::uint64_t> negative{0}, non_finite{0};
    parallel_for(0, image.height, [&](int row) {
        std::uint64_t row_negative = 0, row_non_finite = 0;
        const std::size_t begin = static_cast<std::size_t>(row) * width;
        for (std::size_t i = begin; i < begin + width; ++i) {
            bool is_negative = false, is_non_finite = false;
            for (std::size_t c = 0; c < 3; ++c) {
                const float value = source[c][i];
                is_non_finite |= !std::isfinite(value);
                is_negative |= std::isfinite(value) && value < 0.0F;
                pixels.rgb[3 * i + c] = std::isfinite(value) && value > 0.0F ? value : 0.0F;
            }
            row_negative += is_negative;
            row_non_finite += is_non_finite;
        }
        negative += row_negative;
        non_finite += row_non_finite;
    });
    report.negative_texels = negative;
    report.non_finite_texels = non_finite;
    return pixels;
}

/// Where a quadrant of azimuths begins among the image's columns, counted towards increasing φ from the left edge of
/// the last column.
struct QuadrantStart {
    int column;      ///< in [0, width)
    double fraction; ///< in [0, 1): the part of that column that lies before the quadrant
};

std::array<QuadrantStart, 4> quadrant_starts(int width, double rotation_deg)
{
    const double turns = std::fmod(rotation_deg, 360.0) / 360.0;
    const double first = width * (0.5 - turns);
    std::array<QuadrantStart, 4> starts{};
    for (int q = 0; q < 4; ++q) {
        // Whole columns first: their fractions must be the same to the bit when the width is a multiple of four.
        const double part = (first - std::floor(first)) + (width % 4) * q / 4.0;
        const double column = std::floor(first) + (width / 4) * q + std::floor(part);
        starts[static_cast<std::size_t>(q)] = {static_cast<int>(column - width * std::floor(column / width)),
                                               part - std::floor(part)};
    }
    return starts;
}

/// The image's grid in one quadrant of a hemisphere: rows as radii r = |u'| + |v'|, columns as t = φ / (π/2).
class QuadrantGrid {
public:
    QuadrantGrid(int width, int height, double fraction, int half_resolution)
        : h_(half_resolution), columns_(width / 4.0), fraction_(fraction),
          last_column_(static_cast<int>(std::ceil(columns_ + fraction)) - 1), radius_((height + 1) / 2 + 1)
    {
        // r = √(1 − cos θ) = √2 sin(θ/2); an odd number of rows has the equator inside the middle one.
        for (std::size_t k = 0; k + 1 < radius_.size(); ++k)
            radius_[k] = h_ * std::sqrt(2.0) * std::sin(pi * static_cast<double>(k) / (2.0 * height));
        radius_.back() = h_;
    }

    /// Calls visit(row, column, area) for what texel (i, j), i + j < h, shares with each pixel. Rows count from the
    /// pole, columns from the quadrant's start; areas are in texels.
    template <class Visit>
    void for_each_overlap(int i, int j, Visit&& visit) const
    {
        ConvexPolygon rest, strip, beyond;
        for (const Point2& p : {Point2{0, 0}, Point2{1, 0}, Point2{1, 1}, Point2{0, 1}})
            rest.add(p);
        auto row =
            static_cast<std::size_t>(std::upper_bound(radius_.begin(), radius_.end() - 1, i + j) - radius_.begin() - 1);
        for (; row + 1 < radius_.size() && rest.size >= 3; ++row) {
            cut(rest, {1.0, 1.0, i + j - radius_[row + 1]}, strip, beyond);
            if (strip.size >= 3)
                visit_columns(i, j, static_cast<int>(row), strip, visit);
            std::swap(rest, beyond);
        }
    }

private:
    template <class Visit>
    void visit_columns(int i, int j, int row, const ConvexPolygon& strip, Visit&& visit) const
    {
        double t_min = 1.0, t_max = 0.0;
        for (int k = 0; k < strip.size; ++k) {
            const double along = j + strip[k].y, sum = along + i + strip[k].x;
            if (sum > 0.0) { // the pole itself has every azimuth
                t_min = std::min(t_min, along / sum);
                t_max = std::max(t_max, along / sum);
            }
        }
        const int first = std::clamp(static_cast<int>(t_min * columns_ + fraction_), 0, last_column_);
        const int last = std::clamp(static_cast<int>(std::ceil(t_max * columns_ + fraction_)) - 1, first, last_column_);
        if (first == last)
            return visit(row, first, area(strip));
        ConvexPolygon rest = strip, piece, beyond;
        for (int column = first; column < last; ++column) {
            const double t = std::min((column + 1 - fraction_) / columns_, 1.0);
            cut(rest, {-t, 1.0 - t, j * (1.0 - t) - i * t}, piece, beyond);
            visit(row, column, area(piece));
            std::swap(rest, beyond);
        }
        visit(row, last, area(rest));
    }

    int h_;
    double columns_, fraction_;
    int last_column_;
    std::vector<double> radius_; ///< of the row boundaries, in texels
};

struct TexelSum {
    double r = 0.0, g = 0.0, b = 0.0;

    void add(const float* rgb, double weight)
    {
        r += weight * rgb[0];
        g += weight * rgb[1];
        b += weight * rgb[2];
    }
};

class Gather {
public:
    Gather(const Pixels& pixels, int n, double scale, AlignedArray<float>& texels)
        : pixels_(pixels), h_(n / 2), scale_(scale), texels_(texels)
    {
    }

    /// Fills quadrants first … first + size − 1, which all start at the same fraction of a column.
    void quadrants(int first, std::span<const QuadrantStart> starts)
    {
        const QuadrantGrid grid(pixels_.width, pixels_.height, starts[0].fraction, h_);
        parallel_for(0, h_, [&](int j) {
            for (int i = 0; i + j < h_; ++i) {
                std::array<TexelSum, 4> upper{}, lower{};
                grid.for_each_overlap(i, j, [&](int row, int column, double area) {
                    for (std::size_t q = 0; q < starts.size(); ++q) {
                        const int counted = (starts[q].column + column) % pixels_.width;
                        const int x = pixels_.width - 1 - counted;
                        upper[q].add(pixels_.at(x, row), area);
                        lower[q].add(pixels_.at(x, pixels_.height - 1 - row), area);
                    }
                });
                for (std::size_t q = 0; q < starts.size(); ++q)
                    store(first + static_cast<int>(q), i, j, upper[q], lower[q]);
            }
        });
    }

private:
    void store(int quadrant, int i, int j, const TexelSum& upper, const TexelSum& lower)
    {
        if (i + j == h_ - 1) { // the equator passes through: half of the texel in each hemisphere
            store(quadrant, i, j, {upper.r + lower.r, upper.g + lower.g, upper.b + lower.b});
        } else {
            store(quadrant, i, j, upper);
            store(quadrant, h_ - 1 - j, h_ - 1 - i, lower);
        }
    }

    /// (i, j): texels from the centre along the axes at the quadrant's start and end.
    void store(int quadrant, int i, int j, const TexelSum& sum)
    {
        const std::array<TexelXY<int>, 4> turned{
            {{h_ + i, h_ + j}, {h_ - 1 - j, h_ + i}, {h_ - 1 - i, h_ - 1 - j}, {h_ + j, h_ - 1 - i}}};
        const TexelXY<int> texel = turned[static_cast<std::size_t>(quadrant)];
        float* rgb = texels_.data() + 3 * static_cast<std::size_t>(morton_encode(texel.x, texel.y));
        const std::array<double, 3> values{sum.r * scale_, sum.g * scale_, sum.b * scale_};
        for (std::size_t c = 0; c < 3; ++c) {
            require(values[c] <= std::numeric_limits<float>::max(),
                    "environment map: its radiance times the scale {} overflows (choose a smaller scale)", scale_);
            rgb[c] = static_cast<float>(values[c]);
        }
    }

    const Pixels& pixels_;
    int h_;
    double scale_;
    AlignedArray<float>& texels_;
};

} // namespace

std::vector<std::string> warnings_of(const LatLongReport& report, const std::string& name)
{
    std::vector<std::string> warnings;
    if (report.negative_texels > 0)
        warnings.push_back(
            fmt::format("{}: {} texels with negative radiance were set to 0", name, report.negative_texels));
    if (report.non_finite_texels > 0)
        warnings.push_back(
            fmt::format("{}: {} texels with infinite or NaN radiance were set to 0", name, report.non_finite_texels));
    return warnings;
}

int octahedral_resolution(int width, int height)
{
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    std::uint64_t n = 256;
    while (n < 16384 && n * n < pixels)
        n *= 2;
    return static_cast<int>(n);
}

Environment environment_from_latlong(const Image& latlong_rgb, double scale, double rotation_deg, LatLongReport* report)
{
    const int width = latlong_rgb.width, height = latlong_rgb.height;
    require(width > 0 && height > 0, "environment map: {} x {} pixels (it must not be empty)", width, height);
    require(std::isfinite(scale) && scale >= 0.0, "environment map: scale {} (it must be finite and not negative)",
            scale);
    require(std::isfinite(rotation_deg), "environment map: rotation {} degrees (it must be finite)", rotation_deg);

    LatLongReport result;
    result.resolution = octahedral_resolution(width, height);
    const auto texel_count =
        static_cast<std::uint64_t>(result.resolution) * static_cast<std::uint64_t>(result.resolution);
    const std::uint64_t pixel_count = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    require_memory(12 * (pixel_count + texel_count) + 16 * texel_count / 3,
                   fmt::format("the {} x {} environment map", width, height), "use a smaller map");

    const Pixels pixels = clean_pixels(latlong_rgb, result);
    AlignedArray<float> texels(3 * texel_count);
    Gather gather(pixels, result.resolution, scale, texels);
    const std::array<QuadrantStart, 4> starts = quadrant_starts(width, rotation_deg);
    if (width % 4 == 0) {
        gather.quadrants(0, starts);
    } else {
        for (int q = 0; q < 4; ++q)
            gather.quadrants(q, std::span(starts).subspan(static_cast<std::size_t>(q), 1));
    }
    if (report)
        *report = result;
    return Environment(result.resolution, std::move(texels));
}

} // namespace lumisweep
