// The benchmarks of the visibility grid, by volume.
#pragma once

#include <filesystem>

#include "subject.h"

namespace lumisweep::bench {

/// Registers, for every volume: "prepare/…" (classification and layouts), "sweep/…", "product/…", "brute_force/…".
/// `quick` takes small volumes, few sizes and one repetition. `subjects` must live until the benchmarks have run.
void register_sweeps(Subjects& subjects, const std::filesystem::path& data, bool quick);

} // namespace lumisweep::bench
