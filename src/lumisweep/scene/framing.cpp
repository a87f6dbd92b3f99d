#include "lumisweep/scene/framing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "lumisweep/math/trigonometry.h"

namespace lumisweep {

namespace {

/// Visible voxels counted along each axis.
using Profiles = std::array<std::vector<std::uint64_t>, 3>;

Profiles empty_profiles(const Vec3i& size)
{
    return {std::vector<std::uint64_t>(static_cast<std::size_t>(size.x)),
            std::vector<std::uint64_t>(static_cast<std::size_t>(size.y)),
            std::vector<std::uint64_t>(static_cast<std::size_t>(size.z))};
}

/// Whether values in a bin of the histogram are visible anywhere in it.
std::vector<char> visible_bins(const TransferFunction& transfer_function, const ValueStatistics& values)
{
    std::vector<double> extinction(values.histogram.size());
    double largest = 0.0;
    for (std::size_t b = 0; b < extinction.size(); ++b) {
        const double low = values.min + static_cast<double>(b) * values.bin_width;
        const double high = values.integers ? low + std::max(0.0, values.bin_width - 1.0) : low + values.bin_width;
        if (values.histogram[b] > 0)
            extinction[b] = transfer_function.max_extinction(low, high);
        largest = std::max(largest, extinction[b]);
    }
    std::vector<char> visible(extinction.size());
    for (std::size_t b = 0; b < extinction.size(); ++b)
        visible[b] = extinction[b] > 0.0 && extinction[b] >= 0.02 * largest;
    return visible;
}

template <class Voxel>
Profiles visible_profiles(const Voxel* voxels, const ScalarGrid& volume, const ValueStatistics& values,
                          const std::vector<char>& visible)
{
    const Vec3i size = volume.size();
    const double scale = volume.slope() / values.bin_width;
    const double offset = (volume.intercept() - values.min) / values.bin_width;
    const double last = static_cast<double>(visible.size()) - 1.0;
    return tbb::parallel_reduce(
        tbb::blocked_range<int>(0, size.z), empty_profiles(size),
        [&](const tbb::blocked_range<int>& slices, Profiles counts) {
            for (int k = slices.begin(); k != slices.end(); ++k)
                for (int j = 0; j < size.y; ++j) {
                    const Voxel* row = voxels + (static_cast<std::size_t>(k) * static_cast<std::size_t>(size.y) +
                                                 static_cast<std::size_t>(j)) *
                                                    static_cast<std::size_t>(size.x);
                    std::uint64_t in_row = 0;
                    for (int i = 0; i < size.x; ++i) {
                        const double bin = static_cast<double>(row[i]) * scale + offset;
                        if (!(bin > -1.0)) // NaN too
                            continue;
                        if (visible[static_cast<std::size_t>(std::clamp(bin, 0.0, last))] != 0) {
                            ++counts[0][static_cast<std::size_t>(i)];
                            ++in_row;
                        }
                    }
                    counts[1][static_cast<std::size_t>(j)] += in_row;
                    counts[2][static_cast<std::size_t>(k)] += in_row;
                }
            return counts;
        },
        [](Profiles a, const Profiles& b) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (std::size_t i = 0; i < a[axis].size(); ++i)
                    a[axis][i] += b[axis][i];
            return a;
        });
}

struct Extent {
    double low, high;
};

Extent trimmed_extent(const std::vector<std::uint64_t>& counts)
{
    std::uint64_t total = 0;
    for (const std::uint64_t count : counts)
        total += count;
    const std::uint64_t stray = total / 1000;
    std::size_t low = 0, high = counts.size();
    if (total == 0)
        return {0.0, static_cast<double>(high)};
    for (std::uint64_t below = counts[low]; below <= stray; below += counts[low])
        ++low;
    for (std::uint64_t above = counts[high - 1]; above <= stray; above += counts[high - 1])
        --high;
    return {static_cast<double>(low), static_cast<double>(high)};
}

std::array<Vec3d, 8> world_corners(const VoxelBox& box, const ScalarGrid& volume)
{
    std::array<Vec3d, 8> corners;
    for (unsigned c = 0; c < 8; ++c)
        corners[c] = volume.world_from_voxel().point({(c & 1U) != 0 ? box.high.x : box.low.x,
                                                      (c & 2U) != 0 ? box.high.y : box.low.y,
                                                      (c & 4U) != 0 ? box.high.z : box.low.z});
    return corners;
}

} // namespace

VoxelBox visible_box(const ScalarGrid& volume, const TransferFunction& transfer_function, const ValueStatistics& values)
{
    const Vec3i size = volume.size();
    if (values.count == 0)
        return {{0.0, 0.0, 0.0},
                {static_cast<double>(size.x), static_cast<double>(size.y), static_cast<double>(size.z)}};
    const std::vector<char> visible = visible_bins(transfer_function, values);
    const Profiles profiles =
        visit_voxels(volume, [&](const auto* voxels) { return visible_profiles(voxels, volume, values, visible); });
    const Extent x = trimmed_extent(profiles[0]), y = trimmed_extent(profiles[1]), z = trimmed_extent(profiles[2]);
    return {{x.low, y.low, z.low}, {x.high, y.high, z.high}};
}

Camera frame_camera(const CameraDescription& description, const ScalarGrid& volume, const VoxelBox& box,
                    const ImageSettings& image)
{
    Camera camera;
    camera.up = description.up;
    camera.vertical_fov_deg = description.vertical_fov_deg;
    camera.lens_radius = description.lens_radius;
    camera.focus_distance = description.focus_distance.value_or(0.0);
    camera.target = description.target.value_or(volume.world_from_voxel().point((box.low + box.high) * 0.5));
    if (description.position) {
        camera.position = *description.position;
        return camera;
    }

    // Towards the viewer: 25° to the patient's right (−X), 15° up.
    constexpr double turn = 25.0 * pi / 180.0, raise = 15.0 * pi / 180.0;
    Vec3d backward{-std::sin(turn) * std::cos(raise), -std::cos(turn) * std::cos(raise), std::sin(raise)};
    if (length(cross(backward, normalized(camera.up))) < 1e-3)
        backward = {0.0, -1.0, 0.0};
    const Vec3d right = normalized(cross(normalized(camera.up), backward));
    const Vec3d upward = cross(backward, right);
    const double tan_vertical = std::tan(camera.vertical_fov_deg * pi / 360.0);
    const double tan_horizontal = tan_vertical * image.width / image.height;
    constexpr double fill = 0.92; // of the image's half side, the rest is margin
    double distance = 0.0;
    for (const Vec3d& corner : world_corners(box, volume)) {
        const Vec3d offset = corner - camera.target;
        const double sideways = std::max(std::abs(dot(offset, right)) / (tan_horizontal * fill),
                                         std::abs(dot(offset, upward)) / (tan_vertical * fill));
        distance = std::max(distance, sideways + dot(offset, backward));
    }
    camera.position = camera.target + backward * distance;
    return camera;
}

} // namespace lumisweep
