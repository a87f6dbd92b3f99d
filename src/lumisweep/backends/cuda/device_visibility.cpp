#include "lumisweep/backends/cuda/device_visibility.h"

#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceVisibility::resize(Vec3i cells_of_grid, int directions_a_side)
{
    cells = cells_of_grid;
    cell_count =
        static_cast<std::size_t>(cells.x) * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z);
    directions_per_side = directions_a_side;
    stride = (cell_count + 63) / 64 * 64;
    stored.resize(stride * static_cast<std::size_t>(direction_count()), "the visibility grid");
}

void DeviceVisibility::upload(const VisibilityGrid& grid, const Stream& stream)
{
    resize(grid.cells(), grid.directions_per_side());
    for (int d = 0; d < direction_count(); ++d)
        copy_to_device(direction(d), grid.direction(d), cell_count, stream);
    stream.wait();
}

void DeviceVisibility::download(VisibilityGrid& grid, const Stream& stream) const
{
    for (int d = 0; d < direction_count(); ++d)
        copy_to_host(grid.direction(d), direction(d), cell_count, stream);
    stream.wait();
}

} // namespace lumisweep::LUMISWEEP_CUDA
