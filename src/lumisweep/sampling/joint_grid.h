// The joint grid: visibility × light per cell, with its averages: what joint-hierarchical sampling descends (journal
// paper, section 7).
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/light/environment.h"
#include "lumisweep/math/vec.h"
#include "lumisweep/sampling/joint_kernel.h"
#include "lumisweep/sampling/joint_view.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

/// What the product is taken with.
enum class JointFactor { visibility_only, visibility_times_light };

/// What each direction's visibility is multiplied with: 1, or its light L̄ / mean L̄. `directions` is a power of 4, of at
/// most as many as the environment has texels.
std::vector<float> light_factors(const Environment& environment, JointFactor factor, std::size_t directions);

/// The view of a grid of that shape, without its memory. `volume_size` in voxels.
JointView joint_shape(Vec3i cells, Vec3i volume_size, int directions_per_side);

class JointGrid {
public:
    JointGrid() = default;
    JointGrid(const VisibilityGrid& visibility, Vec3i volume_size, const Environment& environment, JointFactor factor,
              double epsilon)
    {
        build(visibility, volume_size, environment, factor, epsilon);
    }

    /// Replaces the whole product, in place when the shape is the same. `volume_size` in voxels. The environment must
    /// have at least as many texels a side as the grid has directions, and a mean luminance > 0 unless the factor is
    /// visibility_only. epsilon > 0 keeps every direction possible. Throws Error for more entries than kernels can
    /// index; after std::bad_alloc the grid is empty. False, with some cells old and some new, when *cancel became
    /// true.
    ///
    /// There is no update of single directions: the nodes of a cell are a few cache lines, which a changed direction
    /// has read and written back, while building everything only stores, past the caches. For 128 × 128 × 115 cells,
    /// one direction of 64 took 49 ms, four 75 ms, all of them 41 ms.
    bool build(const VisibilityGrid& visibility, Vec3i volume_size, const Environment& environment, JointFactor factor,
               double epsilon, const std::atomic<bool>* cancel = nullptr,
               const JointKernel& kernel = *joint_kernels()[0]);

    static std::size_t bytes_needed(std::size_t cell_count, int directions_per_side);
    /// Throws Error for a grid with more entries than kernels can index with 32 bits; build() does.
    static void require_indexable(std::size_t cell_count, int directions_per_side);
    JointView view() const;
    std::size_t bytes() const { return root_.bytes() + nodes_.bytes(); }

private:
    JointView shape_; ///< without memory
    AlignedArray<float> root_, nodes_;
};

} // namespace lumisweep
