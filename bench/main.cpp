// lumisweep_bench [--quick] [--transmittance] [--data DIR] [Google Benchmark's options]: studies/sweeps.py,
// studies/paths.py and studies/transmittance.py run it and write the reports.
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <benchmark/benchmark.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "brute_force.h"
#include "lumisweep/base/error.h"
#include "machine.h"
#include "paths.h"
#include "subject.h"
#include "sweeps.h"
#include "table_2.h"
#include "transmittance.h"

namespace {

/// The working memory of sweeps and the like stays with the program. Whether the allocator gives it back after each, to
/// take it anew page by page, would else depend on what ran before: by a quarter of a sweep's time.
void keep_freed_memory()
{
#if defined(__GLIBC__)
    mallopt(M_MMAP_THRESHOLD, 32 << 20); // the largest that it allows
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

int run(int argc, char** argv)
{
    using namespace lumisweep;
    bool quick = false, transmittance = false;
    std::filesystem::path data = LUMISWEEP_FETCHED_DATA;
    std::vector<char*> others;
    for (int i = 0; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if (argument == "--quick")
            quick = true;
        else if (argument == "--transmittance")
            transmittance = true;
        else if (argument == "--data" && i + 1 < argc)
            data = argv[++i];
        else
            others.push_back(argv[i]);
    }
    keep_freed_memory();
    int count = static_cast<int>(others.size());
    others.push_back(nullptr);
    benchmark::Initialize(&count, others.data());
    if (benchmark::ReportUnrecognizedArguments(count, others.data()))
        return 2;
    benchmark::AddCustomContext("lumisweep_build", LUMISWEEP_BUILD_TYPE);
    benchmark::AddCustomContext("instruction_set", bench::machine_kernels().front().name);
    benchmark::AddCustomContext("reference_seed", std::to_string(bench::reference_seed));
    benchmark::AddCustomContext("brute_force_seed", std::to_string(bench::brute_force_seed));
    bench::Subjects subjects;
    if (transmittance) {
        bench::register_transmittance(data, quick);
    } else {
        bench::register_machine(quick);
        bench::register_sweeps(subjects, data, quick);
        bench::register_table_2(subjects, quick);
        bench::register_paths({LUMISWEEP_PROJECT, data}, quick);
    }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lumisweep_bench: %s\n", error.what());
        return 1;
    }
}
