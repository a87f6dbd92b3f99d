#include "lumisweep/math/octahedral.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lumisweep/math/trigonometry.h"

namespace lumisweep {
namespace {

template <class F>
Vec3d as_double(const Vec3<F>& w)
{
    return {static_cast<double>(w.x), static_cast<double>(w.y), static_cast<double>(w.z)};
}

/// Poles, axes, diagonals, octants, their neighbourhoods, and anything.
std::vector<Vec3d> directions()
{
    std::vector<Vec3d> all;
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
                if (x != 0 || y != 0 || z != 0)
                    for (const double off : {0.0, 1e-3, -1e-6})
                        all.push_back(normalized({x + off, y - 0.5 * off, z + 0.7 * off}));
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 20000; ++i)
        all.push_back(normalized({normal(random), normal(random), normal(random)}));
    return all;
}

/// The map from its definition: r = √(1 − |z|), v = r φ / (π/2) within the quadrant, folded outwards for z < 0.
UV<double> oct_by_definition(const Vec3d& w)
{
    const double r = std::sqrt((w.x * w.x + w.y * w.y) / (1.0 + std::abs(w.z)));
    const double t = std::atan2(std::abs(w.y), std::abs(w.x)) / (pi / 2);
    double u = r * (1 - t), v = r * t;
    if (w.z < 0) {
        const double folded = 1 - v;
        v = 1 - u;
        u = folded;
    }
    return {0.5 * (1 + std::copysign(u, w.x)), 0.5 * (1 + std::copysign(v, w.y))};
}

TEST(Octahedral, MatchesItsDefinition)
{
    for (const Vec3d& w : directions()) {
        const UV<double> expected = oct_by_definition(w), found = oct_from_direction(w);
        EXPECT_NEAR(found.u, expected.u, 1e-14);
        EXPECT_NEAR(found.v, expected.v, 1e-14);
        const UV<float> in_float = oct_from_direction(to_float(w));
        const UV<double> of_rounded = oct_by_definition(as_double(to_float(w)));
        EXPECT_NEAR(static_cast<double>(in_float.u), of_rounded.u, 4e-7);
        EXPECT_NEAR(static_cast<double>(in_float.v), of_rounded.v, 4e-7);
    }
}

TEST(Octahedral, DirectionsComeBack)
{
    for (const Vec3d& w : directions()) {
        EXPECT_LT(length(direction_from_oct(oct_from_direction(w)) - w), 3e-8) << w.x << ' ' << w.y << ' ' << w.z;
        const Vec3f f = direction_from_oct(oct_from_direction(to_float(w)));
        EXPECT_LT(length(as_double(f) - w), 3e-6) << w.x << ' ' << w.y << ' ' << w.z;
        EXPECT_NEAR(length(as_double(f)), 1.0, 4e-7);
    }
}

TEST(Octahedral, PointsComeBack)
{
    // Inside of the quadrants: on the map's outer edge a direction has two points.
    for (int i = 1; i < 200; ++i) {
        for (int j = 1; j < 200; ++j) {
            const UV<double> uv{i / 200.0, j / 200.0};
            const Vec3d w = direction_from_oct(uv);
            ASSERT_NEAR(length(w), 1.0, 1e-15);
            const UV<double> back = oct_from_direction(w);
            ASSERT_NEAR(back.u, uv.u, 1e-14);
            ASSERT_NEAR(back.v, uv.v, 1e-14);
            const UV<float> uv_float{static_cast<float>(uv.u), static_cast<float>(uv.v)};
            const UV<float> back_float = oct_from_direction(direction_from_oct(uv_float));
            ASSERT_NEAR(back_float.u, uv_float.u, 1e-6F) << i << ' ' << j;
            ASSERT_NEAR(back_float.v, uv_float.v, 1e-6F) << i << ' ' << j;
        }
    }
}

TEST(Octahedral, LandmarksAreWhereTheHeaderSays)
{
    const auto expect = [](const UV<double>& uv, const Vec3d& w) {
        EXPECT_LT(length(direction_from_oct(uv) - w), 1e-15) << uv.u << ' ' << uv.v;
        EXPECT_LT(
            length(as_double(direction_from_oct(UV<float>{static_cast<float>(uv.u), static_cast<float>(uv.v)})) - w),
            2e-7)
            << uv.u << ' ' << uv.v;
    };
    const double half = std::sqrt(0.5);
    expect({0.5, 0.5}, {0, 0, 1});
    for (const double u : {0.0, 1.0})
        for (const double v : {0.0, 1.0})
            expect({u, v}, {0, 0, -1});
    expect({1.0, 0.5}, {1, 0, 0});
    expect({0.0, 0.5}, {-1, 0, 0});
    expect({0.5, 1.0}, {0, 1, 0});
    expect({0.5, 0.0}, {0, -1, 0});
    expect({0.75, 0.75}, {half, half, 0});
    expect({0.25, 0.75}, {-half, half, 0});
}

TEST(Octahedral, EqualAreasHaveEqualSolidAngles)
{
    // The Jacobian |∂w/∂u × ∂w/∂v| by central differences is 4π everywhere off the creases of the map.
    constexpr double e = 1e-5;
    for (int i = 0; i < 97; ++i) {
        for (int j = 0; j < 101; ++j) {
            const double u = (i + 0.37) / 97, v = (j + 0.41) / 101;
            const double au = std::abs(2 * u - 1), av = std::abs(2 * v - 1);
            if (au < 1e-3 || av < 1e-3 || std::abs(au + av - 1) < 1e-3)
                continue;
            const auto at = [](double a, double b) { return direction_from_oct(UV<double>{a, b}); };
            const Vec3d du = (at(u + e, v) - at(u - e, v)) * (0.5 / e), dv = (at(u, v + e) - at(u, v - e)) * (0.5 / e);
            const Vec3d normal = cross(du, dv);
            ASSERT_NEAR(dot(normal, at(u, v)), 4 * pi, 4 * pi * 1e-5) << u << ' ' << v; // and the orientation is kept
        }
    }
}

TEST(Octahedral, QuadratureOverTheSquareIntegratesTheSphere)
{
    // Means over the sphere: zⁿ has 1/(n + 1) for even n, 0 for odd, and x² y² 1/15.
    constexpr int n = 512;
    double one_moment = 0, square = 0, fourth = 0, mixed = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const Vec3d w = direction_from_oct(UV<double>{(i + 0.5) / n, (j + 0.5) / n});
            one_moment += w.x + 2 * w.y + 3 * w.z;
            square += w.z * w.z + 10 * w.x * w.x + 100 * w.y * w.y;
            fourth += std::pow(w.z, 4);
            mixed += w.x * w.x * w.y * w.y;
        }
    }
    EXPECT_NEAR(one_moment / n / n, 0.0, 1e-12);
    EXPECT_NEAR(square / n / n, 111.0 / 3, 2e-3);
    EXPECT_NEAR(fourth / n / n, 0.2, 2e-5);
    EXPECT_NEAR(mixed / n / n, 1.0 / 15, 2e-5);
}

TEST(Trigonometry, FloatPolynomialsKeepTheirPromises)
{
    double sin_error = 0, cos_error = 0, atan_error = 0;
    constexpr int n = 1 << 20;
    for (int i = 0; i <= n; ++i) {
        const float x = static_cast<float>((2.0 * i / n - 1.0) * pi / 4);
        const SinCos<float> sc = sincos_eighth(x);
        sin_error = std::max(sin_error, std::abs(double{sc.sin} - std::sin(double{x})));
        cos_error = std::max(cos_error, std::abs(double{sc.cos} - std::cos(double{x})));
        const float a = static_cast<float>(i) / n;
        atan_error = std::max(atan_error, std::abs(double{atan_unit(a)} - std::atan(double{a})));
    }
    EXPECT_LT(sin_error, 1e-7);
    EXPECT_LT(cos_error, 1.2e-7);
    EXPECT_LT(atan_error, 3e-7);
    std::printf("largest errors: sin %.2e, cos %.2e, atan %.2e\n", sin_error, cos_error, atan_error);
    EXPECT_EQ(sincos_eighth(0.3).sin, std::sin(0.3));
    EXPECT_EQ(atan_unit(0.3), std::atan(0.3));
}

} // namespace
} // namespace lumisweep
