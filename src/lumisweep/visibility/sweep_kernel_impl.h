// Bodies of sweep_kernel.h, included by one file per instruction set with LUMISWEEP_SWEEP_KERNELS set to the table's
// name. Everything is static and uses no inline function of any header: the linker must not mix instruction sets.
#include "lumisweep/visibility/sweep_kernel.h"

namespace lumisweep {
namespace {

void mix_rows(std::uint16_t* __restrict mixed, const std::uint8_t* low, const std::uint8_t* high, int weight, int count)
{
    const auto w1 = static_cast<std::uint16_t>(weight);
    const auto w0 = static_cast<std::uint16_t>(256 - weight);
    for (int i = 0; i < count; ++i)
        mixed[i] = static_cast<std::uint16_t>(static_cast<std::uint16_t>(low[i] * w0) +
                                              static_cast<std::uint16_t>(high[i] * w1));
}

void advance_rays(std::int32_t* __restrict tau, const std::uint16_t* __restrict mixed, int weight0, int weight1,
                  int count)
{
    const auto w0 = static_cast<std::uint16_t>(weight0);
    const auto w1 = static_cast<std::uint16_t>(weight1);
    for (int i = 0; i < count; ++i) {
        const auto a = static_cast<std::uint16_t>((static_cast<std::uint32_t>(mixed[i]) * w0) >> 16);
        const auto b = static_cast<std::uint16_t>((static_cast<std::uint32_t>(mixed[i + 1]) * w1) >> 16);
        tau[i] += static_cast<std::uint16_t>(a + b);
    }
}

void mix_rays(float* __restrict tau, const std::int32_t* low, const std::int32_t* high, float fraction, int count)
{
    const float rest = 1.0F - fraction;
    for (int i = 0; i < count; ++i)
        tau[i] = static_cast<float>(low[i]) * rest + static_cast<float>(high[i]) * fraction;
}

void mix_lengths(float* __restrict length, const float* enter, const float* leave, const float* row_enter,
                 const float* row_leave, float depth, float fraction, int count)
{
    const float enter0 = row_enter[0] > 0.0F ? row_enter[0] : 0.0F,
                leave0 = row_leave[0] < depth ? row_leave[0] : depth;
    const float enter1 = row_enter[1] > 0.0F ? row_enter[1] : 0.0F,
                leave1 = row_leave[1] < depth ? row_leave[1] : depth;
    const float rest = 1.0F - fraction;
    for (int i = 0; i < count; ++i) {
        const float e = enter[i], l = leave[i];
        const float length0 = (l < leave0 ? l : leave0) - (e > enter0 ? e : enter0);
        const float length1 = (l < leave1 ? l : leave1) - (e > enter1 ? e : enter1);
        length[i] = (length0 > 0.0F ? length0 : 0.0F) * rest + (length1 > 0.0F ? length1 : 0.0F) * fraction;
    }
}

/// exp(−x) for x ≥ 0, relative error below 1e−6 until it flushes to 3e−38 at x = 87.
inline __attribute__((always_inline)) float exp_minus(float x)
{
    const float y = (x < 87.0F ? x : 87.0F) * -1.44269504F;
    const int whole = static_cast<int>(y - 0.5F); // y ≤ 0: rounds to nearest
    const float f = (y - static_cast<float>(whole)) * 0.69314718F;
    float p = 1.0F / 720.0F;
    p = p * f + 1.0F / 120.0F;
    p = p * f + 1.0F / 24.0F;
    p = p * f + 1.0F / 6.0F;
    p = p * f + 0.5F;
    p = p * f + 1.0F;
    p = p * f + 1.0F;
    return p * __builtin_bit_cast(float, (whole + 127) << 23);
}

void look_up(std::int32_t* __restrict visibility, const LookupRow& row, float depth, float* __restrict scratch)
{
    const int count = row.count;
    const float row_enter = row.row_enter > 0.0F ? row.row_enter : 0.0F;
    const float row_leave = row.row_leave < depth ? row.row_leave : depth;
    // Rays on the two sides of a cell may have come different ways through the box (in through a side, or gone out
    // through one already), so what is interpolated is their mean extinction: Σ w τ / Σ w length, times the cell's
    // length.
    for (int i = 0; i < count; ++i) {
        const int r = row.ray[i];
        const float f = row.fraction[i], rest = 1.0F - f;
        const float tau = row.tau[r] * rest + row.tau[r + 1] * f;
        const float length = row.length[r] * rest + row.length[r + 1] * f;
        const float e = row.enter[i], l = row.leave[i];
        const float own = (l < row_leave ? l : row_leave) - (e > row_enter ? e : row_enter);
        scratch[i] = tau * own / (length > 1e-6F ? length : 1e-6F);
    }
    const float scale = row.tau_scale;
    for (int i = 0; i < count; ++i) {
        const float tau = scratch[i] * scale;
        visibility[i] =
            static_cast<int>(exp_minus(tau > 0.0F ? tau : 0.0F) * static_cast<float>(whole_visibility) + 0.5F);
    }
}

} // namespace

const SweepKernels LUMISWEEP_SWEEP_KERNELS = {
    LUMISWEEP_SWEEP_KERNELS_NAME, mix_rows, advance_rays, mix_rays, mix_lengths, look_up};

} // namespace lumisweep
