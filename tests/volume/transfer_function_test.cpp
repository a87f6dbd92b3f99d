// Transfer functions: the kernels' lookups against the reference evaluation, and bounds against dense sampling.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "lumisweep/base/error.h"
#include "lumisweep/volume/transfer_function.h"
#include "lumisweep/volume/transfer_function_view.h"

namespace lumisweep {
namespace {

using Points = std::vector<TransferPoint>;

/// Compares lookups at a raw value; lookups are in single precision: 1e-6 of the largest number nearby.
void expect_same(const TransferFunction& tf, float raw, double slope, double intercept, const std::string& what)
{
    const TransferFunctionView view = tf.view(slope, intercept);
    // The value as kernels see it, so that steps are met on the same side.
    const double value = fma(raw, static_cast<float>(slope), static_cast<float>(intercept));
    const TransferFunction::Material expected = tf.evaluate(value);
    // Values and knots round to single precision, which moves the result within what the reference takes nearby.
    const double nearby = 2.5e-7 * (std::fabs(value) + std::fabs(raw * slope) + std::fabs(intercept));
    std::vector<TransferFunction::Material> around = {expected, tf.evaluate(value - nearby),
                                                      tf.evaluate(value + nearby)};
    double largest = 0.0;
    for (const TransferPoint& p : tf.points()) {
        largest = std::max(largest, p.extinction * tf.extinction_scale());
        if (std::fabs(p.value - value) <= nearby)
            around.push_back({p.extinction * tf.extinction_scale(), p.albedo});
    }
    const auto expect_around = [&](double got, auto&& quantity, double tolerance) {
        double low = quantity(expected), high = low;
        for (const TransferFunction::Material& m : around)
            low = std::min(low, quantity(m)), high = std::max(high, quantity(m));
        EXPECT_GE(got, low - tolerance) << what << " at " << value;
        EXPECT_LE(got, high + tolerance) << what << " at " << value;
    };
    expect_around(
        extinction_at(view, raw), [](const auto& m) { return m.extinction; }, 1e-6 * largest);
    const MaterialSample<float> material = material_at(view, raw);
    for (int c = 0; c < 3; ++c)
        expect_around(
            component(material.albedo, c), [&](const auto& m) { return component(m.albedo, c); }, 2e-6);
}

Points random_points(std::mt19937& random, int n)
{
    std::uniform_real_distribution<double> uniform;
    Points points;
    double value = -1000.0;
    for (int i = 0; i < n; ++i) {
        // Some steps, some very close neighbours, some far ones.
        const double kind = uniform(random);
        value += kind < 0.15 ? 0.0 : kind < 0.3 ? 1e-3 * uniform(random) : 30.0 * uniform(random);
        points.push_back({value, 5.0 * uniform(random), {uniform(random), uniform(random), uniform(random)}});
    }
    return points;
}

TEST(TransferFunctionTest, LookupsEqualTheReference)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-0.3, 1.3);
    for (const int n : {1, 2, 3, 5, 10, 40, 100, 300}) {
        for (int repeat = 0; repeat < 8; ++repeat) {
            const Points points = random_points(random, n);
            const TransferFunction tf(points, repeat % 2 == 0 ? 1.0 : 0.37);
            const std::string what = std::to_string(n) + " points, repeat " + std::to_string(repeat);
            const double first = points.front().value, last = points.back().value + 1.0;
            for (int i = 0; i < 400; ++i) {
                const auto v = static_cast<float>(first + (last - first) * uniform(random));
                expect_same(tf, v, 1.0, 0.0, what);
                expect_same(tf, static_cast<float>((v + 1024.0) / -0.5), -0.5, -1024.0, what);
            }
            for (const TransferPoint& p : points) {
                const auto v = static_cast<float>(p.value);
                for (const float at : {v, std::nextafter(v, -1e9F), std::nextafter(v, 1e9F)})
                    expect_same(tf, at, 1.0, 0.0, what + ", at a point");
            }
        }
    }
}

TEST(TransferFunctionTest, StepsTakeTheUpperSide)
{
    const TransferFunction tf({{0.0, 1.0, {0.1, 0.1, 0.1}},
                               {10.0, 2.0, {0.2, 0.2, 0.2}},
                               {10.0, 5.0, {0.5, 0.5, 0.5}},
                               {20.0, 5.0, {0.9, 0.9, 0.9}}});
    EXPECT_EQ(tf.evaluate(10.0).extinction, 5.0);
    EXPECT_NEAR(tf.evaluate(10.0 - 1e-9).extinction, 2.0, 1e-8);
    EXPECT_EQ(tf.evaluate(-5.0).extinction, 1.0);
    EXPECT_EQ(tf.evaluate(25.0).albedo.x, 0.9);
    const TransferFunctionView view = tf.view(1.0, 0.0);
    EXPECT_EQ(extinction_at(view, 10.0F), 5.0F);
    EXPECT_NEAR(extinction_at(view, std::nextafter(10.0F, 0.0F)), 2.0F, 1e-5);
    EXPECT_EQ(material_at(view, 10.0F).albedo.x, 0.5F);
    // A step at the very first and the very last point; three points at one value.
    const TransferFunction ends({{0.0, 1.0}, {0.0, 7.0}, {0.0, 2.0}, {1.0, 3.0}, {1.0, 0.0}});
    const TransferFunctionView ends_view = ends.view(1.0, 0.0);
    for (const float v : {-1.0F, 0.0F, 0.5F, 1.0F, 2.0F})
        EXPECT_FLOAT_EQ(extinction_at(ends_view, v), static_cast<float>(ends.evaluate(v).extinction)) << v;
    EXPECT_EQ(extinction_at(ends_view, 2.0F), 0.0F);
    EXPECT_EQ(extinction_at(ends_view, -1.0F), 1.0F);
}

