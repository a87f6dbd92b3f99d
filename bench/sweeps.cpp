#include "sweeps.h"

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "brute_force_rows.h"
#include "lumisweep/sampling/joint_grid.h"
#include "sweep_case.h"

namespace lumisweep::bench {
namespace {

struct Plan {
    std::string subject;
    std::vector<SweepCase> sweeps;
    std::vector<int> mip_levels, product_cells, brute_force_cells;
    std::vector<int> thread_counts{1, 2}; ///< of preparation and product
    int repetitions = 3;
    int positions = 0;             ///< at which errors are taken; 0: no errors
    double brute_force_rays = 0.0; ///< about as many are marched, or all if the grid has up to eight times as many
};

void sweep(benchmark::State& state, Subject& subject, const Plan& plan, const SweepCase& c)
{
    measure_sweep(state, subject, c);
    if (plan.positions > 0 && c.threads == 1) {
        const GridErrors errors = errors_of(subject.grid(c.cell), subject.references(c.cell, plan.positions));
        state.counters["rms"] = errors.rms;
        state.counters["rms_error"] = errors.rms_error;
        state.counters["rms_averaged"] = errors.rms_averaged;
        state.counters["rms_averaged_error"] = errors.rms_averaged_error;
    }
}

/// What a change of the transfer function costs before the first sweep: into the memory of before.
void prepare(benchmark::State& state, Subject& subject, int mip_level, ExtinctionLayouts layouts, int threads)
{
    ExtinctionGrid extinction;
    subject.classify_again(extinction, mip_level, layouts);
    run_with_threads(state, threads, [&] { subject.classify_again(extinction, mip_level, layouts); });
    state.counters["volume_bytes"] = static_cast<double>(subject.volume().bytes());
    state.counters["extinction_bytes"] = static_cast<double>(extinction.bytes());
}

/// Visibility times light with its averages, as a change of the light alone costs. A second time, like preparation
/// above: the first also takes memory from the system.
void product(benchmark::State& state, Subject& subject, int cell, int threads)
{
    const VisibilityGrid& grid = subject.grid(cell);
    const Environment light = Environment::constant({1.0, 0.9, 0.8});
    JointGrid joint;
    const auto build = [&] {
        joint.build(grid, subject.volume().size(), light, JointFactor::visibility_times_light,
                    VisibilitySettings{}.epsilon);
    };
    build();
    run_with_threads(state, threads, build);
    state.counters["grid_bytes"] = static_cast<double>(grid.bytes());
    state.counters["joint_bytes"] = static_cast<double>(joint.bytes());
}

void register_plan(Subjects& subjects, const Plan& plan)
{
    const auto add = [&](const std::string& name, int threads, int repetitions, auto body) {
        add_benchmark(subjects, plan.subject, name, threads, repetitions, body);
    };
    for (const int mip_level : plan.mip_levels)
        for (const auto& [layouts, name] : {std::pair{ExtinctionLayouts::straight, "straight"},
                                            std::pair{ExtinctionLayouts::with_transposed, "both"}})
            for (const int threads : plan.thread_counts)
                add(fmt::format("prepare/{}/mip:{}/layouts:{}", plan.subject, mip_level, name), threads,
                    plan.repetitions + 2,
                    [mip_level, layouts = layouts, threads](benchmark::State& state, Subject& subject) {
                        prepare(state, subject, mip_level, layouts, threads);
                    });
    for (const SweepCase& c : plan.sweeps)
        add(fmt::format("sweep/{}/rays:{}/cell:{}/filter:{}", plan.subject, c.rays, c.cell, filter_name(c)), c.threads,
            c.cell > 2 ? plan.repetitions : 1 + plan.repetitions / 2,
            [plan, c](benchmark::State& state, Subject& subject) { sweep(state, subject, plan, c); });
    for (const int cell : plan.product_cells)
        for (const int threads : plan.thread_counts)
            add(fmt::format("product/{}/cell:{}", plan.subject, cell), threads, plan.repetitions,
                [cell, threads](benchmark::State& state, Subject& subject) { product(state, subject, cell, threads); });
    for (const int cell : plan.brute_force_cells)
        add(fmt::format("brute_force/{}/cell:{}", plan.subject, cell), 1, 1,
            [cell, rays = plan.brute_force_rays](benchmark::State& state, Subject& subject) {
                march_brute_force(state, subject, cell, rays);
            });
}

using Filters = std::initializer_list<SweepFilter>;
constexpr Filters plain_and_filtered{SweepFilter::none, SweepFilter::half_angle};

/// Cells outermost: the grid of one size is made once.
void add_sweeps(Plan& plan, std::initializer_list<int> cells, std::initializer_list<int> rays, Filters filters,
                int threads)
{
    for (const int cell : cells)
        for (const int r : rays)
            for (const SweepFilter filter : filters)
                plan.sweeps.push_back({r, cell, filter, threads});
}

/// The papers' alternative to filtering.
void add_oversampled(Plan& plan, std::initializer_list<int> rays)
{
    for (const int r : rays)
        plan.sweeps.push_back({r, 8, SweepFilter::none, 1, 4});
}

} // namespace

void register_sweeps(Subjects& subjects, const std::filesystem::path& data, bool quick)
{
    constexpr std::uint64_t gigabyte = 1000000000;
    const Vec3i size = quick ? Vec3i{64, 64, 57} : Vec3i{512, 512, 460};
    const std::uint64_t memory = quick ? 0 : 3 * gigabyte;
    subjects.add("ct", memory, [size] { return ct_like(size); });
    subjects.add("smoke", memory, [size] { return smoke_like(size); });
    subjects.add("ct-doubled", 2 * memory, [size] { return doubled(ct_like(size)); });
    const bool real = !quick && std::filesystem::exists(data / "ch2better.nii.gz");
    if (real)
        subjects.add("ch2better", memory, [data] { return ch2better(data).value(); });

    Plan ct;
    ct.subject = "ct";
    ct.positions = quick ? 16 : 256;
    ct.repetitions = quick ? 1 : 3;
    ct.brute_force_rays = quick ? 4e5 : 4e6;
    Plan smoke = ct, ch2 = ct, large = ct;
    if (quick) {
        ct.mip_levels = {0, 1};
        ct.product_cells = ct.brute_force_cells = {4, 8};
        add_sweeps(ct, {2, 4, 8, 16}, {64, 32, 16}, plain_and_filtered, 1);
        add_sweeps(ct, {4, 8}, {64, 32}, {SweepFilter::half_angle}, 2);
        add_oversampled(ct, {64, 32});
    } else {
        // The journal paper's Table 1.
        ct.mip_levels = {0, 1, 2};
        ct.product_cells = {4, 8, 16};
        ct.brute_force_cells = {2, 4, 8, 16};
        add_sweeps(ct, {2, 4, 8, 16}, {512, 256, 128, 64, 32, 16}, plain_and_filtered, 1);
        add_sweeps(ct, {4, 8}, {512, 256}, {SweepFilter::half_angle}, 2);
        add_oversampled(ct, {512, 256});
    }
    register_plan(subjects, ct);

    smoke.subject = "smoke";
    smoke.mip_levels = {0, 1};
    smoke.brute_force_cells = {4, 8};
    add_sweeps(smoke, {4, 8}, quick ? std::initializer_list<int>{64, 32} : std::initializer_list<int>{512, 256, 128},
               plain_and_filtered, 1);
    if (!quick)
        add_oversampled(smoke, {512, 256});
    register_plan(subjects, smoke);

    if (real) {
        ch2.subject = "ch2better";
        ch2.mip_levels = {0, 1};
        ch2.brute_force_cells = {4, 8};
        add_sweeps(ch2, {4, 8}, {512, 256, 128}, plain_and_filtered, 1);
        add_oversampled(ch2, {512, 256});
        register_plan(subjects, ch2);
    }

    large.subject = "ct-doubled";
    large.mip_levels = {0, 1};
    large.thread_counts = {1};
    large.repetitions = quick ? 1 : 2;
    register_plan(subjects, large);
}

} // namespace lumisweep::bench
