// Rays that come in or go out through the box's sides, and symmetries that no axis or sense may break.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "generated_volumes.h"
#include "lumisweep/visibility/brute_force.h"
#include "lumisweep/visibility/sweep.h"
#include "stored_voxels.h"

namespace lumisweep {
namespace {

using namespace test;

constexpr int directions = 8;

VisibilityGrid swept(const ExtinctionGrid& extinction, int cell)
{
    VisibilitySettings settings;
    settings.directions = directions;
    settings.cell = cell;
    settings.rays = 8192;
    settings.filter = SweepFilter::none;
    VisibilityGrid grid(extinction.volume_size, cell, directions);
    sweep_visibility(grid, extinction, settings);
    return grid;
}

struct Error {
    double rms = 0.0, max = 0.0;
};

/// `a` at a direction and cell against `b` at where `place` takes them.
template <class Direction, class Cell>
Error difference(const VisibilityGrid& a, const VisibilityGrid& b, Direction&& direction, Cell&& cell)
{
    Error error;
    const Vec3i cells = a.cells();
    for (int d = 0; d < a.direction_count(); ++d) {
        const std::uint8_t* other = b.direction(direction(d));
        for (int k = 0; k < cells.z; ++k)
            for (int j = 0; j < cells.y; ++j)
                for (int i = 0; i < cells.x; ++i) {
                    const Vec3i at = cell(Vec3i{i, j, k});
                    const double e =
                        (a.direction(d)[a.cell_index(i, j, k)] - other[b.cell_index(at.x, at.y, at.z)]) / 255.0;
                    error.rms += e * e;
                    error.max = std::max(error.max, std::fabs(e));
                }
    }
    error.rms = std::sqrt(error.rms / (static_cast<double>(a.cell_count()) * a.direction_count()));
    return error;
}

Error against_brute_force(const ExtinctionGrid& extinction, int cell)
{
    return difference(
        swept(extinction, cell), brute_force_visibility(extinction, cell, directions), [](int d) { return d; },
        [](const Vec3i& c) { return c; });
}

/// Dense inside of [low, high), in parts of the box.
ExtinctionGrid block(Vec3i size, const Affine3d& world_from_voxel, const Vec3d& low, const Vec3d& high)
{
    const ScalarGrid volume = fill_i16(size, world_from_voxel, [&](double i, double j, double k) {
        const Vec3d p{i / size.x, j / size.y, k / size.z};
        const bool inside = p.x > low.x && p.x < high.x && p.y > low.y && p.y < high.y && p.z > low.z && p.z < high.z;
        return inside ? 1000.0 : 0.0;
    });
    return classified(volume, TransferFunction({{0.0, 0.0}, {1000.0, 0.15}}));
}

TEST(SweepSides, BlocksThatTouchASide)
{
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high_side : {false, true}) {
            Vec3d low{0.0, 0.0, 0.0}, high{1.0, 1.0, 1.0};
            double& bound = axis == 0   ? (high_side ? low.x : high.x)
                            : axis == 1 ? (high_side ? low.y : high.y)
                                        : (high_side ? low.z : high.z);
            bound = high_side ? 0.7 : 0.3;
            for (const Affine3d& world : {Affine3d{}, spaced({0.7, 1.0, 1.6}), oblique()}) {
                const Error e = against_brute_force(block({22, 19, 24}, world, low, high), 3);
                std::printf("face %d %d rms %.4f max %.4f\n", axis, high_side, e.rms, e.max);
            }
        }
}

TEST(SweepSides, BlocksThatFillACorner)
{
    for (int corner = 0; corner < 8; ++corner) {
        const auto low = [&](int bit) { return (corner >> bit & 1) != 0 ? 0.55 : 0.0; };
        const auto high = [&](int bit) { return (corner >> bit & 1) != 0 ? 1.0 : 0.45; };
        const ExtinctionGrid e = block({20, 23, 18}, corner % 2 == 0 ? Affine3d{} : spaced({1.3, 0.8, 1.0}),
                                       {low(0), low(1), low(2)}, {high(0), high(1), high(2)});
        const Error x = against_brute_force(e, 3);
        std::printf("corner %d rms %.4f max %.4f\n", corner, x.rms, x.max);
    }
}

/// The texel whose centre is `map` of that of d.
template <class Map>
int mapped(int d, Map&& map)
{
    const Vec3d w = map(texel_direction(d, directions));
    for (int other = 0; other < directions * directions; ++other)
        if (dot(w, texel_direction(other, directions)) > 1.0 - 1e-9)
            return other;
    return -1;
}

TEST(SweepSides, MirroredVolumesHaveMirroredVisibility)
{
    const Vec3i size{26, 23, 21};
    const ExtinctionGrid ct = classified(ct_like(size, spaced({1.0, 1.2, 0.9})), bone());
    const VisibilityGrid grid = swept(ct, 3);
    // Each of the three axes, and all of them: then every direction becomes its opposite.
    for (int mirrored = 1; mirrored < 8; ++mirrored) {
        const auto mirror = [&](const Vec3i& at, const Vec3i& count) {
            return Vec3i{(mirrored & 1) != 0 ? count.x - 1 - at.x : at.x,
                         (mirrored & 2) != 0 ? count.y - 1 - at.y : at.y,
                         (mirrored & 4) != 0 ? count.z - 1 - at.z : at.z};
        };
        ExtinctionGrid other;
        other.volume_size = other.size = size;
        other.world_from_voxel = ct.world_from_voxel;
        other.scale = ct.scale;
        store_voxels(other, FilledIn::lines, [&](int i, int j, int k) {
            const Vec3i from = mirror({i, j, k}, size);
            return ct.stored[static_cast<std::size_t>((from.z * size.y + from.y) * size.x + from.x)];
        });
        const VisibilityGrid mirrored_grid = swept(other, 3);
        const Error e = difference(
            grid, mirrored_grid,
            [&](int d) {
                return mapped(d, [&](const Vec3d& w) {
                    return Vec3d{(mirrored & 1) != 0 ? -w.x : w.x, (mirrored & 2) != 0 ? -w.y : w.y,
                                 (mirrored & 4) != 0 ? -w.z : w.z};
                });
            },
            [&](const Vec3i& at) { return mirror(at, grid.cells()); });
        std::printf("mirror %d rms %.4f max %.4f\n", mirrored, e.rms, e.max);
    }
}

} // namespace
} // namespace lumisweep
