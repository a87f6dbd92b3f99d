#include "lumisweep/volume/transfer_function.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/transfer_function_view.h"

namespace lumisweep {

namespace {

constexpr std::size_t max_points = 65536;
constexpr int max_bins = 4096;

bool in_unit_range(const Vec3d& c)
{
    return c.x >= 0.0 && c.x <= 1.0 && c.y >= 0.0 && c.y <= 1.0 && c.z >= 0.0 && c.z <= 1.0;
}

void validate(const std::vector<TransferPoint>& points, double extinction_scale)
{
    require(!points.empty(), "transfer_function.points: is empty (give at least one point)");
    require(points.size() <= max_points, "transfer_function.points: {} points are too many (at most {})", points.size(),
            max_points);
    require(std::isfinite(extinction_scale) && extinction_scale >= 0.0 && extinction_scale <= 1e30,
            "transfer_function.extinction_scale: {} is not usable (give a number from 0 to 1e30)", extinction_scale);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const TransferPoint& p = points[i];
        require(std::isfinite(p.value) && std::fabs(p.value) <= 1e30,
                "transfer_function.points[{}].value: {} is not usable (give a finite number)", i, p.value);
        require(i == 0 || points[i - 1].value <= p.value,
                "transfer_function.points[{}].value: {} is below the point before it (sort the points by value)", i,
                p.value);
        require(std::isfinite(p.extinction) && p.extinction >= 0.0 && p.extinction <= 1e30 &&
                    p.extinction * extinction_scale <= 1e30,
                "transfer_function.points[{}].extinction: {} is not usable (give a number from 0 to 1e30)", i,
                p.extinction);
        require(in_unit_range(p.albedo), "transfer_function.points[{}].albedo: ({}, {}, {}) leaves [0, 1]", i,
                p.albedo.x, p.albedo.y, p.albedo.z);
    }
}

} // namespace

TransferFunction::TransferFunction(std::vector<TransferPoint> points, double extinction_scale)
    : points_(std::move(points)), extinction_scale_(extinction_scale)
{
    validate(points_, extinction_scale_);
    build_tables();
}

void TransferFunction::build_tables()
{
    const int k = static_cast<int>(points_.size());
    const int stride = std::max(k + 2, small_table);
    table_.assign(static_cast<std::size_t>(transfer_table_fields * stride), 0.0F);
    const auto set = [&](int field, int segment, double v) {
        table_[static_cast<std::size_t>(field * stride + segment)] = static_cast<float>(v);
    };
    for (int s = 0; s <= k; ++s) {
        const TransferPoint& left = points_[static_cast<std::size_t>(std::max(s - 1, 0))];
        const TransferPoint& right = points_[static_cast<std::size_t>(std::min(s, k - 1))];
        const double width = right.value - left.value;
        const bool flat = s == 0 || s == k || static_cast<float>(left.value) == static_cast<float>(right.value);
        const auto put = [&](int field, double y0, double y1) {
            set(field, s, y0);
            // A flank too steep for single precision stays finite, so that 0 · slope is 0 at its knot.
            set(field + 1, s, flat ? 0.0 : std::clamp((y1 - y0) / width, -1e38, 1e38));
        };
        set(0, s, left.value);
        put(1, left.extinction * extinction_scale_, right.extinction * extinction_scale_);
        put(3, left.albedo.x, right.albedo.x);
        put(5, left.albedo.y, right.albedo.y);
        put(7, left.albedo.z, right.albedo.z);
    }
    for (int s = k + 1; s < stride; ++s)
        table_[static_cast<std::size_t>(s)] = std::numeric_limits<float>::infinity();

    // Bins: as many as it takes for one comparison a lookup, within reason.
    const float first = static_cast<float>(points_.front().value);
    const float last = static_cast<float>(points_.back().value);
    const float* knots = table_.data();
    for (int bins = 16;; bins *= 2) {
        const float inverse_bin = last > first ? static_cast<float>(bins) / (last - first) : 0.0F;
        std::vector<std::int32_t> hints(static_cast<std::size_t>(bins));
        // A value falls into the bin that the kernel's own arithmetic says; that is monotonic in the value, so the bins
        // of the knots delimit what each bin can hold: segments from the last knot of an earlier bin to its own last
        // knot.
        const auto bin_of = [&](float v) {
            const float b = (v - first) * inverse_bin;
            return b > 0.0F ? static_cast<int>(std::min(b, static_cast<float>(bins - 1))) : 0;
        };
        int steps = 1;
        for (int b = 0, s = 0; b < bins; ++b) {
            // The first segment of the bin: the one that began in an earlier bin (segment 0 has no beginning).
            hints[static_cast<std::size_t>(b)] = s;
            int e = s;
            while (e < k && bin_of(knots[e + 1]) == b)
                ++e;
            steps = std::max(steps, e - s);
            s = e;
        }
        if (steps == 1 || bins == max_bins || inverse_bin == 0.0F) {
            hints_ = std::move(hints);
            inverse_bin_ = inverse_bin;
            search_steps_ = steps;
            break;
        }
    }
}

TransferFunction::Material TransferFunction::evaluate(double value) const
{
    if (std::isnan(value))
        return {0.0, points_.front().albedo};
    const TransferPosition p = position_of(points_view(), value);
    const Vec3d& left = points_[static_cast<std::size_t>(p.left)].albedo;
    const Vec3d& right = points_[static_cast<std::size_t>(p.right)].albedo;
    return {exact_extinction(points_view(), p), left + (right - left) * p.fraction};
}

double TransferFunction::max_extinction(double low, double high) const
{
    return lumisweep::max_extinction(points_view(), low, high);
}

double TransferFunction::min_extinction(double low, double high) const
{
    return lumisweep::min_extinction(points_view(), low, high);
}

double TransferFunction::lookup_error(double value) const { return lumisweep::lookup_error(points_view(), value); }

TransferFunctionView TransferFunction::view(double slope, double intercept) const
{
    TransferFunctionView view;
    view.table = table_.data();
    view.hints = hints_.data();
    view.stride = static_cast<int>(table_.size()) / transfer_table_fields;
    view.bin_count = static_cast<int>(hints_.size());
    view.search_steps = search_steps_;
    view.first = static_cast<float>(points_.front().value);
    view.inverse_bin = inverse_bin_;
    view.slope = static_cast<float>(slope);
    view.intercept = static_cast<float>(intercept);
    return view;
}

} // namespace lumisweep
