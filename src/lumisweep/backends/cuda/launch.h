// Kernels and their launch, for .cu files.
//
// A kernel is a struct of pointers and numbers with operator()(Block&): what one block of threads does, phase by phase.
// Within a phase threads do not see what others write; between phases they do. Under nvcc a phase is the code that each
// thread runs up to a barrier; for a plain C++ compiler it is a loop over the block's threads, so tests run the same
// kernels on the host, under sanitizers. What lives in a register from phase to phase is a PerThread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "lumisweep/backends/cuda/device.h"
#include "lumisweep/base/host_device.h"
#include "lumisweep/math/vec.h"

#if defined(__CUDACC__)
#include <cuda_pipeline_primitives.h>
#include <cuda_runtime.h>
#else
#include "lumisweep/base/aligned.h"
#include "lumisweep/base/parallel.h"
#endif

/// Before a loop whose index must be constant, because it chooses among a thread's registers.
#if defined(__CUDACC__)
#define LUMISWEEP_UNROLL _Pragma("unroll")
#else
#define LUMISWEEP_UNROLL
#endif

namespace lumisweep::LUMISWEEP_CUDA {

template <int thread_count>
class Block {
public:
    static constexpr int threads = thread_count;

    LUMISWEEP_HD Block(const Vec3i& index_in_grid, std::byte* shared_memory)
        : index(index_in_grid), shared_(shared_memory)
    {
    }

    const Vec3i index; ///< in the grid

    /// phase(thread) on all threads; then a barrier.
    template <class Phase>
    LUMISWEEP_HD void run(Phase&& phase) const
    {
#if defined(__CUDA_ARCH__)
        phase(static_cast<int>(threadIdx.x));
        __syncthreads();
#else
        for (int thread = 0; thread < thread_count; ++thread)
            phase(thread);
#endif
    }
    /// The same without the barrier: where only the thread's own data goes from one phase to the next.
    template <class Phase>
    LUMISWEEP_HD void run_apart(Phase&& phase) const
    {
#if defined(__CUDA_ARCH__)
        phase(static_cast<int>(threadIdx.x));
#else
        for (int thread = 0; thread < thread_count; ++thread)
            phase(thread);
#endif
    }

    /// The block's shared memory, aligned to 16 bytes, from byte `offset` on.
    template <class T>
    LUMISWEEP_HD T* shared(int offset = 0) const
    {
        return reinterpret_cast<T*>(shared_ + offset);
    }

private:
    std::byte* shared_;
};

/// A variable that each thread has for itself.
template <class T, int thread_count>
class PerThread {
public:
#if defined(__CUDA_ARCH__)
    LUMISWEEP_HD T& operator[](int) { return value_; }

private:
    T value_;
#else
    LUMISWEEP_HD T& operator[](int thread) { return value_[thread]; }

private:
    T value_[thread_count];
#endif
};

#if defined(__CUDACC__)

/// Throws Error for a CUDA error of a launch (device_cuda.cpp).
void check_launch(int error, const char* kernel);

template <class Kernel>
__global__ void __launch_bounds__(Kernel::threads, Kernel::blocks_a_multiprocessor)
    run_kernel(const __grid_constant__ Kernel kernel)
{
    extern __shared__ uint4 shared_memory[];
    Block<Kernel::threads> block(
        {static_cast<int>(blockIdx.x), static_cast<int>(blockIdx.y), static_cast<int>(blockIdx.z)},
        reinterpret_cast<std::byte*>(shared_memory));
    kernel(block);
}

/// Runs grid.x × grid.y × grid.z blocks (y and z at most 65535), in any order, each with `shared_bytes` of shared
/// memory. Nothing is launched for an empty grid. `name` is for errors.
template <class Kernel>
void launch(const char* name, const Stream& stream, const Vec3i& grid, int shared_bytes, const Kernel& kernel)
{
    if (grid.x <= 0 || grid.y <= 0 || grid.z <= 0)
        return;
    constexpr int without_asking = 48 * 1024;
    if (shared_bytes > without_asking)
        check_launch(
            cudaFuncSetAttribute(run_kernel<Kernel>, cudaFuncAttributeMaxDynamicSharedMemorySize, shared_bytes), name);
    run_kernel<Kernel>
        <<<dim3(static_cast<unsigned>(grid.x), static_cast<unsigned>(grid.y), static_cast<unsigned>(grid.z)),
           Kernel::threads, static_cast<std::size_t>(shared_bytes), static_cast<cudaStream_t>(stream.handle())>>>(
            kernel);
    check_launch(cudaGetLastError(), name);
}

/// Blocks of a kernel that one multiprocessor holds at a time.
template <class Kernel>
int resident_blocks(int shared_bytes)
{
    int blocks = 0;
    check_launch(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, run_kernel<Kernel>, Kernel::threads,
                                                               static_cast<std::size_t>(shared_bytes)),
                 "occupancy");
    return blocks;
}

/// Whether the build has code that the device runs.
template <class Kernel>
bool has_code()
{
    cudaFuncAttributes attributes{};
    const bool found = cudaFuncGetAttributes(&attributes, run_kernel<Kernel>) == cudaSuccess;
    cudaGetLastError();
    return found;
}

#else

