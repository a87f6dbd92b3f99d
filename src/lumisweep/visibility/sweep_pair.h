// From a plane's optical depths to V of its two directions, slice by slice: exponential, filter, 8 bits.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/base/aligned.h"
#include "lumisweep/visibility/sweep_filter.h"
#include "lumisweep/visibility/sweep_march.h"

namespace lumisweep {

/// Working memory of one thread.
class PairVisibility {
public:
    PairVisibility(const MarchedLevel& level, const SweepKernels& kernels, double tan_beta,
                   const std::atomic<bool>* cancel);

    /// Writes V towards the low side of the sweep's axis and V towards the high side; either may be null. The second
    /// is the opposite direction's: what a ray holds at its end less what it holds at the cell. False when cancelled.
    bool write(RayPlane& plane, std::uint8_t* towards_low, std::uint8_t* towards_high, SweepStats& stats);

private:
    /// The box's sides as the columns of cells of one slice see them (sweep_kernel.h, SideRow).
    struct Sides {
        std::vector<float> begin_low, begin_high, end_low, end_high, enter, leave;
        void place(const SweepAxis& axis, const CellPlaces& places, double cell_side, int slice);
        CellSides of(std::size_t cell) const;
    };

    void look_up(RayPlane& plane, int slice, SweepStats& stats);
    void emit(const SweepGeometry& g, AlignedArray<std::uint16_t>& slice, double distance, int w,
              std::uint8_t* visibility, std::vector<std::uint8_t>& turned, SweepStats& stats);
    void turn(const std::vector<std::uint8_t>& turned, std::uint8_t* visibility) const;

    const MarchedLevel& level_;
    const SweepKernels& kernels_;
    double tan_beta_;
    const std::atomic<bool>* cancel_;
    std::uint8_t *low_ = nullptr, *high_ = nullptr; ///< where to write V of the pair under way
    int cells_u_ = 0, cells_v_ = 0, cells_w_ = 0;
    std::unique_ptr<SliceFilter> filter_;
    Sides u_, v_;
    AlignedArray<float> total_, forwards_, backwards_, row_forwards_, row_backwards_; ///< [u]
    AlignedArray<std::uint16_t> slice_low_, slice_high_;                              ///< [v][u]
    std::vector<std::uint8_t> turned_low_, turned_high_;                              ///< of sweeps along x: [x][z][y]
};

} // namespace lumisweep
