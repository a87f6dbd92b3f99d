// Small convex polygons and cutting them by straight lines: all the geometry that exact resampling needs.
#pragma once

#include <array>
#include <cstddef>

namespace lumisweep {

struct Point2 {
    double x, y;
};

/// A convex polygon with its corners in counter-clockwise order; fewer than three corners mean no area.
/// A square between two pairs of lines has at most eight; the rest is room for what rounding may add to slivers.
struct ConvexPolygon {
    static constexpr int capacity = 16;
    std::array<Point2, capacity> corner;
    int size = 0;

    void add(const Point2& p)
    {
        if (size < capacity)
            corner[static_cast<std::size_t>(size++)] = p;
    }
    const Point2& operator[](int i) const { return corner[static_cast<std::size_t>(i)]; }
};

inline double area(const ConvexPolygon& polygon)
{
    double twice = 0.0;
    for (int i = 2; i < polygon.size; ++i) {
        const Point2 o = polygon[0], a = polygon[i - 1], b = polygon[i];
        twice += (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
    }
    return 0.5 * (twice > 0.0 ? twice : 0.0); // rounding may turn a sliver inside out
}

/// The line a x + b y + c = 0; its positive side is where the sum is positive.
struct Line2 {
    double a, b, c;
    double operator()(const Point2& p) const { return a * p.x + b * p.y + c; }
};

/// Cuts a polygon in two: the parts on the line's negative and positive side. Corners on the line go to both.
inline void cut(const ConvexPolygon& polygon, const Line2& line, ConvexPolygon& negative, ConvexPolygon& positive)
{
    negative.size = positive.size = 0;
    if (polygon.size == 0)
        return;
    Point2 previous = polygon[polygon.size - 1];
    double d_previous = line(previous);
    for (int i = 0; i < polygon.size; ++i) {
        const Point2 p = polygon[i];
        const double d = line(p);
        if ((d < 0.0 && d_previous > 0.0) || (d > 0.0 && d_previous < 0.0)) {
            const double t = d_previous / (d_previous - d);
            const Point2 crossing{previous.x + t * (p.x - previous.x), previous.y + t * (p.y - previous.y)};
            negative.add(crossing);
            positive.add(crossing);
        }
        if (d <= 0.0)
            negative.add(p);
        if (d >= 0.0)
            positive.add(p);
        previous = p;
        d_previous = d;
    }
}

} // namespace lumisweep
