// Transfer function: value in data units → extinction σt (1/world unit) and albedo ρ per channel, piecewise linear.
#pragma once

#include <cstdint>
#include <vector>

#include "lumisweep/math/vec.h"
#include "lumisweep/volume/transfer_points_view.h"

namespace lumisweep {

struct TransferFunctionView; // volume/transfer_function_view.h

struct TransferPoint {
    double value = 0.0;          ///< data units
    double extinction = 0.0;     ///< 1 / world unit, before extinction_scale
    Vec3d albedo{1.0, 1.0, 1.0}; ///< [0, 1] per channel
};

/// Piecewise linear between points sorted by value, clamped outside the first and the last. Two points may share a
/// value: a step, whose upper side holds from that value on.
class TransferFunction {
public:
    struct Material {
        double extinction;
        Vec3d albedo;
    };

    /// Empty space everywhere.
    TransferFunction() : TransferFunction({TransferPoint{}}) {}
    /// Throws Error for no points, unsorted or non-finite values, negative extinction, albedo outside [0, 1].
    explicit TransferFunction(std::vector<TransferPoint> points, double extinction_scale = 1.0);

    const std::vector<TransferPoint>& points() const { return points_; }
    double extinction_scale() const { return extinction_scale_; }

    /// The reference evaluation; NaN gives zero extinction.
    Material evaluate(double value) const;
    /// The largest extinction over values in [low, high]; 0 for an empty interval (low > high).
    double max_extinction(double low, double high) const;
    /// The smallest; of a step both sides count.
    double min_extinction(double low, double high) const;
    /// How far lookups in single precision may be from extinction in the segment of a value, which its left point
    /// begins: relative to extinction there, of which little may be left.
    double lookup_error(double value) const;

    /// Tables that kernels read, for raw voxels with value = slope · raw + intercept. Valid while this object lives.
    TransferFunctionView view(double slope, double intercept) const;
    /// Values and extinctions of the points. Valid while this object lives.
    PointsView points_view() const
    {
        return {extinction_points_.data(), static_cast<int>(extinction_points_.size()), extinction_scale_};
    }

private:
    void build_tables();

    std::vector<TransferPoint> points_;
    std::vector<TransferPointView> extinction_points_; // of points_, without albedo
    double extinction_scale_ = 1.0;
    std::vector<float> table_; // as in TransferFunctionView
    std::vector<std::int32_t> hints_;
    float inverse_bin_ = 0.0F;
    int search_steps_ = 0;
};

} // namespace lumisweep
