#include "references.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include "brute_force.h"
#include "lumisweep/base/parallel.h"
#include "lumisweep/math/morton.h"
#include "lumisweep/math/octahedral.h"
#include "lumisweep/visibility/brute_force.h"

namespace lumisweep::bench {
namespace {

constexpr int strata = 8, rays = strata * strata * strata;

double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Positions in 8³ strata of the cell, each with one of 16 × 32 strata of the texel, paired at random.
void jittered(const Vec3d& corner, const Vec3d& side, int direction, int directions_per_side, std::mt19937_64& random,
              std::span<VisibilityQuery> queries)
{
    std::vector<int> order(rays);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    const TexelXY<std::int32_t> texel = morton_decode<std::int32_t>(direction);
    for (int s = 0; s < rays; ++s) {
        const Vec3d at{s % strata + uniform(random), s / strata % strata + uniform(random),
                       s / strata / strata + uniform(random)};
        const int d = order[static_cast<std::size_t>(s)];
        const double u = (d % 16 + uniform(random)) / 16.0, v = (d / 16 + uniform(random)) / 32.0;
        queries[static_cast<std::size_t>(s)] = {
            corner + at * (1.0 / strata) * side,
            direction_from_oct(UV<double>{(texel.x + u) / directions_per_side, (texel.y + v) / directions_per_side})};
    }
}

/// √m and its standard error: d√m = dm / 2√m.
std::pair<double, double> root(const MeanAndError& m)
{
    return {std::sqrt(m.mean), m.mean > 0.0 ? 0.5 * m.error / std::sqrt(m.mean) : 0.0};
}

} // namespace

MeanAndError mean_and_error(std::span<const double> values)
{
    const double count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    double squares = 0.0;
    for (const double x : values)
        squares += (x - mean) * (x - mean);
    return {mean, count > 1.0 ? std::sqrt(squares / (count - 1.0) / count) : 0.0};
}

References make_references(const ExtinctionGrid& extinction, const VisibilityGrid& grid, int positions,
                           std::uint64_t seed)
{
    const Vec3i size = extinction.size, cells = grid.cells();
    const Vec3d side{static_cast<double>(size.x) / cells.x, static_cast<double>(size.y) / cells.y,
                     static_cast<double>(size.z) / cells.z};
    const auto directions = static_cast<std::size_t>(grid.direction_count());
    References references;
    references.cells.resize(static_cast<std::size_t>(positions));
    references.exact.resize(references.cells.size() * directions);
    references.averaged.resize(references.exact.size());
    const BruteForce brute_force(extinction, brute_force_kernels().front());
    parallel_for(std::size_t{0}, references.cells.size(), [&](std::size_t c) {
        std::mt19937_64 random(seed + c * 0x9e3779b97f4a7c15ULL);
        Vec3i& cell = references.cells[c];
        cell.x = static_cast<int>(uniform(random) * cells.x);
        cell.y = static_cast<int>(uniform(random) * cells.y);
        cell.z = static_cast<int>(uniform(random) * cells.z);
        const Vec3d corner =
            Vec3d{static_cast<double>(cell.x), static_cast<double>(cell.y), static_cast<double>(cell.z)} * side;
        std::vector<VisibilityQuery> queries(rays);
        std::vector<float> v(rays);
        for (std::size_t d = 0; d < directions; ++d) {
            const int direction = static_cast<int>(d), n = grid.directions_per_side();
            references.exact[c * directions + d] = static_cast<float>(
                transmittance_classified(extinction, corner + side * 0.5, texel_direction(direction, n)));
            jittered(corner, side, direction, n, random, queries);
            brute_force.visibility(queries, v);
            references.averaged[c * directions + d] =
                std::accumulate(v.begin(), v.end(), 0.0F) / static_cast<float>(rays);
        }
    });
    return references;
}

GridErrors errors_of(const VisibilityGrid& grid, const References& references)
{
    const int directions = grid.direction_count();
    std::vector<double> exact, averaged; // mean squares by cell
    for (std::size_t c = 0; c < references.cells.size(); ++c) {
        const Vec3i& cell = references.cells[c];
        double squares = 0.0, squares_averaged = 0.0;
        for (int d = 0; d < directions; ++d) {
            const double v = grid.direction(d)[grid.cell_index(cell.x, cell.y, cell.z)] / 255.0;
            const std::size_t at = c * static_cast<std::size_t>(directions) + static_cast<std::size_t>(d);
            const double e = v - static_cast<double>(references.exact[at]);
            const double e_averaged = v - static_cast<double>(references.averaged[at]);
            squares += e * e;
            squares_averaged += e_averaged * e_averaged;
        }
        exact.push_back(squares / directions);
        averaged.push_back(squares_averaged / directions);
    }
    const auto [rms, rms_error] = root(mean_and_error(exact));
    const auto [rms_averaged, rms_averaged_error] = root(mean_and_error(averaged));
    return {rms, rms_error, rms_averaged, rms_averaged_error};
}

} // namespace lumisweep::bench
