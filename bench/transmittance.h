// Estimators of transmittance along shadow rays, compared in variance times CPU time: the estimate alone, and within a
// whole render. studies/transmittance.py runs it and writes the report.
#pragma once

#include <filesystem>
#include <span>

#include "lumisweep/base/aligned.h"
#include "lumisweep/volume/scalar_grid.h"
#include "lumisweep/volume/transfer_function.h"
#include "transmittance_view.h"

namespace lumisweep::bench {

/// Those that this machine runs, widest first; the last is the scalar one.
std::span<const TransmittanceKernels> transmittance_kernels();

/// Extinction per cell that residual ratio tracking takes out in closed form.
enum class Control {
    smallest,
    /// Half-way between the smallest and the largest where that leaves little to look up: a factor of a lookup then
    /// lies in [0, 2], and both the lookups and the variance that they bring are halved (σ equally likely between the
    /// two). But rays through what is empty of a cell gain variance exponentially with the cell's optical depth, so
    /// opaque cells keep the smallest.
    centred,
};

/// The smallest and the largest extinction per cell. The volume must be finite everywhere.
class CellBounds {
public:
    CellBounds() = default;
    CellBounds(const ScalarGrid& volume, const TransferFunction& transfer_function);
    CellBoundsView view(Control control) const
    {
        return {majorant_.data(), residual_[static_cast<std::size_t>(control)].data(), cells_.x, cells_.y, cells_.z};
    }

private:
    Vec3i cells_{0, 0, 0};
    AlignedArray<float> majorant_, residual_[2];
};

/// Room for shadow rays.
class ShadowRays {
public:
    explicit ShadowRays(std::size_t capacity);
    ShadowSink& sink() { return sink_; }
    const ShadowSink& sink() const { return sink_; }
    ShadowRaysView view() const;

private:
    AlignedArray<float> floats_[7];
    AlignedArray<std::int32_t> ints_[4];
    ShadowSink sink_;
};

/// Registers "transmittance/MEDIUM/STRATEGY/ESTIMATOR". Real media need scripts/fetch_data.
void register_transmittance(const std::filesystem::path& data, bool quick);

} // namespace lumisweep::bench
