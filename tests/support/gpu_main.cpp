// Runs the tests on the GPU; without one it says so and ends with 77, for "skipped".
#include <cstdio>

#include <gtest/gtest.h>

#include "backends/emulated_device.h"
#include "lumisweep/backends/cuda/cuda_backend.h"
#include "lumisweep/base/error.h"
#include "lumisweep/render/backend.h"

// The GPU neither counts nor is told how much memory it has: what tests of that expect holds of these, too.
namespace lumisweep::test {
void set_emulated_memory(std::uint64_t) {}
void fail_allocation_after(int) {}
std::uint64_t emulated_memory_taken() { return 0; }
std::uint64_t bytes_uploaded() { return 0; }
} // namespace lumisweep::test

int main(int argc, char** argv)
{
    ::testing::InitGoogleTest(&argc, argv);
    try {
        std::printf("GPU: %s\n", lumisweep::cuda::make_cuda_backend()->isa().c_str());
    } catch (const lumisweep::Error& error) {
        std::printf("skipped: %s\n", error.what());
        return 77;
    }
    return RUN_ALL_TESTS();
}
