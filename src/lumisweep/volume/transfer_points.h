// The points of a transfer function, and extinction between them in double precision, for the host and for devices.
#pragma once

#include "lumisweep/base/host_device.h"
#include "lumisweep/math/lanes.h"
#include "lumisweep/math/vec.h"

namespace lumisweep {

struct TransferPoint {
    double value = 0.0;          ///< data units
    double extinction = 0.0;     ///< 1 / world unit, before extinction_scale
    Vec3d albedo{1.0, 1.0, 1.0}; ///< [0, 1] per channel
};

/// A plain view of TransferFunction's points: at least one, sorted by value.
struct TransferPointsView {
    const TransferPoint* points = nullptr;
    int count = 0;
    double extinction_scale = 1.0;
};

/// How many points, counted from the first, satisfy `before`, which holds of none behind one of which it does not.
template <class Before>
LUMISWEEP_HD int count_points(const TransferPointsView& tf, Before&& before)
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
LUMISWEEP_HD int points_up_to(const TransferPointsView& tf, double value)
{
    return count_points(tf, [value](const TransferPoint& p) { return !(value < p.value); });
}

/// Where a value lies: `fraction` of the way from one point to another. Outside of the first and the last both are the
/// same.
struct TransferPosition {
    int left = 0, right = 0;
    double fraction = 0.0;
};

/// Not for NaN. Of points that share the value the last is the left one.
LUMISWEEP_HD TransferPosition position_of(const TransferPointsView& tf, double value)
{
    const int right = points_up_to(tf, value);
    if (right == 0)
        return {};
    if (right == tf.count)
        return {right - 1, right - 1, 0.0};
    const double left_value = tf.points[right - 1].value;
    return {right - 1, right, (value - left_value) / (tf.points[right].value - left_value)};
}

/// σt in 1/world unit.
LUMISWEEP_HD double exact_extinction(const TransferPointsView& tf, const TransferPosition& at)
{
    const double left = tf.points[at.left].extinction;
    return (left + (tf.points[at.right].extinction - left) * at.fraction) * tf.extinction_scale;
}

/// Of a value in data units; 0 for NaN.
LUMISWEEP_HD double exact_extinction(const TransferPointsView& tf, double value)
{
    return value != value ? 0.0 : exact_extinction(tf, position_of(tf, value));
}

/// The extremes of extinction over values in [low, high], of a step's both sides; 0 for an empty interval.
template <class Fold>
LUMISWEEP_HD double fold_extinction(const TransferPointsView& tf, double low, double high, Fold&& fold)
{
    if (!(low <= high))
        return 0.0;
    double result = fold(exact_extinction(tf, low), exact_extinction(tf, high));
    for (int i = count_points(tf, [low](const TransferPoint& p) { return p.value < low; });
         i < tf.count && tf.points[i].value <= high; ++i)
        result = fold(result, tf.points[i].extinction * tf.extinction_scale);
    return result;
}
LUMISWEEP_HD double max_extinction(const TransferPointsView& tf, double low, double high)
{
    return fold_extinction(tf, low, high, [](double a, double b) { return max(a, b); });
}
LUMISWEEP_HD double min_extinction(const TransferPointsView& tf, double low, double high)
{
    return fold_extinction(tf, low, high, [](double a, double b) { return min(a, b); });
}

/// How far lookups in single precision may be from extinction in the segment of a value (TransferFunction).
LUMISWEEP_HD double lookup_error(const TransferPointsView& tf, double value)
{
    const int right = points_up_to(tf, value);
    return right == 0 || right == tf.count ? 0.0 : 1e-6 * tf.points[right - 1].extinction * tf.extinction_scale;
}

} // namespace lumisweep
