// The lines of a sweep, in the device's memory.
#pragma once

#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/backends/cuda/sweep_line.h"
#include "lumisweep/visibility/settings.h"
#include "lumisweep/visibility/sweep_level.h"

namespace lumisweep::LUMISWEEP_CUDA {

/// All directions' lines; lines that are averaged lie together.
class DeviceSweepPlan {
public:
    DeviceSweepPlan(const SweepLevel& level, const VisibilitySettings& settings, const Stream& stream);

    LinesView view() const { return {lines_.data(), pieces_.data(), slab_begin_.data(), begin_.data(), end_.data()}; }
    int line_count() const { return static_cast<int>(lines_.size()); }
    int most_tiles_u() const { return most_tiles_u_; }
    int most_tiles_v() const { return most_tiles_v_; }
    std::size_t most_rays() const { return most_rays_; } ///< of any line
    bool along_x() const { return along_x_; }            ///< whether any line is
    std::uint64_t voxel_steps() const { return voxel_steps_; }

private:
    DeviceArray<LineView> lines_;
    DeviceArray<MarchPiece> pieces_;
    DeviceArray<std::int32_t> slab_begin_, begin_, end_;
    int most_tiles_u_ = 0, most_tiles_v_ = 0;
    std::size_t most_rays_ = 0;
    bool along_x_ = false;
    std::uint64_t voxel_steps_ = 0;
};

} // namespace lumisweep::LUMISWEEP_CUDA
