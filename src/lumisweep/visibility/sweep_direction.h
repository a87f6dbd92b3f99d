// One direction's sweep: march, look up, filter, slice by slice.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "lumisweep/visibility/sweep.h"
#include "lumisweep/visibility/sweep_filter.h"
#include "lumisweep/visibility/sweep_geometry.h"
#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {

/// The marched level, and its copy with y fastest, then z, for sweeps along x (empty when no direction needs it).
struct MarchedVolume {
    Vec3i size;
    const std::uint8_t* voxels;
    const std::uint8_t* transposed;
    Affine3d level_from_world;
    double voxels_per_level_voxel; ///< finest voxels along a side
    double extinction_of_one;      ///< 1/world unit per stored step
    Vec3d voxel_sides_world;       ///< of the level's voxels
};

/// Working memory of one thread, kept from direction to direction.
class DirectionSweep {
public:
    DirectionSweep(const MarchedVolume& volume, Vec3i volume_size, Vec3i cells, const std::atomic<bool>* cancel);

    /// Sweeps towards `w_world` and writes the whole direction; false, and nothing written, when cancelled.
    bool run(const Vec3d& w_world, double tan_beta, SweepFilter filter, std::uint8_t* visibility);

    const SweepStats& stats() const { return stats_; }

private:
    /// Where the cells of a line of the slice look up, at one depth.
    struct CellLine {
        std::vector<std::int32_t> ray;
        std::vector<float> fraction, enter, leave;
        void place(const SweepAxis& axis, double depth, double voxels_per_cell);
    };

    void start();
    bool march(double begin_depth, double end_depth);
    void march_row(const SweepStep& step, int ray_row);
    /// Rays that come in or go out through a side within this step.
    void march_partial(const SweepStep& step, int ray_row, int first, int last);
    bool look_up(double depth);
    void store(int slice);
    void finish(std::uint8_t* visibility);
    bool cancelled() const { return cancel_ != nullptr && cancel_->load(std::memory_order_relaxed); }

    const MarchedVolume& volume_;
    const SweepKernels& kernels_;
    Vec3i volume_size_, cells_;
    const std::atomic<bool>* cancel_;
    SweepStats stats_;

    // Of the direction under way.
    const SweepGeometry* geometry_ = nullptr;
    int cells_u_ = 0, cells_v_ = 0, cells_w_ = 0;
    double cell_u_ = 0.0, cell_v_ = 0.0, cell_w_ = 0.0; // level voxels
    std::vector<std::int32_t> tau_;                     // [v ray][u ray]
    std::vector<std::uint16_t> mixed_;                  // one row of voxels and an edge voxel on each side
    std::vector<float> enter_u_, leave_u_, enter_v_, leave_v_, mixed_tau_, mixed_length_, scratch_;
    CellLine line_u_, line_v_;
    std::vector<std::int32_t> slice_;
    std::vector<std::uint8_t> stored_;
};

} // namespace lumisweep
