// The machine's own ceilings, to hold the sweeps against: how fast this core reads, writes, multiplies and adds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace lumisweep::bench {

/// Loops that do one thing, per instruction set. Results are returned so that nothing is optimised away.
struct MachineKernels {
    const char* name;
    const char* dot_instruction;
    /// Reads [p, p + bytes) `passes` times, 64 bytes at a step; bytes is a multiple of 512.
    std::uint64_t (*read)(const std::uint8_t* p, std::size_t bytes, int passes);
    /// Writes [p, p + bytes) past the caches; p aligned to 64, bytes a multiple of 64.
    void (*stream)(std::uint8_t* p, std::size_t bytes);
    /// Sums of four products of an unsigned and a signed byte, added to 32 bits ("quads": a bilinear voxel step each).
    std::uint32_t (*dot)(std::int64_t rounds);
    int quads_per_round;
    float (*fma)(std::int64_t rounds);
    int flops_per_round;
};

/// Those that this machine runs, widest first; the last needs nothing special.
std::span<const MachineKernels> machine_kernels();

extern const MachineKernels machine_baseline;
#if defined(__x86_64__)
extern const MachineKernels machine_avx2;
extern const MachineKernels machine_avx512;
extern const MachineKernels machine_avx512_vnni;
#endif

/// Registers "machine/…" benchmarks for every instruction set that runs here.
void register_machine(bool quick);

} // namespace lumisweep::bench
