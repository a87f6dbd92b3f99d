// The points of a transfer function, and extinction between them in double precision, for the host and for devices.
#pragma once

#include "lumisweep/base/host_device.h"
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

/// Where a value lies: `fraction` of the way from one point to another. Outside of the first and the last both are the
/// same.
struct TransferPosition {
    int left = 0, right = 0;
    double fraction = 0.0;
};

/// Not for NaN. Of points that share the value the last is the left one.
LUMISWEEP_HD TransferPosition position_of(const TransferPointsView& tf, double value)
{
    int right = 0; // points that the value has reached
    for (int count = tf.count; count > 0;) {
        const int half = count / 2;
        const bool reached = tf.points[right + half].value <= value;
        right = reached ? right + half + 1 : right;
        count = reached ? count - half - 1 : half;
    }
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

} // namespace lumisweep
