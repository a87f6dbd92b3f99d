#include "lumisweep/visibility/settings.h"

#include <bit>
#include <cmath>

#include "lumisweep/base/error.h"

namespace lumisweep {

void VisibilitySettings::validate() const
{
    require(directions >= 1 && directions <= 32 && std::has_single_bit(static_cast<unsigned>(directions)),
            "visibility.directions: {} is not one of 1, 2, 4, 8, 16 and 32", directions);
    require(cell >= 1 && cell <= 64, "visibility.cell: {} is not in 1 to 64 voxels", cell);
    require(rays >= 0 && rays <= 8192, "visibility.rays: {} is not in 1 to 8192 (or \"auto\")", rays);
    require(filter == SweepFilter::none || filter == SweepFilter::half_angle || filter == SweepFilter::full_angle,
            "visibility.filter: not one of \"none\", \"half-angle\" and \"full-angle\"");
    require(std::isfinite(epsilon) && epsilon > 0.0 && epsilon <= 1.0,
            "visibility.epsilon: {} is not in (0, 1] (zero could bias the image where V is wrongly 0)", epsilon);
}

} // namespace lumisweep
