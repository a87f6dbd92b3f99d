#include "table_2.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "sweep_case.h"

namespace lumisweep::bench {
namespace {

enum class Kind { solid, smoke };

/// The paper's own volumes are not to be had: ours are generated ones of the same size and kind.
struct PaperVolume {
    const char* name;
    Vec3i size;
    Kind kind;
    bool costly_too = false; ///< alternatives to the filter also where they take seconds
};

constexpr std::array<PaperVolume, 6> paper_volumes{{{"engine", {256, 256, 128}, Kind::solid},
                                                    {"fluid", {256, 256, 256}, Kind::smoke},
                                                    {"smoke", {384, 384, 512}, Kind::smoke, true},
                                                    {"backpack", {512, 512, 373}, Kind::solid},
                                                    {"statue", {535, 342, 690}, Kind::solid},
                                                    {"manix", {512, 512, 460}, Kind::solid, true}}};

struct Column {
    int rays, repetitions;
    bool costly = false;
};
constexpr std::array<Column, 3> columns{{{256, 7}, {512, 5}, {1024, 3, true}}};
constexpr int voxels_per_cell = 8, oversampled_repetitions = 2;

Specimen make(const PaperVolume& volume, int doublings)
{
    Specimen specimen = volume.kind == Kind::solid ? ct_like(volume.size) : smoke_like(volume.size);
    for (int i = 0; i < doublings; ++i)
        specimen = doubled(specimen);
    return specimen;
}

/// Voxels, extinction of all levels, and what a sweep takes besides.
std::uint64_t memory_of(Vec3i size, int doublings)
{
    const Vec3i fine{size.x << doublings, size.y << doublings, size.z << doublings};
    const auto voxels =
        static_cast<std::uint64_t>(fine.x) * static_cast<std::uint64_t>(fine.y) * static_cast<std::uint64_t>(fine.z);
    const std::uint64_t sweep = std::uint64_t{512} << 20;
    return voxels * 2 + ExtinctionGrid::bytes_needed(fine) * 5 / 4 + sweep;
}

void register_column(Subjects& subjects, const PaperVolume& volume, const Column& column)
{
    const Resolution at = nearest_resolution(volume.size, column.rays);
    const std::string subject = fmt::format("table2/{}/{}x", volume.name, 1 << at.doublings);
    subjects.add(subject, memory_of(volume.size, at.doublings),
                 [volume, doublings = at.doublings] { return make(volume, doublings); });
    const auto add = [&](SweepFilter filter, int oversampling) {
        // As many cells as the volume that was not doubled has.
        const SweepCase c{at.rays, voxels_per_cell << at.doublings, filter, 1, oversampling};
        add_benchmark(subjects, subject,
                      fmt::format("table2/{}/rays:{}/filter:{}", volume.name, column.rays, filter_name(c)), c.threads,
                      1, [c](benchmark::State& state, Subject& found) { measure_sweep(state, found, c); });
    };
    // By turns, as what the filter adds is less than what other work on the machine does to seconds in a row.
    for (int i = 0; i < column.repetitions; ++i) {
        add(SweepFilter::none, 1);
        add(SweepFilter::half_angle, 1);
    }
    if (column.costly && !volume.costly_too)
        return;
    for (int i = 0; i < column.repetitions; ++i)
        add(SweepFilter::full_angle, 1);
    for (int i = 0; i < oversampled_repetitions; ++i)
        add(SweepFilter::none, 4);
}

} // namespace

Resolution nearest_resolution(Vec3i size, int wanted)
{
    const auto ratio = [wanted](int rays) { return std::fabs(std::log(static_cast<double>(rays) / wanted)); };
    Resolution nearest{0, std::max({size.x, size.y, size.z})};
    for (int rays = 2 * nearest.rays, doublings = 1; ratio(rays) < ratio(nearest.rays); rays *= 2, ++doublings)
        nearest = {doublings, rays};
    while (nearest.doublings == 0 && ratio((nearest.rays + 1) / 2) < ratio(nearest.rays))
        nearest.rays = (nearest.rays + 1) / 2;
    return nearest;
}

void register_table_2(Subjects& subjects, bool quick)
{
    const auto eighth = [](int x) { return (x + 4) / 8; };
    for (PaperVolume volume : paper_volumes) {
        if (quick)
            volume.size = {eighth(volume.size.x), eighth(volume.size.y), eighth(volume.size.z)};
        for (const Column& column : columns)
            register_column(subjects, volume, quick ? Column{eighth(column.rays), 1, column.costly} : column);
    }
}

} // namespace lumisweep::bench
