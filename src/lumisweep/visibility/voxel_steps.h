// Extinction of one voxel in stored steps, for the host's loops (classify_steps.h, classify_block_impl.h) and for
// devices. Steps are in 16.16 fixed point until they are dithered; all of 255. Every operation is rounded by itself.
#pragma once

#include <cmath>
#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/volume/transfer_function_view.h"
#include "lumisweep/volume/transfer_points.h"

namespace lumisweep {

/// Steps in fixed point of one stored step.
inline constexpr double fixed_one = 65536.0;

/// Of a raw voxel of 8 or 16 bits, value = slope · raw + intercept, where a stored step is `scale` > 0 of extinction.
LUMISWEEP_HD std::int32_t steps_of_raw(const TransferPointsView& tf, double slope, double intercept, double scale,
                                       int raw)
{
    const double steps = exact_extinction(tf, slope * raw + intercept) / scale;
    return static_cast<std::int32_t>(std::lround(min(steps, 255.0) * fixed_one));
}

/// The mean of 2^shift numbers from their sum.
template <class Sum>
LUMISWEEP_HD std::int32_t rounded_mean(Sum sum, int shift)
{
    return static_cast<std::int32_t>((sum + (Sum{1} << (shift - 1))) >> shift);
}

/// Rounds up as often as the fraction says.
LUMISWEEP_HD std::uint8_t dithered(std::int32_t steps, std::uint16_t random)
{
    return static_cast<std::uint8_t>((steps + random) >> 16);
}

/// How float voxels become steps: steps_of_one · extinction; 0 where empty_first ≤ value < empty_end (data units).
struct FloatClassification {
    TransferFunctionView tf;
    float steps_of_one = 0.0F, empty_first = 0.0F, empty_end = 0.0F;
};

namespace {

/// The renderer's search for the segment, for any number of points.
template <class F>
struct GatheredSegments {
    LUMISWEEP_HD explicit GatheredSegments(const TransferFunctionView& view) : tf(view) {}
    LUMISWEEP_HD F extinction(const F& value) const
    {
        const TransferSegment<F> s = find_segment(tf, value);
        return s.offset * gather(tf.table + 2 * tf.stride, s.index) + gather(tf.table + tf.stride, s.index);
    }
    const TransferFunctionView& tf;
};

/// Steps of float voxels. empty(): certainly all 0, found out at less cost.
template <class F, class Segments>
class FloatSteps {
public:
    LUMISWEEP_HD explicit FloatSteps(const FloatClassification& job)
        : segments_(job.tf), slope_(job.tf.slope), intercept_(job.tf.intercept), steps_of_one_(job.steps_of_one),
          empty_first_(job.empty_first), empty_end_(job.empty_end)
    {
    }
    LUMISWEEP_HD F value_of(const F& raw) const { return raw * slope_ + intercept_; }
    LUMISWEEP_HD bool empty(const F& value) const { return all((value >= empty_first_) & (value < empty_end_)); }
    LUMISWEEP_HD int_of<F> operator()(const F& value) const
    {
        const F steps = min(max(segments_.extinction(value) * steps_of_one_, F(0.0F)), F(255.0F * 65536.0F));
        constexpr float largest = 3.40282347e38F; // what lies beyond, and NaN, is empty
        return to_int(select(abs(value) <= F(largest), steps, F(0.0F)) + F(0.5F));
    }

private:
    Segments segments_;
    F slope_, intercept_, steps_of_one_, empty_first_, empty_end_;
};

} // namespace
} // namespace lumisweep
