#include "lumisweep/visibility/sweep_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace lumisweep {
namespace {

std::vector<const SweepKernels*> wider_kernels()
{
    std::vector<const SweepKernels*> kernels;
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        kernels.push_back(&sweep_kernels_avx2);
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
        kernels.push_back(&sweep_kernels_avx512);
#endif
    return kernels;
}

struct Row {
    std::vector<std::int32_t> tau = std::vector<std::int32_t>(201, 1000);
    std::vector<std::int32_t> visibility = std::vector<std::int32_t>(200);
};

Row run(const SweepKernels& kernels)
{
    std::mt19937 random(9);
    std::uniform_int_distribution<int> byte(0, 255);
    std::vector<std::uint8_t> low(202), high(202);
    for (std::size_t i = 0; i < low.size(); ++i) {
        low[i] = static_cast<std::uint8_t>(byte(random));
        high[i] = static_cast<std::uint8_t>(byte(random));
    }
    Row row;
    std::vector<std::uint16_t> mixed(202);
    for (const int weight : {0, 1, 100, 256}) {
        kernels.mix_rows(mixed.data(), low.data(), high.data(), weight, 202);
        kernels.advance_rays(row.tau.data(), mixed.data(), 60000, 5535, 201);
    }
    std::vector<float> tau(201), length(201), enter(201), leave(201), fraction(200), scratch(200);
    std::vector<std::int32_t> ray(200);
    for (std::size_t i = 0; i < 201; ++i) {
        enter[i] = static_cast<float>(i) * 0.11F - 5.0F;
        leave[i] = static_cast<float>(i) * 0.13F;
    }
    for (std::size_t i = 0; i < 200; ++i) {
        ray[i] = static_cast<std::int32_t>(i);
        fraction[i] = static_cast<float>(byte(random)) / 256.0F;
    }
    kernels.mix_rays(tau.data(), row.tau.data(), row.tau.data(), 0.3F, 201);
    const float row_enter[2] = {-1.0F, 2.0F}, row_leave[2] = {30.0F, 18.5F};
    kernels.mix_lengths(length.data(), enter.data(), leave.data(), row_enter, row_leave, 20.25F, 0.7F, 201);
    const LookupRow lookup{tau.data(),   length.data(), ray.data(), fraction.data(), enter.data(),
                           leave.data(), -3.0F,         19.0F,      3e-5F,           200};
    kernels.look_up(row.visibility.data(), lookup, 20.25F, scratch.data());
    return row;
}

TEST(SweepKernels, EveryInstructionSetGivesTheSameBits)
{
    const Row expected = run(sweep_kernels_baseline);
    for (const SweepKernels* kernels : wider_kernels()) {
        const Row row = run(*kernels);
        EXPECT_EQ(row.tau, expected.tau) << kernels->name;
        EXPECT_EQ(row.visibility, expected.visibility) << kernels->name;
    }
}

TEST(SweepKernels, AdvanceIsBilinear)
{
    const std::vector<std::uint8_t> low{10, 50, 255}, high{200, 0, 255};
    std::vector<std::uint16_t> mixed(3);
    std::vector<std::int32_t> tau(2, 0);
    sweep_kernels_baseline.mix_rows(mixed.data(), low.data(), high.data(), 64, 3);
    sweep_kernels_baseline.advance_rays(tau.data(), mixed.data(), 16384, 49152, 2);
    EXPECT_NEAR(tau[0], 256.0 * (0.25 * (0.75 * 10 + 0.25 * 200) + 0.75 * 0.75 * 50), 2.0);
    EXPECT_NEAR(tau[1], 256.0 * (0.25 * (0.75 * 50) + 0.75 * 255), 2.0);
}

TEST(SweepKernels, LookupIsTheExponential)
{
    const float length[2] = {1.0F, 1.0F}, fraction = 0.0F, enter = -1e9F, leave = 1e9F;
    const std::int32_t ray = 0;
    for (double depth = 0.0; depth < 100.0; depth += 0.37) {
        const float tau[2] = {static_cast<float>(depth), 0.0F};
        const LookupRow row{tau, length, &ray, &fraction, &enter, &leave, -1e9F, 1e9F, 1.0F, 1};
        std::int32_t visibility = -1;
        float scratch = 0.0F;
        sweep_kernels_baseline.look_up(&visibility, row, 1.0F, &scratch);
        EXPECT_NEAR(visibility, 65535.0 * std::exp(-depth), 0.6) << depth;
    }
}

} // namespace
} // namespace lumisweep
