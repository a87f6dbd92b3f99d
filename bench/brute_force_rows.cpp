#include "brute_force_rows.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "brute_force.h"

namespace lumisweep::bench {
namespace {

constexpr std::size_t row_block = 8; // rows of cells that brute force marches together

/// The rows (j, k) of cells that are marched: all of a small grid, else blocks of neighbours at random.
std::vector<int> rows_to_march(const VisibilityGrid& grid, double most_rays)
{
    const auto rows = static_cast<std::size_t>(grid.cells().y) * static_cast<std::size_t>(grid.cells().z);
    std::vector<int> chosen(rows);
    std::iota(chosen.begin(), chosen.end(), 0);
    const double rays_per_row = static_cast<double>(grid.cells().x) * grid.direction_count();
    if (static_cast<double>(rows) * rays_per_row <= 8.0 * most_rays)
        return chosen;
    std::vector<std::size_t> blocks(rows / row_block);
    std::iota(blocks.begin(), blocks.end(), std::size_t{0});
    std::shuffle(blocks.begin(), blocks.end(), std::mt19937_64(brute_force_seed));
    blocks.resize(static_cast<std::size_t>(most_rays / rays_per_row / row_block) + 1);
    chosen.clear();
    for (const std::size_t b : blocks)
        for (std::size_t row = 0; row < row_block; ++row)
            chosen.push_back(static_cast<int>(b * row_block + row));
    return chosen;
}

} // namespace

void march_brute_force(benchmark::State& state, Subject& subject, int cell, double most_rays)
{
    const VisibilityGrid& grid = subject.grid(cell);
    const Vec3i size = subject.volume().size(), cells = grid.cells();
    const Vec3d side{static_cast<double>(size.x) / cells.x, static_cast<double>(size.y) / cells.y,
                     static_cast<double>(size.z) / cells.z};
    const BruteForce marcher(subject.extinction(0), brute_force_kernels().front());
    const std::vector<int> rows = rows_to_march(grid, most_rays);
    std::vector<VisibilityQuery> queries;
    std::vector<float> v(static_cast<std::size_t>(cells.x) * row_block);
    std::vector<double> samples((rows.size() + row_block - 1) / row_block); // by block of rows
    for (auto _ : state) {
        std::fill(samples.begin(), samples.end(), 0.0);
        for (int d = 0; d < grid.direction_count(); ++d) {
            const Vec3d w_world = texel_direction(d, grid.directions_per_side());
            for (std::size_t b = 0; b < samples.size(); ++b) {
                queries.clear();
                for (std::size_t r = b * row_block; r < std::min((b + 1) * row_block, rows.size()); ++r)
                    for (int i = 0; i < cells.x; ++i)
                        queries.push_back(
                            {Vec3d{i + 0.5, rows[r] % cells.y + 0.5, rows[r] / cells.y + 0.5} * side, w_world});
                samples[b] += static_cast<double>(marcher.visibility(queries, v));
                benchmark::DoNotOptimize(v.data());
            }
        }
    }
    const MeanAndError per_block = mean_and_error(samples);
    const double blocks = static_cast<double>(samples.size());
    state.counters["cells_marched"] = static_cast<double>(rows.size()) * cells.x;
    state.counters["cells_total"] = static_cast<double>(grid.cell_count());
    state.counters["samples"] = per_block.mean * blocks;
    state.counters["relative_error"] =
        static_cast<double>(rows.size()) * cells.x < static_cast<double>(grid.cell_count())
            ? per_block.error / per_block.mean
            : 0.0;
    state.SetLabel(brute_force_kernels().front().name);
}

} // namespace lumisweep::bench
