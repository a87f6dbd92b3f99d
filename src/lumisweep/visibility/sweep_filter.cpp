#include "lumisweep/visibility/sweep_filter.h"

#include <algorithm>

#include "lumisweep/math/trigonometry.h"
#include "lumisweep/visibility/sweep_box.h"

namespace lumisweep {
namespace {

void bound(const Box& box, std::uint16_t* line, int count)
{
    if (box.shift > most_exact_shift)
        std::transform(line, line + count, line, [](std::uint16_t v) { return bounded_visibility(v); });
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

SliceFilter::SliceFilter(const SweepKernels& kernels, int width, int height)
    : kernels_(kernels), width_(width), height_(height),
      out_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      scale_whole_(static_cast<std::size_t>(width)), scale_ends_(static_cast<std::size_t>(width)),
      row_(3 * static_cast<std::size_t>(width) + 4), power_(row_.size()), next_power_(row_.size()),
      sums_(static_cast<std::size_t>(width)), next_sums_(static_cast<std::size_t>(width)),
      zeros_(static_cast<std::size_t>(width))
{
}

const std::uint16_t* SliceFilter::apply(std::uint16_t* slice, double box_u, double box_v)
{
    along_u(slice, box_u);
    return along_v(slice, box_v);
}

void SliceFilter::along_u(std::uint16_t* slice, double box_width)
{
    const Box box(box_width, width_);
    if (box.is_identity(width_))
        return;
    const BoxScales inside = box.inside();
    std::fill(scale_whole_.begin(), scale_whole_.end(), inside.whole);
    std::fill(scale_ends_.begin(), scale_ends_.end(), inside.ends);
    for (int i = 0; i < width_; ++i) {
        if (i == box.reach + 1)
            i = std::max(i, width_ - box.reach - 1); // the box is whole in between
        const BoxScales scales = box.scales(i, width_);
        scale_whole_[static_cast<std::size_t>(i)] = scales.whole;
        scale_ends_[static_cast<std::size_t>(i)] = scales.ends;
    }
    // A row with zeros around it, so that the loops have no borders: cell i at row[i + pad].
    const int pad = box.reach + 1, padded = width_ + 2 * pad, half = (1 << box.shift) >> 1;
    std::uint16_t* row = row_.data();
    std::fill(row, row + padded, std::uint16_t{0});
    for (int j = 0; j < height_; ++j) {
        std::uint16_t* line = slice + static_cast<std::ptrdiff_t>(j) * width_;
        if (box.shift == 0)
            std::copy(line, line + width_, row + pad);
        else
            std::transform(line, line + width_, row + pad,
                           [&](std::uint16_t v) { return shifted_visibility(v, box.shift, half); });
        // Sums of 1, 2, 4, … neighbours; those in the width's binary digits make up the box.
        const std::uint16_t *power = row, *sums = row + 1;
        std::uint16_t *next_power = power_.data(), *spare_power = next_power_.data();
        std::uint16_t *next_sums = sums_.data(), *spare_sums = next_sums_.data();
        int distance = 1, begin = 2;
        for (int rest = box.width() >> 1, count = padded; rest != 0; rest >>= 1) {
            count -= distance;
            kernels_.add(next_power, power, power + distance, count);
            power = next_power;
            std::swap(next_power, spare_power);
            distance *= 2;
            if ((rest & 1) == 0)
                continue;
            kernels_.add(next_sums, sums, power + begin, width_);
            sums = next_sums;
            std::swap(next_sums, spare_sums);
            begin += distance;
        }
        kernels_.box_mean(line, sums, row, row + 2 * pad, scale_whole_.data(), scale_ends_.data(), width_);
        bound(box, line, width_);
    }
}

const std::uint16_t* SliceFilter::along_v(std::uint16_t* slice, double box_height)
{
    const Box box(box_height, height_);
    if (box.is_identity(height_))
        return slice;
    const auto line = [&](int k) -> const std::uint16_t* {
        return k >= 0 && k < height_ ? slice + static_cast<std::ptrdiff_t>(k) * width_ : zeros_.data();
    };
    std::uint16_t* sums = sums_.data();
    std::fill(sums, sums + width_, std::uint16_t{0});
    for (int j = 0; j < std::min(box.reach, height_); ++j)
        kernels_.slide(sums, line(j), zeros_.data(), box.shift, width_);
    const BoxScales inside = box.inside();
    for (int j = 0; j < height_; ++j) {
        const std::uint16_t* leaving = line(j - box.reach - 1); // also the cell beyond the low end
        kernels_.slide(sums, line(j + box.reach), leaving, box.shift, width_);
        const bool whole = j > box.reach && j < height_ - box.reach - 1;
        const BoxScales scales = whole ? inside : box.scales(j, height_);
        std::uint16_t* out = out_.data() + static_cast<std::ptrdiff_t>(j) * width_;
        kernels_.box_mean_row(out, sums, leaving, line(j + box.reach + 1), box.shift, scales.whole, scales.ends,
                              width_);
        bound(box, out, width_);
    }
    return out_.data();
}

} // namespace lumisweep
