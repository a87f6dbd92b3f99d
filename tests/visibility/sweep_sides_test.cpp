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
    double squares = 0.0, rms = 0.0, max = 0.0;
};

/// `a` in direction d against `b` in another, at the cells where `place` takes those of a.
template <class Place>
Error difference(const VisibilityGrid& a, const VisibilityGrid& b, int d, int other, Place&& place)
{
    Error error;
    const Vec3i cells = a.cells();
    for (int k = 0; k < cells.z; ++k)
        for (int j = 0; j < cells.y; ++j)
            for (int i = 0; i < cells.x; ++i) {
                const Vec3i at = place(Vec3i{i, j, k});
                const int v = a.direction(d)[a.cell_index(i, j, k)],
                          expected = b.direction(other)[b.cell_index(at.x, at.y, at.z)];
                const double e = (v - expected) / 255.0;
                error.squares += e * e;
                error.max = std::max(error.max, std::fabs(e));
            }
    return error;
}

Error against_brute_force(const ExtinctionGrid& extinction, int cell)
{
    const VisibilityGrid grid = swept(extinction, cell), exact = brute_force_visibility(extinction, cell, directions);
    Error error;
    for (int d = 0; d < grid.direction_count(); ++d) {
        const Error e = difference(grid, exact, d, d, [](const Vec3i& at) { return at; });
        error.rms += e.squares;
        error.max = std::max(error.max, e.max);
    }
    error.rms = std::sqrt(error.rms / (static_cast<double>(grid.cell_count()) * grid.direction_count()));
    return error;
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
    // A block's face blurs over the two rays beside it; rays that came the wrong way would miss by 0.1 and more.
    for (int axis = 0; axis < 3; ++axis)
        for (const bool high_side : {false, true})
            for (const Affine3d& world : {Affine3d{}, spaced({0.7, 1.0, 1.6}), oblique()}) {
                const auto low = [&](int a) { return a == axis && high_side ? 0.7 : 0.0; };
                const auto high = [&](int a) { return a == axis && !high_side ? 0.3 : 1.0; };
                const Error error = against_brute_force(
                    block({22, 19, 24}, world, {low(0), low(1), low(2)}, {high(0), high(1), high(2)}), 3);
                EXPECT_LE(error.rms, 0.0165) << "axis " << axis << ", high side " << high_side;
                EXPECT_LE(error.max, 0.29) << "axis " << axis << ", high side " << high_side;
            }
}

TEST(SweepSides, BlocksThatFillACorner)
{
    for (int corner = 0; corner < 8; ++corner) {
        const auto low = [&](int axis) { return (corner >> axis & 1) != 0 ? 0.55 : 0.0; };
        const auto high = [&](int axis) { return (corner >> axis & 1) != 0 ? 1.0 : 0.45; };
        const Error error =
            against_brute_force(block({20, 23, 18}, corner % 2 == 0 ? Affine3d{} : spaced({1.3, 0.8, 1.0}),
                                      {low(0), low(1), low(2)}, {high(0), high(1), high(2)}),
                                3);
        EXPECT_LE(error.rms, 0.0118) << corner;
        EXPECT_LE(error.max, 0.21) << corner;
    }
}

/// The texel whose centre is mirrored.
int mirrored_texel(int d, int axes)
{
    Vec3d w = texel_direction(d, directions);
    w = {(axes & 1) != 0 ? -w.x : w.x, (axes & 2) != 0 ? -w.y : w.y, (axes & 4) != 0 ? -w.z : w.z};
    for (int other = 0; other < directions * directions; ++other)
        if (dot(w, texel_direction(other, directions)) > 1.0 - 1e-9)
            return other;
    return -1;
}

Vec3i mirrored_place(const Vec3i& at, const Vec3i& count, int axes)
{
    return {(axes & 1) != 0 ? count.x - 1 - at.x : at.x, (axes & 2) != 0 ? count.y - 1 - at.y : at.y,
            (axes & 4) != 0 ? count.z - 1 - at.z : at.z};
}

/// Largest difference between V of `grid` and V of the volume mirrored along `axes`, over the directions chosen.
template <class Chosen>
double mirror_error(const ExtinctionGrid& volume, int axes, Chosen&& chosen)
{
    ExtinctionGrid other;
    const Vec3i size = volume.size;
    other.volume_size = other.size = size;
    other.world_from_voxel = volume.world_from_voxel;
    other.scale = volume.scale;
    store_voxels(other, FilledIn::lines, [&](int i, int j, int k) {
        const Vec3i from = mirrored_place({i, j, k}, size, axes);
        return volume.stored[static_cast<std::size_t>((from.z * size.y + from.y) * size.x + from.x)];
    });
    const VisibilityGrid grid = swept(volume, 3), mirrored = swept(other, 3);
    double worst = 0.0;
    for (int d = 0; d < grid.direction_count(); ++d)
        if (chosen(d))
            worst = std::max(worst, difference(grid, mirrored, d, mirrored_texel(d, axes), [&](const Vec3i& at) {
                                        return mirrored_place(at, grid.cells(), axes);
                                    }).max);
    return worst;
}

TEST(SweepSides, MirroredAcrossTheSweepsAxisAllStays)
{
    // Rays are at voxel centres on the start face, whichever way they lean; only weights round differently.
    const ExtinctionGrid ct = classified(ct_volume({26, 23, 21}, spaced({1.0, 1.2, 0.9})), bone());
    const Affine3d voxel_from_world = inverse(ct.world_from_voxel);
    for (int axes = 1; axes < 7; ++axes) {
        const double e = mirror_error(ct, axes, [&](int d) {
            const Vec3d w = voxel_from_world.vector(texel_direction(d, directions));
            const double x = std::fabs(w.x), y = std::fabs(w.y), z = std::fabs(w.z);
            const int along = x > y && x > z ? 1 : y > z ? 2 : 4;
            return (along & axes) == 0;
        });
        EXPECT_LE(e, 1.001 / 255.0) << "mirrored axes " << axes;
    }
}

TEST(SweepSides, MirroredVolumesHaveMirroredVisibility)
{
    // Along the sweep's axis too, where rays then start at the other face; along all axes every direction becomes its
    // opposite, which comes out of the same march as a difference.
    const ExtinctionGrid smoky = classified(smoke_volume({26, 23, 21}, spaced({1.0, 1.2, 0.9})), smoke());
    for (int axes = 1; axes < 8; ++axes)
        EXPECT_LE(mirror_error(smoky, axes, [](int) { return true; }), 0.02) << "mirrored axes " << axes;
}

} // namespace
} // namespace lumisweep
