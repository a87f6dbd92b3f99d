// The largest extinction between two bounds as a code of the majorant grid, in two lookups.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/volume/extinction_code_steps.h"
#include "lumisweep/volume/transfer_function.h"

namespace lumisweep {

/// Built once a transfer function.
class ExtinctionCodes {
public:
    ExtinctionCodes(const WholeBounds& bounds, const TransferFunction& transfer_function);

    /// A bound of all extinctions, 1/world unit; the highest code's.
    float largest() const { return largest_; }
    ExtinctionCodesView view() const { return view_; }

private:
    float largest_ = 0.0F;
    std::vector<std::uint8_t> maxima_;
    ExtinctionCodesView view_;
};

} // namespace lumisweep
