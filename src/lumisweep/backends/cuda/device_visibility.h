// The visibility grid (visibility/visibility_grid.h) in the device's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {
class VisibilityGrid;
}

namespace lumisweep::LUMISWEEP_CUDA {

/// Memory: stored [direction][stride] bytes, cells x fastest; V = stored / 255. Directions in Morton order.
struct DeviceVisibility {
    Vec3i cells{0, 0, 0};
    std::size_t cell_count = 0;
    int directions_per_side = 0;
    std::size_t stride = 0; ///< bytes from one direction to the next, a multiple of 64
    DeviceArray<std::uint8_t> stored;

    int direction_count() const { return directions_per_side * directions_per_side; }
    std::uint8_t* direction(int d) { return stored.data() + static_cast<std::size_t>(d) * stride; }
    const std::uint8_t* direction(int d) const { return stored.data() + static_cast<std::size_t>(d) * stride; }

    /// Memory for a grid of that shape; what is in it does not matter.
    void resize(Vec3i cells_of_grid, int directions_a_side);
    void upload(const VisibilityGrid& grid, const Stream& stream);
    /// Into a grid of the same shape; waits.
    void download(VisibilityGrid& grid, const Stream& stream) const;
};

} // namespace lumisweep::LUMISWEEP_CUDA
