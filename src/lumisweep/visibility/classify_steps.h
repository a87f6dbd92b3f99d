// Stored steps of voxels, over the lane type F; for classify_block_impl.h, whose rules hold here too.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/visibility/classify_block.h"

namespace lumisweep {
namespace {

/// widened(raw): voxels of 8 or 16 bits as int_of<F>.
/// transpose_64(…): transposes 64 × 64 bytes.
/// any_of_64(bytes): whether one of 64 bytes is not 0.
/// copy(to, from, count): memory that is not read again soon, so past the caches where the machine can.
template <class F>
struct ClassifyLanes;

/// Steps of voxels of 8 and 16 bits. empty(): certainly all 0, found out at less cost.
template <class F>
class TableSteps {
public:
    explicit TableSteps(const ClassifyJob& job)
        : table_(job.table), empty_first_(job.empty_first), empty_last_(job.empty_last)
    {
    }
    template <class T>
    LUMISWEEP_HD int_of<F> load_raw(const T* raw) const
    {
        return ClassifyLanes<F>::widened(raw);
    }
    LUMISWEEP_HD bool empty(const int_of<F>& raw) const { return !any((raw < empty_first_) | (raw > empty_last_)); }
    LUMISWEEP_HD int_of<F> operator()(const int_of<F>& raw) const { return gather(table_, raw); }

private:
    const std::int32_t* table_;
    int_of<F> empty_first_, empty_last_;
};

/// The renderer's search for the segment, for any number of points.
template <class F>
struct GatheredSegments {
    explicit GatheredSegments(const TransferFunctionView& view) : tf(view) {}
    LUMISWEEP_HD F extinction(const F& value) const
    {
        const TransferSegment<F> s = find_segment(tf, value);
        return s.offset * gather(tf.table + 2 * tf.stride, s.index) + gather(tf.table + tf.stride, s.index);
    }
    const TransferFunctionView& tf;
};

/// Steps of float voxels.
template <class F, class Segments>
class FloatSteps {
public:
    explicit FloatSteps(const ClassifyJob& job)
        : segments_(job.tf), slope_(job.tf.slope), intercept_(job.tf.intercept), steps_of_one_(job.steps_of_one),
          empty_first_(job.empty_first_value), empty_end_(job.empty_end_value)
    {
    }
    LUMISWEEP_HD F load_raw(const float* raw) const { return load<F>(raw) * slope_ + intercept_; }
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
