#include "lumisweep/visibility/classify_setup.h"

#include <algorithm>
#include <limits>

#include "lumisweep/base/error.h"

namespace lumisweep {

Vec3i level_size(const Vec3i& volume_size, int mip_level)
{
    require(mip_level >= 0 && mip_level <= 13, "classify: mip level {} (use 0 to 13)", mip_level);
    const auto level_side = [&](int side) { return (side + (1 << mip_level) - 1) >> mip_level; };
    return {level_side(volume_size.x), level_side(volume_size.y), level_side(volume_size.z)};
}

double extinction_of_step(const ScalarGrid& volume, const RawRange& range, const TransferFunction& tf)
{
    if (range.empty())
        return 0.0;
    const double a = volume.slope() * range.low + volume.intercept();
    const double b = volume.slope() * range.high + volume.intercept();
    return tf.max_extinction(std::min(a, b), std::max(a, b)) / 255.0;
}

FloatClassification classification_of_floats(const ScalarGrid& volume, const TransferFunction& tf, double scale)
{
    constexpr float infinity = std::numeric_limits<float>::infinity();
    FloatClassification job;
    job.tf = tf.view(volume.slope(), volume.intercept());
    job.steps_of_one = static_cast<float>(std::min(fixed_one / scale, double{std::numeric_limits<float>::max()}));
    const float *knot = job.tf.table, *extinction = knot + job.tf.stride, *slope = extinction + job.tf.stride;
    const int segments = job.tf.stride - 1;
    job.empty_first = job.empty_end = infinity;
    float begin = -infinity;
    for (int s = 0; s < segments; ++s) {
        const float end = knot[s + 1];
        if (extinction[s] != 0.0F || slope[s] != 0.0F)
            begin = end;
        else if (end - begin > job.empty_end - job.empty_first || job.empty_first == infinity) {
            job.empty_first = begin;
            job.empty_end = end;
        }
    }
    return job;
}

} // namespace lumisweep
