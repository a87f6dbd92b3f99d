#include "lumisweep/visibility/settings.h"

#include <bit>

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
    require(oversampling == 1 || oversampling == 4 || oversampling == 16,
            "visibility.oversampling: {} is not one of 1, 4 and 16", oversampling);
    // Below a millionth single precision and 24-bit random numbers would make it zero.
    require(epsilon >= 1e-6 && epsilon <= 1.0,
            "visibility.epsilon: {} is not in 0.000001 to 1 (without it the image would be wrong where V is wrongly 0)",
            epsilon);
}

} // namespace lumisweep
