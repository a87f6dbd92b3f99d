#include "machine.h"

#include <algorithm>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include "lumisweep/base/aligned.h"
#include "lumisweep/base/parallel.h"

namespace lumisweep::bench {
namespace {

struct Place {
    const char* name;
    std::size_t bytes;
};

/// Memory that has been written: pages that are only read would all be one page of zeros.
AlignedArray<std::uint8_t> written(std::size_t bytes)
{
    AlignedArray<std::uint8_t> data(bytes);
    std::fill(data.begin(), data.end(), std::uint8_t{3});
    return data;
}

/// Enough passes for about 16 MB a call, so that the call itself costs nothing.
int passes_for(std::size_t bytes)
{
    return static_cast<int>(std::max<std::size_t>(1, (std::size_t{16} << 20) / bytes));
}

void read(benchmark::State& state, const MachineKernels& kernels, std::size_t bytes, std::size_t offset)
{
    const AlignedArray<std::uint8_t> data = written(bytes + 64);
    const int passes = passes_for(bytes);
    for (auto _ : state)
        benchmark::DoNotOptimize(kernels.read(data.data() + offset, bytes, passes));
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes) * passes);
}

void read_two_threads(benchmark::State& state, const MachineKernels& kernels, std::size_t bytes)
{
    const AlignedArray<std::uint8_t> data = written(bytes);
    tbb::task_arena arena(2);
    constexpr std::size_t pieces = 64;
    const std::size_t piece = bytes / pieces;
    for (auto _ : state)
        arena.execute([&] {
            parallel_for(std::size_t{0}, pieces, [&](std::size_t i) {
                benchmark::DoNotOptimize(kernels.read(data.data() + i * piece, piece, 1));
            });
        });
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}

void stream(benchmark::State& state, const MachineKernels& kernels, std::size_t bytes)
{
    AlignedArray<std::uint8_t> data = written(bytes);
    for (auto _ : state)
        kernels.stream(data.data(), bytes);
    state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}

void rate(benchmark::State& state, const char* counter, int per_round, auto run)
{
    constexpr std::int64_t rounds = 1 << 20;
    for (auto _ : state)
        benchmark::DoNotOptimize(run(rounds));
    state.counters[counter] =
        benchmark::Counter(static_cast<double>(rounds) * per_round, benchmark::Counter::kIsIterationInvariantRate);
}

} // namespace

std::span<const MachineKernels> machine_kernels()
{
    static const std::vector<MachineKernels> kernels = [] {
        std::vector<MachineKernels> found;
#if defined(__x86_64__)
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
            found.push_back(__builtin_cpu_supports("avx512vnni") ? machine_avx512_vnni : machine_avx512);
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
            found.push_back(machine_avx2);
#endif
        found.push_back(machine_baseline);
        return found;
    }();
    return kernels;
}

void register_machine(bool quick)
{
    const std::size_t dram = quick ? std::size_t{32} << 20 : std::size_t{768} << 20;
    const Place places[] = {
        {"L1", 24576}, {"L2", std::size_t{1} << 20}, {"16MB", std::size_t{16} << 20}, {"DRAM", dram}};
    const double seconds = quick ? 0.01 : 0.1;
    for (const MachineKernels& kernels : machine_kernels()) {
        const std::string prefix = std::string("machine/") + kernels.name;
        const auto add = [&](const std::string& name, auto body) {
            return benchmark::RegisterBenchmark((prefix + name).c_str(), body)
                ->MinTime(seconds)
                ->Repetitions(quick ? 1 : 3);
        };
        for (const Place& place : places)
            for (const std::size_t offset : {std::size_t{0}, std::size_t{2}})
                add(std::string("/read/") + place.name + (offset == 0 ? "/aligned" : "/unaligned"),
                    [&kernels, place, offset](benchmark::State& state) { read(state, kernels, place.bytes, offset); });
        add("/read/DRAM/threads:2", [&kernels, dram](benchmark::State& state) {
            read_two_threads(state, kernels, dram);
        })->UseRealTime();
        add("/stream/DRAM", [&kernels, dram](benchmark::State& state) { stream(state, kernels, dram); });
        add("/dot", [&kernels](benchmark::State& state) {
            rate(state, "quads_per_second", kernels.quads_per_round, kernels.dot);
            state.SetLabel(kernels.dot_instruction);
        });
        add("/fma", [&kernels](benchmark::State& state) {
            rate(state, "flops_per_second", kernels.flops_per_round, kernels.fma);
        });
    }
}

} // namespace lumisweep::bench
