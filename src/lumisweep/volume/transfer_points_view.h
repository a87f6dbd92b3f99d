// The transfer function's extinction in double precision as device code reads it: the points themselves.
#pragma once

#include <cmath>

#include "lumisweep/base/host_device.h"
#include "lumisweep/math/lanes.h"

namespace lumisweep {

struct TransferPointView {
    double value = 0.0;      ///< data units
    double extinction = 0.0; ///< 1 / world unit, before the scale
};

/// What TransferFunction holds but for albedo. Memory: points [count], sorted by value, at least one.
struct PointsView {
    const TransferPointView* points = nullptr;
    int count = 0;
    double scale = 1.0; ///< extinction_scale
};

/// How many points, counted from the first, satisfy `before`, which holds of none behind one of which it does not.
template <class Before>
LUMISWEEP_HD int count_points(const PointsView& tf, Before&& before)
{
    int first = 0;
    for (int left = tf.count; left > 0;) {
        const int half = left / 2;
        const bool is_before = before(tf.points[first + half]);
        first = is_before ? first + half + 1 : first;
        left = is_before ? left - half - 1 : half;
    }
    return first;
}
/// Points that do not lie above `value`; all of them for NaN.
LUMISWEEP_HD int points_up_to(const PointsView& tf, double value)
{
    return count_points(tf, [value](const TransferPointView& p) { return !(value < p.value); });
}

/// Where a value lies between points `segment` − 1 and `segment`, 0 … 1; segment is neither 0 nor count.
LUMISWEEP_HD double fraction_in_segment(const PointsView& tf, int segment, double value)
{
    const double left = tf.points[segment - 1].value;
    return (value - left) / (tf.points[segment].value - left);
}

/// Extinction at a value of segment points_up_to(value), that with `segment` points on its left.
LUMISWEEP_HD double extinction_in_segment(const PointsView& tf, int segment, double value)
{
    if (segment == 0 || segment == tf.count)
        return tf.points[segment == 0 ? 0 : tf.count - 1].extinction * tf.scale;
    const double a = tf.points[segment - 1].extinction, b = tf.points[segment].extinction;
    return (a + (b - a) * fraction_in_segment(tf, segment, value)) * tf.scale;
}

/// TransferFunction::evaluate's.
LUMISWEEP_HD double extinction_at_points(const PointsView& tf, double value)
{
    return std::isnan(value) ? 0.0 : extinction_in_segment(tf, points_up_to(tf, value), value);
}

/// The extremes of extinction over values in [low, high], of a step's both sides; 0 for an empty interval.
template <class Fold>
LUMISWEEP_HD double fold_extinction(const PointsView& tf, double low, double high, Fold&& fold)
{
    if (!(low <= high))
        return 0.0;
    double result = fold(extinction_at_points(tf, low), extinction_at_points(tf, high));
    for (int i = count_points(tf, [low](const TransferPointView& p) { return p.value < low; });
         i < tf.count && tf.points[i].value <= high; ++i)
        result = fold(result, tf.points[i].extinction * tf.scale);
    return result;
}
LUMISWEEP_HD double max_extinction(const PointsView& tf, double low, double high)
{
    return fold_extinction(tf, low, high, [](double a, double b) { return max(a, b); });
}
LUMISWEEP_HD double min_extinction(const PointsView& tf, double low, double high)
{
    return fold_extinction(tf, low, high, [](double a, double b) { return min(a, b); });
}

/// TransferFunction::lookup_error's.
LUMISWEEP_HD double lookup_error(const PointsView& tf, double value)
{
    const int segment = points_up_to(tf, value);
    return segment == 0 || segment == tf.count ? 0.0 : 1e-6 * tf.points[segment - 1].extinction * tf.scale;
}

} // namespace lumisweep
