#include "lumisweep/image/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/error.h"

namespace lumisweep {
namespace {

const std::vector<float>& plane(const Image& image, const char* channel, const char* which)
{
    const Channel* found = image.find(channel);
    require(found, "compare: the {} has no channel {} (R, G and B are compared)", which, channel);
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    require(found->pixels.size() == pixels, "compare: channel {} of the {} has {} pixels where {} x {} are {}", channel,
            which, found->pixels.size(), image.width, image.height, pixels);
    return found->pixels;
}

void require_finite(const Image& image, const char* which)
{
    std::size_t bad = 0;
    const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::vector<float>&r = plane(image, "R", which), &g = plane(image, "G", which), &b = plane(image, "B", which);
    for (std::size_t i = 0; i < pixels; ++i)
        bad += !(std::isfinite(r[i]) && std::isfinite(g[i]) && std::isfinite(b[i]));
    require(bad == 0, "compare: {} of the {} pixels of the {} are infinite or NaN (nothing can be measured on them)",
            bad, pixels, which);
}

} // namespace

Comparison compare_images(const Image& image, const Image& reference)
{
    require(image.width == reference.width && image.height == reference.height,
            "compare: the image has {} x {} pixels, the reference {} x {} (they must be equal)", image.width,
            image.height, reference.width, reference.height);
    require(image.width > 0 && image.height > 0, "compare: the images are empty");
    require_finite(image, "image");
    require_finite(reference, "reference");

    Comparison sum;
    double peak = 0.0;
    for (const char* channel : {"R", "G", "B"}) {
        const std::vector<float>& a = plane(image, channel, "image");
        const std::vector<float>& b = plane(reference, channel, "reference");
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double x = a[i], y = b[i], square = (x - y) * (x - y);
            sum.mse += square;
            sum.relmse += square / (y * y + 1e-2);
            sum.mean_image += x;
            sum.mean_reference += y;
            peak = std::max(peak, y);
        }
    }
    const double values = 3.0 * image.width * image.height;
    sum.mse /= values;
    sum.relmse /= values;
    sum.mean_image /= values;
    sum.mean_reference /= values;
    sum.rmse = std::sqrt(sum.mse);
    sum.psnr = sum.mse > 0.0 ? 10.0 * std::log10(peak * peak / sum.mse) : std::numeric_limits<double>::infinity();
    return sum;
}

} // namespace lumisweep
