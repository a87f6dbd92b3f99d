#include "lumisweep/backends/cuda/device_visibility.h"

#include "lumisweep/visibility/visibility_grid.h"

namespace lumisweep::LUMISWEEP_CUDA {

void DeviceVisibility::resize(Vec3i cells_of_grid, int directions_a_side)
{
    const std::size_t count = static_cast<std::size_t>(cells_of_grid.x) * static_cast<std::size_t>(cells_of_grid.y) *
                              static_cast<std::size_t>(cells_of_grid.z);
    const auto directions = static_cast<std::size_t>(directions_a_side) * static_cast<std::size_t>(directions_a_side);
    cell_count = 0; // unless there is memory
    stored.resize((count + 63) / 64 * 64 * directions, "the visibility grid");
    cells = cells_of_grid;
    cell_count = count;
    directions_per_side = directions_a_side;
    stride = (count + 63) / 64 * 64;
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
