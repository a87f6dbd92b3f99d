// The transfer function as kernels read it: exact piecewise-linear lookups for every lane type.
#pragma once

#include <cstdint>

#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

inline constexpr int transfer_table_fields = 9;

/// K points make K + 1 segments: segment 0 lies below the first point, segment s in [value s−1, value s), segment K
/// above. Within a segment y(v) = y_knot + (v − knot) · slope, so steps and close points cost no accuracy, unlike a
/// resampled table. Memory: table [transfer_table_fields][stride] float: knot, extinction, its slope, then albedo and
/// its slope for r, g, b; knot [stride − 1] is +infinity. hints [bin_count]: the first segment that a uniform bin of
/// [first, last] can need; search_steps comparisons find the segment from there. Tables of up to small_table segments,
/// the rest of which begin at +infinity, are searched by halves instead: they fit into registers.
struct TransferFunctionView {
    const float* table = nullptr;
    const std::int32_t* hints = nullptr;
    int stride = 0;
    int bin_count = 0;
    int search_steps = 0;
    float first = 0.0F;                   ///< value of the first point
    float inverse_bin = 0.0F;             ///< bins per data unit
    float slope = 1.0F, intercept = 0.0F; ///< value = slope · raw + intercept
};

template <class F>
struct TransferSegment {
    int_of<F> index;
    F offset; ///< value − knot
};

/// Finds the segment of a value in data units; NaN counts as the lowest value (callers mask it).
template <class F>
LUMISWEEP_HD TransferSegment<F> find_segment(const TransferFunctionView& tf, const F& value)
{
    using I = int_of<F>;
    I s = I(0);
    if (tf.stride == small_table) {
        for (int half = small_table / 2; half > 0; half /= 2)
            s = select(value >= gather_small(tf.table, s + I(half)), s + I(half), s);
        return {s, value - gather_small(tf.table, s)};
    }
    const F bin = (value - F(tf.first)) * F(tf.inverse_bin);
    const F last_bin = F(static_cast<float>(tf.bin_count - 1));
    // The comparison is false for NaN, which makes it bin 0.
    const F clamped = select(bin > F(0.0F), min(bin, last_bin), F(0.0F));
    s = gather(tf.hints, to_int(clamped));
    for (int step = 0; step < tf.search_steps; ++step)
        s = select(value >= gather(tf.table, s + I(1)), s + I(1), s);
    return {s, value - gather(tf.table, s)};
}

/// Column `field` of the table at a segment.
template <class F>
LUMISWEEP_HD F table_at(const TransferFunctionView& tf, int field, const int_of<F>& segment)
{
    const float* column = tf.table + field * tf.stride;
    return tf.stride == small_table ? gather_small(column, segment) : gather(column, segment);
}

/// σt in 1/world unit at a raw (not yet scaled) value; 0 for NaN, and for the infinities that interpolating huge voxels
/// brings. Never negative: near the end of a falling flank rounding may cancel to below 0, which would amplify light.
template <class F>
LUMISWEEP_HD F extinction_at(const TransferFunctionView& tf, const F& raw)
{
    const F value = fma(raw, F(tf.slope), F(tf.intercept));
    const TransferSegment<F> s = find_segment(tf, value);
    const F y = table_at<F>(tf, 1, s.index);
    const F slope = table_at<F>(tf, 2, s.index);
    constexpr float largest = 3.40282347e38F;
    return select(abs(value) <= F(largest), max(fma(s.offset, slope, y), F(0.0F)), F(0.0F));
}

/// What a scattering event needs to know of the material.
template <class F>
struct MaterialSample {
    Vec3<F> albedo;
    F extinction_slope; ///< dσt / d value; its sign says which way the gradient of extinction points
};

template <class F>
LUMISWEEP_HD MaterialSample<F> material_at(const TransferFunctionView& tf, const F& raw)
{
    const F value = fma(raw, F(tf.slope), F(tf.intercept));
    const TransferSegment<F> s = find_segment(tf, value);
    const auto channel = [&](int c) {
        return fma(s.offset, table_at<F>(tf, 4 + 2 * c, s.index), table_at<F>(tf, 3 + 2 * c, s.index));
    };
    return {{channel(0), channel(1), channel(2)}, table_at<F>(tf, 2, s.index)};
}

} // namespace lumisweep
