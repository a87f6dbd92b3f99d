// A strategy's density of directions at any point, apart from rendering: for looking into it, and for tests.
#pragma once

#include <memory>

#include "lumisweep/light/environment.h"
#include "lumisweep/sampling/joint_grid.h"
#include "lumisweep/sampling/strategy.h"
#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep {

/// What a render with the same light, visibility and epsilon draws its directions from (sampling/direction_sampling.h,
/// in its scalar instantiation). Positions are p_voxel, directions unit vectors in world space towards the light,
/// densities per steradian.
class DirectionSampler {
public:
    /// `visibility` may be nullptr for uniform and environment. Strategy::automatic has two-step's density, and a black
    /// environment the uniform one, as in a session. Throws Error where a grid is needed and missing, has more cells
    /// than the volume has voxels along an axis, or more than can be indexed.
    DirectionSampler(Strategy strategy, std::shared_ptr<const Environment> environment,
                     const VisibilityGrid* visibility, Vec3i volume_size, double epsilon);

    /// Of the density in use: one of the papers' five.
    Strategy strategy() const { return strategy_; }
    /// Texels a side of the light, which may have been refined to that of the visibility's directions.
    int resolution() const { return environment_->resolution(); }

    double pdf_omega(const Vec3d& p_voxel, const Vec3d& w_world) const;

    struct Sample {
        Vec3d w_world;
        double pdf_omega;
    };
    /// u in [0, 1)³, rounded to floats.
    Sample sample(const Vec3d& p_voxel, const Vec3d& u) const;

private:
    Strategy strategy_;
    std::shared_ptr<const Environment> environment_;
    JointGrid joint_;
};

} // namespace lumisweep
