#include <algorithm>
#include <utility>
#include <vector>

#include "lumisweep/volume/majorant_grid.h"
#include "transmittance.h"

namespace lumisweep::bench {
namespace {

/// Over values in [low, high]; of a step both sides count.
double min_extinction(const TransferFunction& transfer_function, double low, double high)
{
    double result = std::min(transfer_function.evaluate(low).extinction, transfer_function.evaluate(high).extinction);
    for (const TransferPoint& p : transfer_function.points())
        if (p.value >= low && p.value <= high)
            result = std::min(result, p.extinction * transfer_function.extinction_scale());
    return result;
}

/// Optical depth across a cell, of its largest less its smallest extinction, below which it counts as thin.
constexpr double thin_cell = 0.5;

} // namespace

std::span<const TransmittanceKernels> transmittance_kernels()
{
    static const std::vector<TransmittanceKernels> kernels = [] {
        std::vector<TransmittanceKernels> found;
#if defined(__x86_64__)
        const bool avx2 =
            __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
        if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
            __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
            found.push_back(transmittance_avx512);
        if (avx2)
            found.push_back(transmittance_avx2);
#endif
        found.push_back(transmittance_baseline);
        return found;
    }();
    return kernels;
}

CellBounds::CellBounds(const ScalarGrid& volume, const TransferFunction& transfer_function)
{
    const BoundsGrid bounds(volume);
    cells_ = bounds.cells();
    majorant_ = AlignedArray<float>(bounds.size());
    for (auto& residual : residual_)
        residual = AlignedArray<float>(2 * bounds.size());
    // Of a cell along its diagonal, in world units.
    const Affine3d& world_from_voxel = volume.world_from_voxel();
    const double diagonal = length(world_from_voxel.vector(Vec3d{1.0, 1.0, 1.0} * double{majorant_cell}));
    constexpr double slack = 1e-5; // lookups in single precision round
    for (std::size_t cell = 0; cell < bounds.size(); ++cell) {
        const double low = bounds.low(cell), high = bounds.high(cell);
        const double largest = transfer_function.max_extinction(low, high) * (1.0 + slack);
        const double smallest = min_extinction(transfer_function, low, high) * (1.0 - slack);
        majorant_[cell] = static_cast<float>(largest);
        const double middle = (largest - smallest) * diagonal < thin_cell ? 0.5 * (largest + smallest) : smallest;
        for (const auto& [control, residual] : {std::pair{smallest, &residual_[0]}, std::pair{middle, &residual_[1]}}) {
            (*residual)[2 * cell] = static_cast<float>(largest - control);
            (*residual)[2 * cell + 1] = static_cast<float>(control);
        }
    }
}

ShadowRays::ShadowRays(std::size_t capacity)
{
    for (auto& array : floats_)
        array = AlignedArray<float>(capacity + 16);
    for (auto& array : ints_)
        array = AlignedArray<std::int32_t>(capacity + 16);
    for (int axis = 0; axis < 3; ++axis) {
        sink_.origin[axis] = floats_[axis].data();
        sink_.direction[axis] = floats_[3 + axis].data();
    }
    sink_.weight = floats_[6].data();
    sink_.key[0] = ints_[0].data();
    sink_.key[1] = ints_[1].data();
    sink_.pixel = ints_[2].data();
    sink_.collision = ints_[3].data();
}

ShadowRaysView ShadowRays::view() const
{
    ShadowRaysView view;
    for (int axis = 0; axis < 3; ++axis) {
        view.origin[axis] = sink_.origin[axis];
        view.direction[axis] = sink_.direction[axis];
    }
    view.key[0] = sink_.key[0];
    view.key[1] = sink_.key[1];
    view.count = sink_.count;
    return view;
}

} // namespace lumisweep::bench
