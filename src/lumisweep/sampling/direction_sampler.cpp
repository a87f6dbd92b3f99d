#include "lumisweep/sampling/direction_sampler.h"

#include <algorithm>

#include "lumisweep/base/error.h"
#include "lumisweep/math/trigonometry.h"
#include "lumisweep/sampling/direction_sampling.h"

namespace lumisweep {

namespace {

constexpr double sphere = 4.0 * pi;

Strategy density_of(Strategy strategy, const Environment& environment)
{
    if (!(environment.mean_luminance() > 0.0))
        return Strategy::uniform;
    return strategy == Strategy::automatic ? Strategy::two_step : strategy;
}

/// The last float below 1 stands for what rounds up to it.
float below_one(double u) { return std::min(static_cast<float>(u), 0x1.fffffep-1F); }

} // namespace

DirectionSampler::DirectionSampler(Strategy strategy, std::shared_ptr<const Environment> environment,
                                   const VisibilityGrid* visibility, Vec3i volume_size, double epsilon)
    : strategy_(density_of(strategy, *environment)), environment_(std::move(environment))
{
    if (strategy_ == Strategy::uniform || strategy_ == Strategy::environment)
        return;
    require(visibility != nullptr, "sampler: strategy {} needs a visibility grid (sweep one)", name_of(strategy));
    const Vec3i cells = visibility->cells();
    require(cells.x <= volume_size.x && cells.y <= volume_size.y && cells.z <= volume_size.z,
            "sampler: the visibility grid has {} x {} x {} cells, more than the volume has voxels", cells.x, cells.y,
            cells.z);
    require(epsilon > 0.0 && epsilon <= 1.0, "sampler: epsilon {} is not above 0 and at most 1", epsilon);
    if (environment_->resolution() < visibility->directions_per_side())
        environment_ = std::make_shared<const Environment>(environment_->refined(visibility->directions_per_side()));
    joint_.build(*visibility, volume_size, *environment_,
                 strategy_ == Strategy::visibility ? JointFactor::visibility_only : JointFactor::visibility_times_light,
                 epsilon);
}

double DirectionSampler::pdf_omega(const Vec3d& p_voxel, const Vec3d& w_world) const
{
    const DirectionSamplingView view{strategy_, environment_->view(), joint_.view()};
    return static_cast<double>(
               direction_pdf_uv<float>(view, to_float(p_voxel), oct_from_direction(to_float(w_world)))) /
           sphere;
}

DirectionSampler::Sample DirectionSampler::sample(const Vec3d& p_voxel, const Vec3d& u) const
{
    const DirectionSamplingView view{strategy_, environment_->view(), joint_.view()};
    const DirectionSample<float> drawn =
        sample_direction<float>(view, to_float(p_voxel), {below_one(u.x), below_one(u.y), below_one(u.z)});
    const Vec3<float> w = direction_from_oct(drawn.uv_oct);
    return {{w.x, w.y, w.z}, static_cast<double>(drawn.pdf_uv) / sphere};
}

} // namespace lumisweep
