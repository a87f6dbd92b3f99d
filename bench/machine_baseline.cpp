#include <cstring>

#include "machine.h"

namespace lumisweep::bench {
namespace {

std::uint64_t read(const std::uint8_t* p, std::size_t bytes, int passes)
{
    std::uint64_t bits[8] = {};
    for (int pass = 0; pass < passes; ++pass)
        for (const std::uint8_t* q = p; q < p + bytes; q += 64) {
            std::uint64_t words[8];
            std::memcpy(words, q, sizeof words);
            for (int i = 0; i < 8; ++i)
                bits[i] |= words[i] + static_cast<std::uint64_t>(pass);
        }
    for (int i = 1; i < 8; ++i)
        bits[0] |= bits[i];
    return bits[0];
}

void stream(std::uint8_t* p, std::size_t bytes) { std::memset(p, 5, bytes); }

constexpr int chains = 16;

std::uint32_t dot(std::int64_t rounds)
{
    std::uint32_t sums[chains] = {};
    for (std::int64_t round = 0; round < rounds; ++round)
        for (int i = 0; i < chains; ++i) {
            // Bytes that change with the round, so that no product can be hoisted.
            const auto x = static_cast<std::uint32_t>(round) + static_cast<std::uint32_t>(i);
            sums[i] += (x & 255U) * 2U + (x >> 8 & 255U) * 3U + (x >> 16 & 255U) * 5U + (x >> 24) * 7U;
        }
    for (int i = 1; i < chains; ++i)
        sums[0] += sums[i];
    return sums[0];
}

float fma(std::int64_t rounds)
{
    float sums[chains] = {};
    volatile float factor = 0.5F;
    const float a = factor, b = 0.25F;
    for (std::int64_t round = 0; round < rounds; ++round)
        for (float& s : sums)
            s = s * a + b;
    for (int i = 1; i < chains; ++i)
        sums[0] += sums[i];
    return sums[0];
}

} // namespace

const MachineKernels machine_baseline = {"baseline", "integer multiplies", read, stream, dot, chains, fma, 2 * chains};

} // namespace lumisweep::bench