TEST(TransferFunctionTest, WhatIsNotANumberIsEmpty)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const TransferFunction& tf : {TransferFunction({{0.0, 3.0}}), TransferFunction({{-5.0, 3.0}, {7.0, 2.0}})}) {
        EXPECT_EQ(tf.evaluate(nan).extinction, 0.0);
        EXPECT_EQ(extinction_at(tf.view(1.0, 0.0), nan), 0.0F);
        // Interpolating huge voxels overflows: empty too, and never NaN, which would spoil a pixel for good.
        EXPECT_EQ(extinction_at(tf.view(1.0, 0.0), inf), 0.0F);
        EXPECT_EQ(extinction_at(tf.view(1.0, 0.0), -inf), 0.0F);
        EXPECT_EQ(extinction_at(tf.view(1e30, 0.0), 3e38F), 0.0F);
        EXPECT_GT(extinction_at(tf.view(1.0, 0.0), 3e38F), 0.0F);
        EXPECT_GT(extinction_at(tf.view(1.0, 0.0), -3e38F), 0.0F);
    }
}

TEST(TransferFunctionTest, NoCancellationBelowZeroAndNoOverflow)
{
    // Near the end of a long falling flank rounding must not turn into negative extinction, which would amplify light.
    const TransferFunction falling({{-1e6, 1e6}, {0.001, 0.0}, {1.0, 0.0}});
    const TransferFunction third({{0.0, 1.0}, {3.0, 0.0}});
    for (int i = 0; i <= 3000; ++i) {
        EXPECT_GE(extinction_at(falling.view(1.0, 0.0), static_cast<float>(i) * 1e-6F - 0.001F), 0.0F);
        EXPECT_GE(extinction_at(third.view(1.0, 0.0), 3.0F - static_cast<float>(i) * 2.4e-7F), 0.0F);
    }
    // A flank too steep for single precision is a step.
    const TransferFunction steep({{0.0, 0.0}, {1e-20, 1e30}});
    for (const float v : {-1.0F, 0.0F, 5e-21F, 1e-20F, 1.0F}) {
        EXPECT_TRUE(std::isfinite(extinction_at(steep.view(1.0, 0.0), v))) << v;
        EXPECT_LE(extinction_at(steep.view(1.0, 0.0), v), 1.00001e30F) << v;
    }
}

TEST(TransferFunctionTest, MaximumOverIntervals)
{
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform;
    for (int repeat = 0; repeat < 200; ++repeat) {
        const Points points = random_points(random, 1 + static_cast<int>(random() % 20));
        const TransferFunction tf(points, 0.5);
        const double span = points.back().value - points.front().value + 2.0;
        const double low = points.front().value - 1.0 + span * uniform(random),
                     high = low + span * std::pow(uniform(random), 3.0);
        double dense = 0.0;
        for (int i = 0; i <= 2000; ++i)
            dense = std::max(dense, tf.evaluate(low + (high - low) * i / 2000.0).extinction);
        EXPECT_GE(tf.max_extinction(low, high), dense * (1.0 - 1e-12));
        double knots = dense;
        for (const TransferPoint& p : points)
            if (p.value >= low && p.value <= high)
                knots = std::max(knots, p.extinction * 0.5);
        EXPECT_LE(tf.max_extinction(low, high), knots * (1.0 + 1e-12)); // and tight
    }
    EXPECT_EQ(TransferFunction({{0.0, 3.0}}).max_extinction(1.0, -1.0), 0.0);
    const double inf = std::numeric_limits<double>::infinity();
    EXPECT_EQ(TransferFunction({{0.0, 3.0}, {1.0, 8.0}, {2.0, 1.0}}).max_extinction(-inf, inf), 8.0);
}

TEST(TransferFunctionTest, RefusesWithTheNameOfTheEntry)
{
    const double nan = std::nan("");
    const auto refuses = [](const Points& points, double scale, const std::string& name) {
        try {
            const TransferFunction tf(points, scale);
            ADD_FAILURE() << "accepted: " << name;
        } catch (const Error& e) {
            EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
        }
    };
    refuses({}, 1.0, "transfer_function.points");
    refuses({{0.0, 1.0}, {nan, 1.0}}, 1.0, "points[1].value");
    refuses({{0.0, 1.0}, {-1.0, 1.0}}, 1.0, "points[1].value");
    refuses({{0.0, -1.0}}, 1.0, "points[0].extinction");
    refuses({{0.0, nan}}, 1.0, "points[0].extinction");
    refuses({{0.0, 1.0, {0.0, 1.1, 0.0}}}, 1.0, "points[0].albedo");
    refuses({{0.0, 1.0, {0.0, 0.0, nan}}}, 1.0, "points[0].albedo");
    refuses({{0.0, 1.0}}, -1.0, "extinction_scale");
    refuses({{0.0, 1.0}}, nan, "extinction_scale");
    refuses({{0.0, 1e20}}, 1e20, "extinction");
    refuses(Points(70000), 1.0, "too many");
}

} // namespace
} // namespace lumisweep
