#include "lumisweep/visibility/sweep_filter.h"

#include <algorithm>
#include <cmath>

#include "lumisweep/math/trigonometry.h"

namespace lumisweep {
namespace {

/// A box of `box` cells about a cell's centre: the `reach` cells on either side wholly, one more by `fraction`.
struct Box {
    int reach;
    float fraction;

    Box(double box, int count)
    {
        const double side = std::clamp(0.5 * (box - 1.0), 0.0, static_cast<double>(count));
        reach = static_cast<int>(side);
        fraction = static_cast<float>(side - reach);
    }
    bool is_identity() const { return reach == 0 && fraction < 1e-4F; }
};

/// 1 / cells that the box covers inside of a line of `count` cells.
void fill_inverse(std::vector<float>& inverse, const Box& box, int count)
{
    for (int i = 0; i < count; ++i) {
        const int first = std::max(i - box.reach, 0), last = std::min(i + box.reach, count - 1);
        const int ends = (i - box.reach - 1 >= 0 ? 1 : 0) + (i + box.reach + 1 < count ? 1 : 0);
        inverse[static_cast<std::size_t>(i)] =
            1.0F / (static_cast<float>(last - first + 1) + box.fraction * static_cast<float>(ends));
    }
}

} // namespace

double filter_angle(SweepFilter filter, int directions)
{
    const double texel_half_angle = pi / 16.0 * 8.0 / directions;
    switch (filter) {
    case SweepFilter::half_angle: return 0.5 * texel_half_angle;
    case SweepFilter::full_angle: return texel_half_angle;
    default: return 0.0;
    }
}

SliceFilter::SliceFilter(int width, int height)
    : width_(width), height_(height), row_(3 * static_cast<std::size_t>(width) + 4),
      sums_(std::max(3 * static_cast<std::size_t>(width) + 5, static_cast<std::size_t>(width))),
      out_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      inverse_(static_cast<std::size_t>(std::max(width, height)))
{
}

void SliceFilter::apply(std::int32_t* slice, double box_u, double box_v)
{
    along_u(slice, box_u);
    along_v(slice, box_v);
}

void SliceFilter::along_u(std::int32_t* slice, double box_width)
{
    const Box box(box_width, width_);
    if (box.is_identity() || width_ == 1)
        return;
    fill_inverse(inverse_, box, width_);
    // A row with zeros around it, so that the loops have no borders: cell i at row[i + pad].
    const int pad = box.reach + 1;
    const int padded = width_ + 2 * pad;
    std::int32_t* row = row_.data();
    std::int32_t* sums = sums_.data(); // sums[i] = row[0] + … + row[i − 1]
    const float* inverse = inverse_.data();
    std::fill(row, row + padded, 0);
    for (int j = 0; j < height_; ++j) {
        std::int32_t* line = slice + static_cast<std::ptrdiff_t>(j) * width_;
        std::copy(line, line + width_, row + pad);
        std::int32_t sum = 0;
        sums[0] = 0;
        for (int i = 0; i < padded; ++i)
            sums[i + 1] = sum += row[i];
        const std::int32_t* low = row;            // the cell beyond the low end
        const std::int32_t* high = row + 2 * pad; // … and the high end
        const std::int32_t* high_sum = sums + 2 * pad;
        for (int i = 0; i < width_; ++i) {
            const float whole = static_cast<float>(high_sum[i] - sums[i + 1]);
            const float ends = static_cast<float>(low[i] + high[i]) * box.fraction;
            line[i] = static_cast<std::int32_t>((whole + ends) * inverse[i] + 0.5F);
        }
    }
}

void SliceFilter::along_v(std::int32_t* slice, double box_height)
{
    const Box box(box_height, height_);
    if (box.is_identity() || height_ == 1)
        return;
    fill_inverse(inverse_, box, height_);
    const auto line = [&](int j) { return slice + static_cast<std::ptrdiff_t>(j) * width_; };
    std::int32_t* sums = sums_.data();
    std::int32_t* zeros = row_.data();
    std::fill(zeros, zeros + width_, 0);
    std::fill(sums, sums + width_, 0);
    for (int j = 0; j < std::min(box.reach, height_); ++j)
        for (int i = 0; i < width_; ++i)
            sums[i] += line(j)[i];
    for (int j = 0; j < height_; ++j) {
        const auto existing = [&](int k) -> const std::int32_t* { return k >= 0 && k < height_ ? line(k) : zeros; };
        const std::int32_t* entering = existing(j + box.reach);
        const std::int32_t* leaving = existing(j - box.reach - 1); // also the cell beyond the low end
        const std::int32_t* beyond = existing(j + box.reach + 1);
        std::int32_t* out = out_.data() + static_cast<std::ptrdiff_t>(j) * width_;
        const float inverse = inverse_[static_cast<std::size_t>(j)];
        for (int i = 0; i < width_; ++i) {
            sums[i] += entering[i] - leaving[i];
            const float ends = static_cast<float>(leaving[i] + beyond[i]) * box.fraction;
            out[i] = static_cast<std::int32_t>((static_cast<float>(sums[i]) + ends) * inverse + 0.5F);
        }
    }
    std::copy(out_.begin(), out_.end(), slice);
}

} // namespace lumisweep
