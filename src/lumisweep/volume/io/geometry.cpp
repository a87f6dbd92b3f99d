#include "lumisweep/volume/io/geometry.h"

#include <algorithm>
#include <cmath>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

constexpr const char* mend = "mend the header's spacing and orientation";

} // namespace

Affine3d place_grid(const std::array<Vec3d, 3>& step, const Vec3d& origin, const std::string& where)
{
    require(finite(origin), "{}: the origin is not finite ({})", where, mend);
    double scale = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double spacing = length(step[axis]);
        require(finite(step[axis]) && std::isfinite(spacing), "{}: spacing or direction of axis {} is not finite ({})",
                where, "xyz"[axis], mend);
        // Beyond this range float world coordinates stop making sense.
        require(spacing > 1e-12 && spacing < 1e12, "{}: spacing {} along axis {} ({})", where, spacing, "xyz"[axis],
                mend);
        scale *= spacing;
    }
    Affine3d a;
    a.column = step;
    require(std::abs(determinant(a)) > 1e-6 * scale, "{}: the axes' directions lie in one plane ({})", where, mend);
    a.offset = origin - (step[0] + step[1] + step[2]) * 0.5;
    return a;
}

Vec3i checked_size(const std::array<std::uint64_t, 3>& size, const std::string& where)
{
    constexpr std::uint64_t max_side = 8192, max_voxels = 0x7fffffff;
    require(
        std::all_of(size.begin(), size.end(), [](std::uint64_t n) { return n >= 1 && n <= max_side; }) &&
            size[0] * size[1] * size[2] <= max_voxels,
        "{}: {} x {} x {} voxels; each side must be 1 to {} and the product below 2^31 (crop or downsample the volume)",
        where, size[0], size[1], size[2], max_side);
    return {int(size[0]), int(size[1]), int(size[2])};
}

int checked_frames(std::uint64_t frames, const std::string& where)
{
    constexpr std::uint64_t max_frames = 1U << 20; // keeps sizes in bytes far from overflow
    require(frames >= 1 && frames <= max_frames, "{}: {} frames; there must be 1 to {} (mend the header)", where,
            frames, max_frames);
    return static_cast<int>(frames);
}

void set_spacing(VolumeHeader& header)
{
    const auto& column = header.world_from_voxel.column;
    header.spacing = {length(column[0]), length(column[1]), length(column[2])};
}

} // namespace lumisweep
