// The journal paper's Table 2: volumes of its sizes, by rays per direction, filtered and not.
#pragma once

#include "subject.h"

namespace lumisweep::bench {

/// Rays lie one voxel of a mip level apart, so more of them than the longest side has voxels are had by doubling the
/// voxels.
struct Resolution {
    int doublings, rays; ///< rays along the longest side
    bool operator==(const Resolution&) const = default;
};
/// The one whose rays come nearest to those wanted, by ratio.
Resolution nearest_resolution(Vec3i size, int wanted);

/// Registers "table2/VOLUME/rays:S/filter:F" for the paper's six volumes and three ray counts; `quick` takes an eighth
/// of both. `subjects` must live until the benchmarks have run.
void register_table_2(Subjects& subjects, bool quick);

} // namespace lumisweep::bench
