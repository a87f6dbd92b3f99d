// The emulated device itself: what tests of kernels stand on.
#include "lumisweep/backends/cuda/device.h"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "backends/emulated_device.h"
#include "lumisweep/backends/cuda/launch.h"
#include "lumisweep/base/error.h"

namespace lumisweep::LUMISWEEP_CUDA {
namespace {

/// Turns each run of 64 numbers around, through shared memory.
struct Reversal {
    static constexpr int threads = 64, blocks_a_multiprocessor = 1;
    const int* in;
    int* out;

    LUMISWEEP_HD void operator()(const Block<threads>& block) const
    {
        int* shared = block.shared<int>();
        PerThread<int, threads> held;
        block.run([&](int thread) {
            held[thread] = in[block.index.x * threads + thread];
            shared[thread] = held[thread];
        });
        block.run(
            [&](int thread) { out[block.index.x * threads + thread] = shared[threads - 1 - thread] + held[thread]; });
    }
};

TEST(EmulatedDevice, RunsAKernelPhaseByPhase)
{
    const Stream stream;
    std::vector<int> numbers(640), back(640);
    std::iota(numbers.begin(), numbers.end(), 0);
    DeviceArray<int> in, out(640, "numbers");
    in.upload(numbers, "numbers", stream);
    launch("reversal", stream, {10, 1, 1}, 64 * sizeof(int), Reversal{in.data(), out.data()});
    out.download(back, stream);
    stream.wait();
    for (int i = 0; i < 640; ++i)
        ASSERT_EQ(back[static_cast<std::size_t>(i)], i / 64 * 64 + 63 - i % 64 + i);
}

TEST(EmulatedDevice, HasOnlySoMuchMemory)
{
    const std::uint64_t before = test::emulated_memory_taken();
    test::set_emulated_memory(before + 1000);
    {
        const DeviceArray<std::uint8_t> fits(500, "five hundred bytes");
        EXPECT_THROW(DeviceArray<std::uint8_t>(500, "five hundred more"), Error);
    }
    EXPECT_EQ(test::emulated_memory_taken(), before);
    test::set_emulated_memory(std::uint64_t{1} << 40);
}

TEST(EmulatedDevice, CountsWhatIsUploaded)
{
    const Stream stream;
    const std::uint64_t before = test::bytes_uploaded();
    DeviceArray<float> array;
    array.upload(std::vector<float>(25), "floats", stream);
    EXPECT_EQ(test::bytes_uploaded() - before, 100U);
}

TEST(Words, FourBytesOfEight)
{
    EXPECT_EQ(bytes_from(0x03020100U, 0x07060504U, 0), 0x03020100U);
    EXPECT_EQ(bytes_from(0x03020100U, 0x07060504U, 3), 0x06050403U);
    EXPECT_EQ(bytes_from(0x03020100U, 0x07060504U, 4), 0x07060504U);
    EXPECT_EQ(dot_bytes(0xff010203U, 0x7f040506U, 7U), 255U * 127U + 4U + 10U + 18U + 7U);
}

} // namespace
} // namespace lumisweep::LUMISWEEP_CUDA
