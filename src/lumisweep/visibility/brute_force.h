// The slow oracles for visibility: scalar, double precision, one ray at a time, never optimised.
//
// Three references, because they differ and every comparison must name its own:
//   classified  the sweep's own volume, extinction per voxel in 8 bits, interpolated after classifying; integrated
//   exactly exact       the renderer's: the volume interpolated, then classified; midpoint rule with a given step
//   averaged    "classified", averaged over a cell and a texel: what a filtered sweep aims at
#pragma once

#include <atomic>
#include <cstdint>

#include "lumisweep/visibility/extinction_grid.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

/// Transmittance from p_voxel (finest voxels) along the unit vector w_world until outside of the level's box. Between
/// planes of voxel centres the trilinear extinction along a ray is a cubic polynomial, which two-point Gauss–Legendre
/// integrates exactly.
double transmittance_classified(const ExtinctionGrid& extinction, const Vec3d& p_voxel, const Vec3d& w_world);

/// Transmittance in the renderer's sense. `step_voxels` is the length of a midpoint step, measured in voxel index
/// space.
double transmittance_exact(const ScalarGrid& volume, const TransferFunction& transfer_function, const Vec3d& p_voxel,
                           const Vec3d& w_world, double step_voxels);

/// transmittance_classified, averaged over cell (i, j, k) of `grid` and texel `direction`, by
/// strata³ positions paired at random with strata³ directions, both jittered.
double transmittance_averaged(const ExtinctionGrid& extinction, const VisibilityGrid& grid, Vec3i cell, int direction,
                              int strata, std::uint64_t seed);

/// The whole grid from transmittance_classified at cell and texel centres.
/// When *cancel becomes true it returns early, with a grid that is of no use.
VisibilityGrid brute_force_visibility(const ExtinctionGrid& extinction, int voxels_per_cell, int directions_per_side,
                                      const std::atomic<bool>* cancel = nullptr);

/// Likewise from transmittance_exact.
VisibilityGrid brute_force_visibility_exact(const ScalarGrid& volume, const TransferFunction& transfer_function,
                                            int voxels_per_cell, int directions_per_side, double step_voxels,
                                            const std::atomic<bool>* cancel = nullptr);

/// How far a grid is off at random cells, all directions of each: against `classified` and against `averaged`, both in
/// the extinction grid given, which is level 0 where the finest volume is meant.
struct SweepCheck {
    int positions = 0;
    double rms = 0.0, max = 0.0;
    double rms_averaged = 0.0, max_averaged = 0.0;
};

/// The same positions for the same seed, whatever the number of threads. Throws Error unless `grid` fits the volume.
SweepCheck sweep_check(const VisibilityGrid& grid, const ExtinctionGrid& extinction, int positions, std::uint64_t seed);

} // namespace lumisweep
