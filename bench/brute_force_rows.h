// Brute force over a visibility grid, or over as many rows of its cells as there is time for.
#pragma once

#include <benchmark/benchmark.h>

#include "subject.h"

namespace lumisweep::bench {

/// On one core: about `most_rays` rays, or all where the grid has up to eight times as many. What the whole grid takes
/// is cpu_time · cells_total / cells_marched, give or take relative_error.
void march_brute_force(benchmark::State& state, Subject& subject, int cell, double most_rays);

} // namespace lumisweep::bench
