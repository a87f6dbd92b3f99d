#include "lumisweep/volume/scalar_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/error.h"

namespace lumisweep {

namespace {

constexpr int max_side[3] = {8192, 8192, 4096};
constexpr std::uint64_t max_voxels = 0x7fffffff; // voxel indices are int in gathers

/// Checks before any storage is taken.
std::size_t checked_bytes(VoxelType type, const Vec3i& size)
{
    for (int axis = 0; axis < 3; ++axis)
        require(component(size, axis) >= 1 && component(size, axis) <= max_side[axis],
                "volume: {} x {} x {} voxels, but side {} must be 1 to {} (crop or downsample the volume)", size.x,
                size.y, size.z, "xyz"[axis], max_side[axis]);
    const std::uint64_t count = std::uint64_t(size.x) * std::uint64_t(size.y) * std::uint64_t(size.z);
    require(count <= max_voxels, "volume: {} x {} x {} voxels are more than 2^31 - 1 (crop or downsample the volume)",
            size.x, size.y, size.z);
    return count * size_of(type);
}

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

const Affine3d& checked_affine(const Affine3d& a)
{
    require(finite(a.column[0]) && finite(a.column[1]) && finite(a.column[2]) && finite(a.offset),
            "volume: world_from_voxel is not finite (give finite spacing, direction and origin)");
    for (const Vec3d& column : a.column)
        require(length(column) >= 1e-12 && length(column) <= 1e12,
                "volume: spacing {:g} is not between 1e-12 and 1e12 (give it in another unit)", length(column));
    // Relative to the edges' lengths: a micrometre grid is as good as a metre grid.
    const double scale = length(a.column[0]) * length(a.column[1]) * length(a.column[2]);
    require(scale > 0.0 && std::isfinite(scale) && std::abs(determinant(a)) > 1e-9 * scale,
            "volume: world_from_voxel is singular (give non-zero spacing and independent directions)");
    const Affine3d inverted = inverse(a);
    require(finite(inverted.column[0]) && finite(inverted.column[1]) && finite(inverted.column[2]) &&
                finite(inverted.offset),
            "volume: world_from_voxel has no finite inverse (give spacing of an ordinary magnitude)");
    return a;
}

void check_scaling(double slope, double intercept)
{
    require(std::isfinite(slope) && slope != 0.0 && std::isfinite(intercept),
            "volume: slope {} and intercept {} must be finite and the slope not 0", slope, intercept);
}

template <class T>
double read(const std::byte* data, std::size_t index)
{
    return static_cast<double>(reinterpret_cast<const T*>(data)[index]);
}

} // namespace

std::size_t size_of(VoxelType type)
{
    switch (type) {
    case VoxelType::u8: return 1;
    case VoxelType::u16:
    case VoxelType::i16: return 2;
    default: return 4;
    }
}

const char* name_of(VoxelType type)
{
    switch (type) {
    case VoxelType::u8: return "uint8";
    case VoxelType::u16: return "uint16";
    case VoxelType::i16: return "int16";
    default: return "float";
    }
}

ScalarGrid::ScalarGrid(VoxelType type, Vec3i size, const Affine3d& world_from_voxel, double slope, double intercept)
    : type_(type), size_(size), world_from_voxel_(checked_affine(world_from_voxel)),
      voxel_from_world_(inverse(world_from_voxel)), slope_(slope), intercept_(intercept)
{
    check_scaling(slope, intercept);
    storage_ = AlignedArray<std::byte>(checked_bytes(type, size));
}

ScalarGrid::ScalarGrid(VoxelType type, Vec3i size, const Affine3d& world_from_voxel,
                       std::shared_ptr<const std::byte> voxels, double slope, double intercept)
    : type_(type), size_(size), world_from_voxel_(checked_affine(world_from_voxel)),
      voxel_from_world_(inverse(world_from_voxel)), slope_(slope), intercept_(intercept), borrowed_(std::move(voxels))
{
    check_scaling(slope, intercept);
    checked_bytes(type, size);
    require(borrowed_ != nullptr, "volume: there are no voxels");
}

std::size_t ScalarGrid::voxel_count() const
{
    return std::size_t(size_.x) * std::size_t(size_.y) * std::size_t(size_.z);
}

std::size_t ScalarGrid::mark_non_finite()
{
    if (type_ != VoxelType::f32)
        return 0;
    std::size_t count = 0;
    float* voxel = voxels<float>();
    for (std::size_t i = 0; i < voxel_count(); ++i)
        if (!std::isfinite(voxel[i])) {
            voxel[i] = std::numeric_limits<float>::quiet_NaN();
            ++count;
        }
    return count;
}

double ScalarGrid::value(int i, int j, int k) const
{
    LUMISWEEP_EXPECT(i >= 0 && i < size_.x && j >= 0 && j < size_.y && k >= 0 && k < size_.z);
    const std::size_t index =
        std::size_t(i) + std::size_t(size_.x) * (std::size_t(j) + std::size_t(size_.y) * std::size_t(k));
    double raw = 0.0;
    switch (type_) {
    case VoxelType::u8: raw = read<std::uint8_t>(data(), index); break;
    case VoxelType::u16: raw = read<std::uint16_t>(data(), index); break;
    case VoxelType::i16: raw = read<std::int16_t>(data(), index); break;
    case VoxelType::f32: raw = read<float>(data(), index); break;
    }
    return slope_ * raw + intercept_;
}

double ScalarGrid::interpolate(const Vec3d& p_voxel) const
{
    if (std::isnan(p_voxel.x) || std::isnan(p_voxel.y) || std::isnan(p_voxel.z))
        return std::numeric_limits<double>::quiet_NaN();
    int low[3], high[3];
    double weight[3];
    for (int axis = 0; axis < 3; ++axis) {
        const int last = component(size_, axis) - 1;
        const double x = std::clamp(component(p_voxel, axis) - 0.5, 0.0, double(last));
        low[axis] = std::min(static_cast<int>(x), std::max(last - 1, 0));
        high[axis] = std::min(low[axis] + 1, last);
        weight[axis] = x - low[axis];
    }
    // The cell and its eight corners are the kernels', also where a weight is zero, so that NaN spreads alike.
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const bool x = (corner & 1) != 0, y = (corner & 2) != 0, z = (corner & 4) != 0;
        const double w =
            (x ? weight[0] : 1.0 - weight[0]) * (y ? weight[1] : 1.0 - weight[1]) * (z ? weight[2] : 1.0 - weight[2]);
        sum += w * value(x ? high[0] : low[0], y ? high[1] : low[1], z ? high[2] : low[2]);
    }
    return sum;
}

} // namespace lumisweep
