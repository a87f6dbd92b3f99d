// The transfer function as kernels read it.
#pragma once

#include <cstdint>

namespace lumisweep {

/// Piecewise linear over segments of raw voxel value; segment s holds for raw in [knot s, knot s+1).
/// Memory: segment table [segment_count][8] floats: knot, extinction at the knot, its slope, albedo r g b at the knot…
/// see volume/transfer_function.cpp for the exact map.
struct TransferFunctionView {
    const float* segments = nullptr;
    const std::int32_t* hints = nullptr;
};

} // namespace lumisweep
