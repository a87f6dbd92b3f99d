// One sweep under measurement, and how benchmarks of volumes are run: named, on so many threads, where memory allows.
#pragma once

#include <functional>
#include <string>

#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include "lumisweep/visibility/settings.h"
#include "subject.h"

namespace lumisweep::bench {

struct SweepCase {
    int rays = 0, cell = 4;
    SweepFilter filter = SweepFilter::half_angle;
    int threads = 1;
    int oversampling = 1;
};

/// The filter, or the papers' alternative to it: averages over more directions.
std::string filter_name(const SweepCase& c);

/// The CPU time is that of the calling thread, so an arena of one thread runs everything on it.
template <class Work>
void run_with_threads(benchmark::State& state, int threads, Work&& work)
{
    tbb::task_arena arena(threads);
    for (auto _ : state)
        arena.execute(work);
}

/// Into the subject's grid of that cell size; leaves the sweep's own times and what it went through as counters.
void measure_sweep(benchmark::State& state, Subject& subject, const SweepCase& c);

/// Registers NAME/threads:N for a subject; skipped where there is not enough memory for it.
void add_benchmark(Subjects& subjects, const std::string& subject, const std::string& name, int threads,
                   int repetitions, std::function<void(benchmark::State&, Subject&)> body);

} // namespace lumisweep::bench
