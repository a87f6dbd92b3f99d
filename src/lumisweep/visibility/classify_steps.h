// Stored steps of voxels, over the lane type F; for classify_block_impl.h, whose rules hold here too.
#pragma once

#include "lumisweep/math/lanes.h"
#include "lumisweep/visibility/classify_block.h"
#include "lumisweep/visibility/voxel_steps.h"

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

/// FloatSteps of voxels in memory.
template <class F, class Segments>
class LoadedFloatSteps : public FloatSteps<F, Segments> {
public:
    explicit LoadedFloatSteps(const ClassifyJob& job) : FloatSteps<F, Segments>(job.floats) {}
    LUMISWEEP_HD F load_raw(const float* raw) const { return this->value_of(load<F>(raw)); }
};

} // namespace
} // namespace lumisweep
