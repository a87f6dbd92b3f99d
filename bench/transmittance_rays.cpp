#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lumisweep/base/parallel.h"
#include "transmittance.h"

namespace lumisweep::bench {
namespace {

/// Optical depth across a cell, of its largest less its smallest extinction, below which it counts as thin.
constexpr double thin_cell = 0.1;

struct Range {
    double low, high;
};

/// The values (data units) that interpolation takes within a cell.
Range values_of_cell(const ScalarGrid& volume, const Vec3i& cells, std::size_t cell)
{
    const Vec3i size = volume.size();
    const auto nx = static_cast<std::size_t>(cells.x), ny = static_cast<std::size_t>(cells.y);
    // Cell c spans c · bounds_cell − ½ to (c + 1) · bounds_cell − ½.
    const auto voxels = [](std::size_t c, int n) {
        const int first = static_cast<int>(c) * bounds_cell - 1;
        return std::pair{std::clamp(first, 0, n - 1), std::clamp(first + bounds_cell, 0, n - 1)};
    };
    const auto [x0, x1] = voxels(cell % nx, size.x);
    const auto [y0, y1] = voxels(cell / nx % ny, size.y);
    const auto [z0, z1] = voxels(cell / nx / ny, size.z);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    visit_voxels(volume, [&, x0 = x0, x1 = x1, y0 = y0, y1 = y1, z0 = z0, z1 = z1](const auto* data) {
        for (int z = z0; z <= z1; ++z)
            for (int y = y0; y <= y1; ++y) {
                const auto* row = data + (static_cast<std::ptrdiff_t>(z) * size.y + y) * size.x;
                for (int x = x0; x <= x1; ++x) {
                    low = std::min(low, static_cast<double>(row[x]));
                    high = std::max(high, static_cast<double>(row[x]));
                }
            }
    });
    const double a = volume.slope() * low + volume.intercept(), b = volume.slope() * high + volume.intercept();
    const double slack = 1e-6 * (std::fabs(a) + std::fabs(b) + std::fabs(volume.intercept()));
    return {std::min(a, b) - slack, std::max(a, b) + slack};
}

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
    const Vec3i size = volume.size();
    const auto cells = [](int n) { return n / bounds_cell + 1; };
    cells_ = {cells(size.x), cells(size.y), cells(size.z)};
    const std::size_t count =
        static_cast<std::size_t>(cells_.x) * static_cast<std::size_t>(cells_.y) * static_cast<std::size_t>(cells_.z);
    majorant_ = AlignedArray<float>(count);
    for (auto& residual : residual_)
        residual = AlignedArray<float>(2 * count);
    // Of a cell along its diagonal, in world units.
    const Affine3d& world_from_voxel = volume.world_from_voxel();
    const double diagonal = length(world_from_voxel.vector(Vec3d{1.0, 1.0, 1.0} * double{bounds_cell}));
    parallel_for(std::size_t{0}, count, [&](std::size_t cell) {
        const Range data = values_of_cell(volume, cells_, cell);
        constexpr double slack = 1e-5; // lookups in single precision round
        const double largest = transfer_function.max_extinction(data.low, data.high) * (1.0 + slack);
        const double smallest = transfer_function.min_extinction(data.low, data.high) * (1.0 - slack);
        majorant_[cell] = static_cast<float>(largest);
        const double middle = (largest - smallest) * diagonal < thin_cell ? 0.5 * (largest + smallest) : smallest;
        for (const auto& [control, residual] : {std::pair{smallest, &residual_[0]}, std::pair{middle, &residual_[1]}}) {
            (*residual)[2 * cell] = static_cast<float>(largest - control);
            (*residual)[2 * cell + 1] = static_cast<float>(control);
        }
    });
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
