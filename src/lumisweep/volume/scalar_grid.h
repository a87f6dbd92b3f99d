// The volume: a regular grid of scalar voxels in their own type, placed in the world.
//
// Spaces. p_voxel: voxel (i, j, k) covers [i, i+1) × [j, j+1) × [k, k+1) and its sample sits at the centre, so the
// volume's box is [0, size]. p_world: the file's physical space (ITK's: LPS millimetres). Linear storage, x fastest.
// Values. value = slope · raw + intercept, in the data's own units. Trilinear interpolation between centres, clamped to
// the edge voxel outside of them. Non-finite voxels (float only) are NaN here, and empty wherever interpolation touches
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "lumisweep/base/aligned.h"
#include "lumisweep/base/error.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/volume/voxel_type.h"

namespace lumisweep {

class ScalarGrid {
public:
    ScalarGrid() = default;

    /// Takes zeroed storage for size.x · size.y · size.z voxels. Throws Error when a side is < 1, when there are more
    /// than 2^31 − 1 voxels or more than 8192 along x or y or 4096 along z, or when world_from_voxel is singular or not
    /// finite.
    ScalarGrid(VoxelType type, Vec3i size, const Affine3d& world_from_voxel, double slope = 1.0,
               double intercept = 0.0);
    /// Voxels that stand elsewhere, which `voxels` keeps alive; they are never written to. Kernels load whole vectors:
    /// `readable_behind` bytes behind the last voxel must be readable, whatever they hold. Of floats none may be
    /// infinite. Throws Error likewise.
    ScalarGrid(VoxelType type, Vec3i size, const Affine3d& world_from_voxel, std::shared_ptr<const std::byte> voxels,
               double slope = 1.0, double intercept = 0.0);
    static constexpr std::size_t readable_behind = AlignedArray<std::byte>::alignment;

    VoxelType type() const { return type_; }
    const Vec3i& size() const { return size_; }
    std::size_t voxel_count() const;
    std::size_t bytes() const { return voxel_count() * size_of(type_); }
    bool owns_voxels() const { return borrowed_ == nullptr; }
    const Affine3d& world_from_voxel() const { return world_from_voxel_; }
    const Affine3d& voxel_from_world() const { return voxel_from_world_; }
    double slope() const { return slope_; }
    double intercept() const { return intercept_; }

    /// For writing: of voxels that the grid owns.
    std::byte* data()
    {
        LUMISWEEP_EXPECT(owns_voxels());
        return storage_.data();
    }
    const std::byte* data() const { return borrowed_ ? borrowed_.get() : storage_.data(); }
    template <class T>
    T* voxels()
    {
        return reinterpret_cast<T*>(data());
    }
    template <class T>
    const T* voxels() const
    {
        return reinterpret_cast<const T*>(data());
    }

    /// Turns ±infinity into NaN and returns how many voxels are not finite; 0 for integer types.
    std::size_t mark_non_finite();

    /// Value of one voxel in data units. For readers, tests and oracles, not for inner loops.
    double value(int i, int j, int k) const;
    /// Trilinear value at p_voxel in data units; NaN where a non-finite voxel takes part. Double precision: the oracle.
    double interpolate(const Vec3d& p_voxel) const;

private:
    VoxelType type_ = VoxelType::u8;
    Vec3i size_{0, 0, 0};
    Affine3d world_from_voxel_, voxel_from_world_;
    double slope_ = 1.0, intercept_ = 0.0;
    AlignedArray<std::byte> storage_;
    std::shared_ptr<const std::byte> borrowed_; ///< null when storage_ holds the voxels
};

/// Calls f with a typed pointer to the grid's voxels: f(const std::uint8_t*), f(const float*), …
template <class Function>
decltype(auto) visit_voxels(const ScalarGrid& grid, Function&& f)
{
    switch (grid.type()) {
    case VoxelType::u8: return f(grid.voxels<std::uint8_t>());
    case VoxelType::u16: return f(grid.voxels<std::uint16_t>());
    case VoxelType::i16: return f(grid.voxels<std::int16_t>());
    default: return f(grid.voxels<float>());
    }
}

} // namespace lumisweep
