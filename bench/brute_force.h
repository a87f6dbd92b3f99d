// Our own optimised brute force: what a visibility grid costs without sweeps. A ray is marched from every cell for
// every direction, through the 8-bit extinction that sweeps march, trilinear, one sample a voxel, until 1/512 of the
// light is left: persistent lanes with gathers, refilled when half of them are done. The slow oracle that it is held
// against is lumisweep/visibility/brute_force.h.
#pragma once

#include <cstdint>
#include <span>

#include "brute_force_march.h"
#include "lumisweep/visibility/extinction_grid.h"

namespace lumisweep::bench {

struct BruteForceKernel {
    const char* name;
    std::uint64_t (*march)(const GridView<std::uint8_t>& grid, const RayArrays& rays); ///< returns the samples taken
};
/// Those that this machine runs, widest first; the last is the scalar one.
std::span<const BruteForceKernel> brute_force_kernels();

struct VisibilityQuery {
    Vec3d p_voxel, w_world; ///< a point in finest voxels, a unit vector
};

/// Transmittance along rays through a classified volume at full resolution, which must outlive this.
class BruteForce {
public:
    BruteForce(const ExtinctionGrid& extinction, const BruteForceKernel& kernel, double samples_per_voxel = 1.0);

    /// V of each query on this thread; returns the number of samples taken.
    std::uint64_t visibility(std::span<const VisibilityQuery> queries, std::span<float> v) const;

private:
    const BruteForceKernel& kernel_;
    GridView<std::uint8_t> grid_;
    Affine3d voxel_from_world_;
    double scale_, samples_per_voxel_;
};

} // namespace lumisweep::bench