template <class Kernel>
void launch(const char*, const Stream&, const Vec3i& grid, int shared_bytes, const Kernel& kernel)
{
    static_assert(Kernel::blocks_a_multiprocessor > 0);
    if (grid.x <= 0 || grid.y <= 0 || grid.z <= 0)
        return;
    const std::int64_t row = grid.x, slice = row * grid.y;
    parallel_for(std::int64_t{0}, slice * grid.z, [&](std::int64_t i) {
        // Shared memory begins with what a block before it left.
        AlignedArray<std::byte> shared(static_cast<std::size_t>(shared_bytes), Contents::uninitialised);
        std::memset(shared.data(), 0xa5, shared.size());
        const Block<Kernel::threads> block(
            {static_cast<int>(i % row), static_cast<int>(i % slice / row), static_cast<int>(i / slice)}, shared.data());
        kernel(block);
    });
}

template <class Kernel>
int resident_blocks(int)
{
    return Kernel::blocks_a_multiprocessor;
}

template <class Kernel>
bool has_code()
{
    return true;
}

#endif

// ---- what threads share ---------------------------------------------------------------------------------------------
template <class T>
LUMISWEEP_HD T atomic_add(T* to, T value)
{
#if defined(__CUDA_ARCH__)
    if constexpr (sizeof(T) == 8)
        return static_cast<T>(
            atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(value)));
    else
        return atomicAdd(to, value);
#else
    return __atomic_fetch_add(to, value, __ATOMIC_RELAXED);
#endif
}
LUMISWEEP_HD void atomic_or(std::uint32_t* to, std::uint32_t bits)
{
#if defined(__CUDA_ARCH__)
    atomicOr(to, bits);
#else
    __atomic_fetch_or(to, bits, __ATOMIC_RELAXED);
#endif
}
LUMISWEEP_HD void atomic_max(std::uint32_t* to, std::uint32_t value)
{
#if defined(__CUDA_ARCH__)
    atomicMax(to, value);
#else
    std::uint32_t held = __atomic_load_n(to, __ATOMIC_RELAXED);
    while (held < value && !__atomic_compare_exchange_n(to, &held, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
#endif
}
LUMISWEEP_HD void atomic_min(std::uint32_t* to, std::uint32_t value)
{
#if defined(__CUDA_ARCH__)
    atomicMin(to, value);
#else
    std::uint32_t held = __atomic_load_n(to, __ATOMIC_RELAXED);
    while (held > value && !__atomic_compare_exchange_n(to, &held, value, false, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
#endif
}

// ---- warps: threads that run in step; on the host a thread is alone -------------------------------------------------
#if defined(__CUDACC__)
inline constexpr int warp_width = 32;
#else
inline constexpr int warp_width = 1;
#endif

/// Threads of the warp where `on`; all of them must come here.
LUMISWEEP_HD int count_in_warp(bool on)
{
#if defined(__CUDA_ARCH__)
    return __popc(__ballot_sync(0xffffffffU, on));
#else
    return on ? 1 : 0;
#endif
}

/// Each calling thread's own number from a counter, which it moves on. Threads of a warp that call together take
/// neighbours.
LUMISWEEP_HD std::uint32_t take_number(std::uint32_t* counter)
{
#if defined(__CUDA_ARCH__)
    const unsigned active = __activemask();
    const unsigned lane = threadIdx.x % 32U;
    const int leader = __ffs(static_cast<int>(active)) - 1;
    unsigned first = 0;
    if (static_cast<int>(lane) == leader)
        first = atomicAdd(counter, static_cast<unsigned>(__popc(active)));
    return __shfl_sync(active, first, leader) + static_cast<unsigned>(__popc(active & ((1U << lane) - 1U)));
#else
    return atomic_add(counter, std::uint32_t{1});
#endif
}

// ---- copies to shared memory beside other work ----------------------------------------------------------------------
/// Copies 16 bytes, both addresses aligned to 16. It may take until wait_for_copies().
LUMISWEEP_HD void copy_16_async(void* shared, const void* global)
{
#if defined(__CUDA_ARCH__)
    __pipeline_memcpy_async(shared, global, 16);
#else
    std::memcpy(shared, global, 16);
#endif
}
/// Ends a batch of this thread's copies.
LUMISWEEP_HD void end_copies()
{
#if defined(__CUDA_ARCH__)
    __pipeline_commit();
#endif
}
/// Waits for all of this thread's batches but the last `left`. Other threads see them after a barrier.
template <int left>
LUMISWEEP_HD void wait_for_copies()
{
#if defined(__CUDA_ARCH__)
    __pipeline_wait_prior(left);
#endif
}

// ---- bytes in words -------------------------------------------------------------------------------------------------
/// sum + Σ of the products of four bytes, all without sign.
LUMISWEEP_HD std::uint32_t dot_bytes(std::uint32_t a, std::uint32_t b, std::uint32_t sum)
{
#if defined(__CUDA_ARCH__)
    return __dp4a(a, b, sum);
#else
    for (int byte = 0; byte < 32; byte += 8)
        sum += (a >> byte & 255U) * (b >> byte & 255U);
    return sum;
#endif
}
/// Four neighbouring bytes of eight, from byte `first` on, 0 … 4.
LUMISWEEP_HD std::uint32_t bytes_from(std::uint32_t low, std::uint32_t high, int first)
{
#if defined(__CUDA_ARCH__)
    return __funnelshift_rc(low, high, 8 * first);
#else
    return static_cast<std::uint32_t>((std::uint64_t{high} << 32 | low) >> (8 * first));
#endif
}

} // namespace lumisweep::LUMISWEEP_CUDA
