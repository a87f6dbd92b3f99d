#include "lumisweep/volume/io/dicom_slices.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

constexpr double regular_tolerance = 0.01; // of the mean gap: positions are written with few digits
constexpr double missing_factor = 1.5;     // of the median gap
constexpr double same_position = 1e-3;     // mm

/// Slices without a position: in the order of their numbers, at the header's distance.
void place_by_number(std::vector<DicomSlice>& slices, const Vec3d& normal, double distance)
{
    std::stable_sort(slices.begin(), slices.end(),
                     [](const auto& a, const auto& b) { return a.instance < b.instance; });
    for (std::size_t i = 0; i < slices.size(); ++i)
        slices[i].position = normal * (double(i) * distance);
}

std::size_t drop_duplicates(std::vector<DicomSlice>& slices, const Vec3d& normal)
{
    const std::size_t before = slices.size();
    const auto last = std::unique(slices.begin(), slices.end(), [&](const auto& a, const auto& b) {
        return std::abs(dot(b.position - a.position, normal)) < same_position;
    });
    slices.erase(last, slices.end());
    return before - slices.size();
}

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Planes at equal distances from the first slice to the last, each a blend of its neighbours.
void resample(SliceStack& stack, const std::vector<double>& gaps, std::size_t count)
{
    std::vector<double> at(stack.slices.size(), 0.0);
    std::partial_sum(gaps.begin(), gaps.end(), at.begin() + 1);
    const double spacing = at.back() / double(count - 1);
    std::size_t below = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double t = std::min(double(i) * spacing, at.back());
        while (below + 2 < at.size() && at[below + 1] <= t)
            ++below;
        const double weight = std::clamp((t - at[below]) / (at[below + 1] - at[below]), 0.0, 1.0);
        stack.planes.push_back({below, below + 1, weight});
    }
    stack.resampled = true;
}

} // namespace

SliceStack stack_slices(const DicomSeries& series, const std::string& where, std::vector<std::string>& warnings)
{
    const Vec3d across = cross(series.row_direction, series.column_direction);
    require(length(across) > 1e-3, "{}: the image orientation is degenerate (export the series again)", where);
    const Vec3d normal = normalized(across);
    double distance = series.thickness;
    if (!(distance > 0.0 && std::isfinite(distance)))
        distance = 1.0;

    SliceStack stack;
    stack.slices = series.slices;
    std::vector<DicomSlice>& slices = stack.slices;
    if (!std::all_of(slices.begin(), slices.end(), [](const auto& s) { return s.has_position; })) {
        place_by_number(slices, normal, distance);
        if (slices.size() > 1)
            warnings.push_back(
                fmt::format("{}: slices without a position are stacked by number, {} mm apart", where, distance));
    }
    // By number where positions repeat, so that a time series, whose first slices are kept, gives one moment.
    std::stable_sort(slices.begin(), slices.end(), [&](const auto& a, const auto& b) {
        return std::make_pair(dot(a.position, normal), a.instance) <
               std::make_pair(dot(b.position, normal), b.instance);
    });
    if (const std::size_t dropped = drop_duplicates(slices, normal); dropped > 0)
        warnings.push_back(fmt::format("{}: {} slices repeat a position and are left out (the first of each is kept)",
                                       where, dropped));

    stack.origin = slices.front().position;
    if (slices.size() == 1) {
        stack.step = normal * distance;
        stack.planes.push_back({0, 0, 0.0});
        return stack;
    }

    std::vector<double> gaps;
    for (std::size_t i = 0; i + 1 < slices.size(); ++i)
        gaps.push_back(dot(slices[i + 1].position - slices[i].position, normal));
    const auto [low, high] = std::minmax_element(gaps.begin(), gaps.end());
    const double total = std::accumulate(gaps.begin(), gaps.end(), 0.0), mean = total / double(gaps.size());
    const double usual = median(gaps);
    const auto missing = std::count_if(gaps.begin(), gaps.end(), [&](double g) { return g > missing_factor * usual; });
    if (missing > 0) {
        require(total / usual < 8191.0,
                "{}: slices from {:.4g} to {:.4g} mm apart do not make a volume (choose one series)", where, *low,
                *high);
        const auto count = static_cast<std::size_t>(std::lround(total / usual)) + 1;
        resample(stack, gaps, count);
        warnings.push_back(
            fmt::format("{}: slices seem to be MISSING in {} places: gaps of {:.4g} to {:.4g} mm, usually "
                        "{:.4g}; the holes are filled by linear resampling to {} slices, {:.5g} mm apart",
                        where, missing, *low, *high, usual, count, total / double(count - 1)));
    } else if (std::max(*high - mean, mean - *low) > regular_tolerance * mean) {
        resample(stack, gaps, slices.size());
        warnings.push_back(
            fmt::format("{}: irregular slice gaps of {:.4g} to {:.4g} mm; resampled linearly to {} slices, "
                        "{:.5g} mm apart",
                        where, *low, *high, slices.size(), mean));
    } else {
        for (std::size_t i = 0; i < slices.size(); ++i)
            stack.planes.push_back({i, i, 0.0});
    }
    stack.step = (slices.back().position - stack.origin) * (1.0 / double(stack.planes.size() - 1));

    // With gantry tilt the slices are shifted as well as stacked: the step, not the normal, is the third axis.
    const Vec3d drift = stack.step - normal * dot(stack.step, normal);
    const double pixel = std::min(series.column_spacing, series.row_spacing);
    if (length(drift) * double(stack.planes.size() - 1) > 0.5 * pixel)
        warnings.push_back(
            fmt::format("{}: gantry tilt of {:.3g} degrees; the sheared grid is kept as it is, not resampled", where,
                        std::atan2(length(drift), dot(stack.step, normal)) * 180.0 / 3.14159265358979));
    double stray = 0.0;
    for (const DicomSlice& s : slices) {
        const Vec3d offset = s.position - stack.origin;
        stray = std::max(stray, length(offset - stack.step * (dot(offset, normal) / dot(stack.step, normal))));
    }
    if (stray > 0.5 * pixel)
        warnings.push_back(
            fmt::format("{}: slices are up to {:.3g} mm off a straight stack, which is ignored", where, stray));
    return stack;
}

} // namespace lumisweep
