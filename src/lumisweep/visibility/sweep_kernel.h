// The inner loops of a sweep, compiled once per instruction set (sweep_kernel_*.cpp) and chosen at start-up.
//
// All loops run along one row, contiguously and without gathers from memory that other rows share. The march is in
// integers and nothing is contracted or reassociated, so every instruction set gives the same bits.
#pragma once

#include <cstdint>

namespace lumisweep {

/// Optical depth on rays counts in units of 1/256 of a stored extinction step × one slice.
inline constexpr int optical_depth_unit = 256;
/// Horizontal weights are 16-bit fractions; this is the whole.
inline constexpr int whole_weight = 65535;
/// V during lookup and filter: fixed point, this is 1.
inline constexpr int whole_visibility = 65535;

/// What the cells of one row of a slice look up.
struct LookupRow {
    const float* tau;           ///< [ray column] optical depth, already interpolated across the rows
    const float* length;        ///< [ray column] slices travelled inside of the box, likewise
    const std::int32_t* ray;    ///< [cell] the ray column on the cell's low side
    const float* fraction;      ///< [cell] towards the next ray column
    const float* enter;         ///< [cell] depth at which the cell's own ray comes in through a u side, if it does
    const float* leave;         ///< [cell] likewise out
    float row_enter, row_leave; ///< the same for the v sides
    float tau_scale;            ///< natural optical depth of one unit of tau
    int count;                  ///< cells
};

struct SweepKernels {
    const char* name;
    /// mixed[i] = (low[i] · (256 − weight) + high[i] · weight), weight in 0 … 256.
    void (*mix_rows)(std::uint16_t* mixed, const std::uint8_t* low, const std::uint8_t* high, int weight, int count);
    /// tau[i] += mixed[i] · weight0 + mixed[i + 1] · weight1, with weights in 1/65536.
    void (*advance_rays)(std::int32_t* tau, const std::uint16_t* mixed, int weight0, int weight1, int count);
    /// tau[i] = low[i] + (high[i] − low[i]) · fraction.
    void (*mix_rays)(float* tau, const std::int32_t* low, const std::int32_t* high, float fraction, int count);
    /// length[i]: the same mix of how far the two rays have come inside of the box at `depth`; a ray is inside from
    /// max(0, enter[i], its row's enter) to min(depth, leave[i], its row's leave).
    void (*mix_lengths)(float* length, const float* enter, const float* leave, const float* row_enter,
                        const float* row_leave, float depth, float fraction, int count);
    /// visibility[i] = exp(−τ) in 1/65535.
    void (*look_up)(std::int32_t* visibility, const LookupRow& row, float depth, float* scratch);
};

extern const SweepKernels sweep_kernels_baseline;
#if defined(__x86_64__)
extern const SweepKernels sweep_kernels_avx2;
extern const SweepKernels sweep_kernels_avx512;
#endif

/// The widest instruction set of this machine.
const SweepKernels& sweep_kernels();

} // namespace lumisweep
